// Tiles that show a prop, or ground or water that a prop reaches, as a list behind its indirect dispatch. One
// workgroup.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer PropBuffer { uint prop_groups[4]; uint prop_tiles[]; };
layout(std430, binding = 2) readonly buffer TouchedBuffer { uint touched[]; };
uniform ivec2 u_tiles;

shared uint s_count;

const uint SHADED = 1u << SURFACE_TERRAIN | 1u << SURFACE_SEA;

void main() {
    if (gl_LocalInvocationIndex == 0u) s_count = 0u;
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        uint place = tile % uint(u_tiles.x) | tile / uint(u_tiles.x) << 16;
        bool shown = (flags[tile] >> SURFACE_PROPS & 1u) != 0u;
        if (shown || ((flags[tile] & SHADED) != 0u && touched[tile] != 0u)) {
            prop_tiles[atomicAdd(s_count, 1u)] = place;
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        prop_groups[0] = s_count;
        prop_groups[1] = 1u;
        prop_groups[2] = 1u;
    }
}
