// The tiles of each kind of sea as a list behind its indirect dispatch. One workgroup for the whole picture.
#include "generated/bindings.glsl"
#include "common/camera.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer OpenBuffer { uint open_groups[4]; uint open_tiles[]; };
layout(std430, binding = 2) writeonly buffer MirrorBuffer { uint mirror_groups[4]; uint mirror_tiles[]; };
layout(std430, binding = 3) writeonly buffer RichBuffer { uint rich_groups[4]; uint rich_tiles[]; };
layout(std430, binding = 5) writeonly buffer BelowBuffer { uint below_groups[4]; uint below_tiles[]; };
layout(std430, binding = 6) writeonly buffer LimbBuffer { uint limb_groups[4]; uint limb_tiles[]; };
// of ocean/light.comp and ocean/sky.comp
layout(std430, binding = 7) writeonly buffer LightBuffer { uint light_groups[6]; };
uniform ivec2 u_tiles;
// where any sea is seen
uniform ivec2 u_light_groups;
uniform ivec2 u_sky_groups;

const float MIRROR_HIGHEST_M = 2.0e4;   // from higher up the sea mirrors no ground that one could make out
const int COLUMNS = 1024;               // 16 384 pixels; columns beyond share with others

shared uint s_open, s_mirror, s_rich, s_below, s_limb;
shared int s_ground[COLUMNS];           // the highest row of a column that shows ground

void main() {
    for (int i = int(gl_LocalInvocationIndex); i < COLUMNS; i += 256) s_ground[i] = -1;
    if (gl_LocalInvocationIndex == 0u) {
        s_open = 0u;
        s_mirror = 0u;
        s_rich = 0u;
        s_below = 0u;
        s_limb = 0u;
    }
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y), width = uint(u_tiles.x);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        if ((flags[tile] & 16u) != 0u) atomicMax(s_ground[(tile % width) & uint(COLUMNS - 1)], int(tile / width));
    }
    barrier();
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        int column = int(tile % width), row = int(tile / width), highest = -1;
        // Waves turn rays aside, some tiles to either side.
        for (int c = max(column - 4, 0); c <= min(column + 4, u_tiles.x - 1); ++c)
            highest = max(highest, s_ground[c & (COLUMNS - 1)]);
        uint place = uint(column) | uint(row) << 16, found = flags[tile];
        bool mirrors = highest >= row && frame.camera_altitude_m < MIRROR_HIGHEST_M;
        bool limb = (found & 32u) != 0u;
        if ((found & 1u) != 0u && !mirrors && limb) limb_tiles[atomicAdd(s_limb, 1u)] = place;
        if ((found & 1u) != 0u && !mirrors && !limb) open_tiles[atomicAdd(s_open, 1u)] = place;
        if ((found & 1u) != 0u && mirrors) mirror_tiles[atomicAdd(s_mirror, 1u)] = place;
        if ((found & 4u) != 0u) rich_tiles[atomicAdd(s_rich, 1u)] = place;
        if ((found & 8u) != 0u) below_tiles[atomicAdd(s_below, 1u)] = place;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        open_groups[0] = s_open;
        open_groups[1] = 1u;
        open_groups[2] = 1u;
        mirror_groups[0] = s_mirror;
        mirror_groups[1] = 1u;
        mirror_groups[2] = 1u;
        rich_groups[0] = s_rich;
        rich_groups[1] = 1u;
        rich_groups[2] = 1u;
        below_groups[0] = s_below;
        below_groups[1] = 1u;
        below_groups[2] = 1u;
        limb_groups[0] = s_limb;
        limb_groups[1] = 1u;
        limb_groups[2] = 1u;
        bool some = s_open + s_mirror + s_rich + s_below + s_limb > 0u;
        light_groups[0] = some ? uint(u_light_groups.x) : 0u;
        light_groups[1] = some ? uint(u_light_groups.y) : 0u;
        light_groups[2] = 1u;
        light_groups[3] = some ? uint(u_sky_groups.x) : 0u;
        light_groups[4] = some ? uint(u_sky_groups.y) : 0u;
        light_groups[5] = 1u;
    }
}
