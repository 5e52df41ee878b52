// Shading of one surface's pixels in compute, over the tiles of the picture that show it: a workgroup a tile.
// gbuffer/classify.comp makes the lists; pixels of other surfaces in a tile are left alone.
//
//   SHADE_EVERY   1: each pixel is shaded; 2: every second, as the squares that frame.checkerboard names; 4: one of
//                 a block of 2 x 2. The others are left to common/upsample_shaded.comp
//   RADIANCE_READ   format of u_radiance, for who changes the light that is there
//   SHOWS_ALSO(pixel)   what a pixel has to be besides
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"
#include "common/spread.glsl"
#include "generated/frame.glsl"
#include "common/texel.glsl"

#ifndef SHADE_EVERY
#define SHADE_EVERY 1
#endif
#ifndef SHOWS_ALSO
#define SHOWS_ALSO(pixel) true
#endif
#if SHADE_EVERY == 4
layout(local_size_x = HALF_TILE_WIDTH, local_size_y = HALF_TILE_HEIGHT) in;
#elif SHADE_EVERY == 2
layout(local_size_x = HALF_TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
#else
layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
#endif
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];   // the indirect dispatch
    uint tiles[];          // x | y << 16
};
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = NORMAL_UNIT) uniform sampler2D u_normal;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
#ifdef RADIANCE_READ
layout(binding = RADIANCE_IMAGE, RADIANCE_READ) uniform image2D u_radiance;
#else
layout(binding = RADIANCE_IMAGE) writeonly uniform image2D u_radiance;
#endif

// The first pixel of this invocation's block.
ivec2 tile_pixel() {
    uint tile = tiles[spread_tiles()];
    ivec2 apart = ivec2(SHADE_EVERY > 1 ? 2 : 1, SHADE_EVERY > 2 ? 2 : 1);
    return ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + apart * ivec2(gl_LocalInvocationID.xy);
}

bool shows(ivec2 pixel, uint surface) {
    return all(lessThan(pixel, textureSize(u_surface, 0))) && texel_at(u_surface, pixel).r == surface
        && SHOWS_ALSO(pixel);
}

// How often each lane shades a pixel. A loop of so many turns, left at its end, costs a software GPU nothing where it
// is one.
#if SHADE_EVERY == 2
#define SHADE_TURNS (frame.checkerboard < 0 ? 2 : 1)
#else
#define SHADE_TURNS 1
#endif

// From the block's first pixel to the one that is shaded in this turn; false where none is. That is the first that
// shows the surface, but on a checkerboard the black one of two if it does, or both of them, one after the other.
bool find_shown(inout ivec2 pixel, int turn, uint surface) {
#if SHADE_EVERY == 4
    ivec2 first = pixel;
    bool found = false;
    for (int i = 3; i >= 0; --i) {
        ivec2 other = first + ivec2(i & 1, i >> 1);
        bool there = shows(other, surface);
        pixel = there ? other : pixel;
        found = found || there;
    }
    return found;
#elif SHADE_EVERY == 2
    int black = frame.checkerboard < 0 ? turn : (pixel.y + frame.checkerboard) & 1;
    ivec2 other = pixel + ivec2(1 - black, 0);
    pixel.x += black;
    bool found = shows(pixel, surface), second = shows(other, surface) && frame.checkerboard >= 0;
    pixel = found ? pixel : other;
    return found || second;
#else
    return shows(pixel, surface);
#endif
}
