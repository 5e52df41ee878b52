// Shading of one surface's pixels in compute, over the tiles of the picture that show it: a workgroup a tile, 16 x 8 pixels.
// gbuffer/classify.comp makes the lists; pixels of other surfaces in a tile are left alone.
#include "common/surfaces.glsl"
#include "common/spread.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];   // the indirect dispatch
    uint tiles[];          // x | y << 16
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_normal;
layout(binding = 2) uniform sampler2D u_attributes;
layout(binding = 3) uniform usampler2D u_surface;
layout(binding = 0) writeonly uniform image2D u_radiance;

ivec2 tile_pixel() {
    uint tile = tiles[spread_tiles()];
    return ivec2(tile & 0xffffu, tile >> 16) * ivec2(16, 8) + ivec2(gl_LocalInvocationID.xy);
}
