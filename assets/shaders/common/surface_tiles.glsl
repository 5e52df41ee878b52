// Shading of one surface's pixels in compute, over the tiles of the picture that show it: a workgroup a tile, 16 x 8 pixels.
// gbuffer/classify.comp makes the lists; pixels of other surfaces in a tile are left alone.
//
//   SHADE_PX   1: each pixel is shaded; 2: one of a block of 2 x 2, the others are left to common/between_shaded.comp
//   SHOWS_ALSO(pixel)   what a pixel has to be besides
#include "common/surfaces.glsl"
#include "common/spread.glsl"
#include "common/texel.glsl"

#ifndef SHADE_PX
#define SHADE_PX 1
#endif
#ifndef SHOWS_ALSO
#define SHOWS_ALSO(pixel) true
#endif
#if SHADE_PX == 2
layout(local_size_x = 8, local_size_y = 4) in;
#else
layout(local_size_x = 16, local_size_y = 8) in;
#endif
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];   // the indirect dispatch
    uint tiles[];          // x | y << 16
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_normal;
layout(binding = 2) uniform sampler2D u_attributes;
layout(binding = 3) uniform usampler2D u_surface;
layout(binding = 0) writeonly uniform image2D u_radiance;

// The first pixel of this invocation's block.
ivec2 tile_pixel() {
    uint tile = tiles[spread_tiles()];
    return ivec2(tile & 0xffffu, tile >> 16) * ivec2(16, 8) + SHADE_PX * ivec2(gl_LocalInvocationID.xy);
}

bool shows(ivec2 pixel, uint surface) {
    return all(lessThan(pixel, textureSize(u_surface, 0))) && texel_at(u_surface, pixel).r == surface
        && SHOWS_ALSO(pixel);
}

// From the block's first pixel to the first that shows the surface; false where none does.
bool find_shown(inout ivec2 pixel, uint surface) {
#if SHADE_PX == 2
    ivec2 first = pixel;
    bool found = false;
    for (int i = 3; i >= 0; --i) {
        ivec2 other = first + ivec2(i & 1, i >> 1);
        bool there = shows(other, surface);
        pixel = there ? other : pixel;
        found = found || there;
    }
    return found;
#else
    return shows(pixel, surface);
#endif
}
