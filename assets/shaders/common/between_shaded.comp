// Light of the pixels between those that were shaded (common/surface_tiles.glsl, SHADE_PX 2), from the shaded ones around.
// Only neighbours as far away count, so that outlines stay as sharp as the mesh draws them; where there is none, the
// pixel keeps what its block shows.
//
//   SURFACE        of the pixels
//   SCENE_FORMAT   of u_radiance
#include "common/surfaces.glsl"
#include "common/spread.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];   // the indirect dispatch
    uint tiles[];          // x | y << 16
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 3) uniform usampler2D u_surface;
layout(binding = 0, SCENE_FORMAT) uniform image2D u_radiance;

const float ALIKE = 0.75;   // ratio of depths: ground eight pixels below its horizon changes by so much in two

void main() {
    uint tile = tiles[spread_tiles()];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * ivec2(16, 8) + ivec2(gl_LocalInvocationID.xy);
    ivec2 size = textureSize(u_surface, 0), block = pixel & ~1, within = pixel & 1;
    if (within == ivec2(0) || any(greaterThanEqual(pixel, size))) return;
    if (texelFetch(u_surface, pixel, 0).r != SURFACE || texelFetch(u_surface, block, 0).r != SURFACE) return;
    float depth = texelFetch(u_depth, pixel, 0).r;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1), at = block + 2 * step;
        // Half way between two, or in the middle of four.
        bool counts = all(lessThanEqual(step, within)) && all(lessThan(at, size));
        at = min(at, size - 1);
        float there = texelFetch(u_depth, at, 0).r;
        counts = counts && texelFetch(u_surface, at, 0).r == SURFACE && min(there, depth) >= ALIKE * max(there, depth);
        sum += counts ? vec4(imageLoad(u_radiance, at).rgb, 1.0) : vec4(0.0);
    }
    if (sum.a > 0.0) imageStore(u_radiance, pixel, vec4(sum.rgb / sum.a, 1.0));
}
