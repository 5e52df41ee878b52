// Heights of new texels of one level: the surface that casts shadows, ground or sea.
#include "common/camera.glsl"
#include "contract/surface_height.glsl"
#include "shadows/clipmap.glsl"

layout(local_size_x = 16, local_size_y = 4) in;
layout(binding = 0, r32f) writeonly uniform image2DArray u_heights;
uniform ivec2 u_corner;   // of the new texels in the window
uniform ivec2 u_size;     // how many there are
uniform int u_level;

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(index, u_size))) return;
    index += u_corner;
    ShadowFoot foot = shadow_foot(u_level, vec2(index));
    float spacing = 2.0 * shadow_map.radius_m / (shadow_frequency(u_level) * foot.bulge);
    float height = max(surface_height(foot.D, spacing), shadow_map.sea_level_m);
    imageStore(u_heights, shadow_texel(u_level, index), vec4(height));
}
