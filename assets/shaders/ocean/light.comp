// Light on the sea at the corners of the picture's tiles, where the line of sight meets the calm sea or passes it
// nearest, and the air before it: five maps, one below the other. They change little from tile to tile, and pixels
// interpolate.
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "common/surfaces.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "contract/land_water.glsl"
#ifdef LAND_WATER
#include "ocean/land_water_light.glsl"
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) writeonly uniform image2D u_light_out;

const float NEAREST_AIR_M = 100.0;
// Falls are as steep as shadows are coarse: a corner whose point hides from the sun by less would darken a whole tile.
const float LIFTED_M = 4.0;
const float STARLIGHT = 1.5e-8;   // of the sun's irradiance: 2e-3 lx of stars and airglow on a moonless night

void main() {
    ivec2 corner = ivec2(gl_GlobalInvocationID.xy), corners = imageSize(u_light_out) / ivec2(1, 5);
    if (any(greaterThanEqual(corner, corners))) return;
    vec3 direction = normalize(view_ray(ndc_of_pixel(vec2(corner * TILE_PX))));
    float h = frame.camera_altitude_m - planet.sea_level_m, r = planet.radius_m + planet.sea_level_m;
    float b = (r + h) * dot(direction, frame.camera_zenith), c = h * (2.0 * r + h), meets = b * b - c;
    float q = -b + (b < 0.0 ? 1.0 : -1.0) * sqrt(max(meets, 0.0));
    float hit = c > 0.0 ? (b < 0.0 ? c / max(q, 1e-20) : 0.0) : max(q, c / (abs(q) > 1e-20 ? q : 1e-20));
    vec3 point = direction * max(meets >= 0.0 ? hit : -b, 0.0);
#ifdef LAND_WATER
    float lifted_m = 0.0;
    if (land_water_near(corner, point)) {
        direction = normalize(point);
        lifted_m = LIFTED_M;
    }
#endif
    vec3 zenith = up_at(point), sun = frame.sun_direction, lit = point;
#ifdef LAND_WATER
    lit += zenith * lifted_m;
#endif
    vec3 sunlight = frame.sun_irradiance * sun_visibility(lit) * air_to_space(point, sun);
    vec3 starlight = frame.sun_irradiance * STARLIGHT, from_sky = skylight(point, zenith) + starlight;
    // The sky is known as the camera sees it: what lies between the sea and a camera up high is missing, and its mean
    // comes from how much more skylight there is down here.
    vec3 missing = max(sky_irradiance(point, zenith) + starlight - sky_irradiance(vec3(0.0), frame.camera_zenith),
        0.0) / PI;
    imageStore(u_light_out, corner, vec4(sunlight, 0.0));
    imageStore(u_light_out, corner + ivec2(0, corners.y), vec4(from_sky, 0.0));
    imageStore(u_light_out, corner + ivec2(0, 2 * corners.y), vec4(missing, 0.0));
    // The air's mean extinction and source, which hang on the direction: a pixel knows its distance. Not from too near,
    // where both would be differences of rounded numbers.
    float distance_m = max(length(point), NEAREST_AIR_M);
    Air between = air_from_camera(direction * distance_m);
    vec3 left = clamp(between.transmittance, 1e-30, 1.0);
    imageStore(u_light_out, corner + ivec2(0, 3 * corners.y), vec4(-log(left) / distance_m, 0.0));
    imageStore(u_light_out, corner + ivec2(0, 4 * corners.y), vec4(between.in_scatter / max(1.0 - left, 1e-7), 0.0));
}
