// The light on each fall's spray, and the air before it: both change little from pixel to pixel.
// SPRAY_ROW: numbers of a fall, as terrain/spray.vert has them.
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "contract/air.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "generated/bindings.glsl"
#include "terrain/spray.glsl"

layout(local_size_x = 8) in;
layout(std430, binding = SPRAY_BUFFER) readonly buffer RowBuffer { float rows[]; };
layout(std430, binding = SPRAY_LIGHT_BUFFER) writeonly buffer LightBuffer { SprayLight lights[]; };
uniform int u_count;

const float SCATTERED = 0.98;       // albedo of droplets
const float WHITE = 0.72;           // of spray through which nothing is seen
const float NEAREST_AIR_M = 100.0;  // from nearer the air's numbers would be differences of rounded ones

void main() {
    int number = int(gl_GlobalInvocationID.x), k = SPRAY_ROW * number;
    if (number >= u_count) return;
    vec3 foot = vec3(rows[k], rows[k + 1], rows[k + 2]), up = vec3(rows[k + 4], rows[k + 5], rows[k + 6]);
    vec3 way = vec3(rows[k + 8], rows[k + 9], rows[k + 10]);
    float height = rows[k + 7];
    // Lit half by what reaches its pool and half by what reaches its top.
    vec3 pool = foot + 0.4 * height * way, sun = frame.sun_direction;
    float seen = 0.5 * (sun_visibility(pool + 0.3 * height * up) + sun_visibility(pool + 0.8 * height * up));
    SprayLight light;
    light.beam = vec4(frame.sun_irradiance * seen * air_to_space(pool, sun), 0.0);
    float above = max(dot(sun, up), 0.0);
    vec3 sky = skylight(pool, up);
    // The sky above, and below it water that throws back some of the sun.
    light.diffuse = vec4(SCATTERED * (sky + 0.3 * above * light.beam.rgb) / (2.0 * PI), 0.0);
    light.dense = vec4(WHITE * (light.beam.rgb * max(0.25 + 0.75 * above, 0.0) + sky) / PI, 0.0);
    float away_m = length(pool), distance_m = max(away_m, NEAREST_AIR_M);
    Air between = air_from_camera(pool * (distance_m / max(away_m, 1e-3)));
    vec3 left = clamp(between.transmittance, 1e-30, 1.0);
    light.loss = vec4(-log(left) / distance_m, 0.0);
    light.air = vec4(between.in_scatter / max(1.0 - left, 1e-7), 0.0);
    lights[number] = light;
}
