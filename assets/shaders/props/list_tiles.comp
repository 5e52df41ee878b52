// Tiles that show a prop, or ground from which a prop takes light, as a list behind its indirect dispatch. One workgroup.
#include "common/surfaces.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer PropBuffer { uint prop_groups[4]; uint prop_tiles[]; };
layout(binding = 0) uniform sampler2D u_shadow;
uniform ivec2 u_tiles;

shared uint s_count;

void main() {
    if (gl_LocalInvocationIndex == 0u) s_count = 0u;
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y);
    ivec2 size = textureSize(u_shadow, 0);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        ivec2 place = ivec2(tile % uint(u_tiles.x), tile / uint(u_tiles.x)), first = place * ivec2(16, 8);
        ivec2 last = min(first + ivec2(16, 8), size);
        bool shown = (flags[tile] >> SURFACE_PROPS & 1u) != 0u;
        bool ground = (flags[tile] >> SURFACE_TERRAIN & 1u) != 0u;
        for (int y = first.y; y < last.y && ground && !shown; ++y) {
            for (int x = first.x; x < last.x && !shown; ++x) {
                vec2 left = texelFetch(u_shadow, ivec2(x, y), 0).rg;
                shown = min(left.r, left.g) < 0.998;
            }
        }
        if (shown) prop_tiles[atomicAdd(s_count, 1u)] = uint(place.x) | uint(place.y) << 16;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        prop_groups[0] = s_count;
        prop_groups[1] = 1u;
        prop_groups[2] = 1u;
    }
}
