// Water between the lens and whatever a pixel shows, where the lens is in it; and the line where the water's edge lies
// on the lens.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/lens_edge.glsl"
#include "common/surfaces.glsl"
#include "common/texel.glsl"
#include "contract/waterline.glsl"
#include "ocean/look/murk.glsl"

layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(binding = RADIANCE_IMAGE, SCENE_FORMAT) uniform image2D u_radiance;
layout(std430, binding = LENS_BUFFER) readonly buffer LensBuffer { WaterSun lens; };   // ocean/under_light.comp

uniform int u_first_row;   // of those that may have water before them (systems/ocean/lens.py)

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, u_first_row), size = textureSize(u_depth, 0);
    vec2 ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    if (any(greaterThanEqual(pixel, size))) return;
    // A film of water climbs up the glass: dark where it bends light away, two pixels to either side.
    vec3 ray = view_ray(ndc);
    float over = lens_over_water(ndc);
    float depth = texel_at(u_depth, pixel).r;
    uint surface = texel_at(u_surface, pixel).r;
    // The plane and the drawn waves differ by a millimetre, which is a few pixels on the lens: what shows the sea on
    // edge there, or a bed that the sea should hide, counts as seen through water.
    bool bed = surface != SURFACE_SEA && depth > 0.0
        && altitude_of(position_from_depth(ndc, max(depth, 1e-30))) < planet.sea_level_m - 1.0;
    bool edge = over >= 0.0 && ((surface == SURFACE_SEA && over < 1.5) || (bed && over < WATERLINE_PX));
    if (over > 2.5 && !edge) return;
    vec4 stored = imageLoad(u_radiance, pixel);
    vec3 radiance = stored.rgb * frame.radiance_per_hdr;
    vec3 direction = normalize(ray);
    float rise = dot(direction, frame.camera_zenith), deep = max(planet.sea_level_m - frame.camera_altitude_m, 0.0);
    float path = depth > 0.0 ? length(ray) * forward_distance(depth) : 1e5;
    path = rise > 1e-4 ? min(path, (deep + 2.0) / rise) : path;   // waves: a little beyond the still surface
    WaterSun sun = lens;
    vec3 through = water_left(path);
    radiance = edge && surface == SURFACE_SEA ? vec3(0.0) : radiance;
    vec3 wet = radiance * (depth > 0.0 ? through : vec3(0.0))
        + water_murk(sun, deep, rise, path, dot(direction, sun.to_sun));
    wet += ocean.glow_radiance * (1.0 - through);
    float line = smoothstep(2.5, 0.5, abs(over));
    vec3 seen = over < 0.0 || edge ? wet : radiance;
    imageStore(u_radiance, pixel, vec4(seen * (1.0 - 0.7 * line) * frame.hdr_per_radiance, stored.a));
}
