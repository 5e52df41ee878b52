// Which of the sea's pixels ocean/shade.comp shades, by blocks: the same as find_shown() of common/surface_tiles.glsl.
// Turns go through a block's pixels, from the one that is shaded wherever it shows the sea.
#ifndef SHADE_EVERY
#define SHADE_EVERY 1
#endif
#if SHADE_EVERY > 1
#include "contract/waterline.glsl"
#endif

const ivec2 SEA_APART = ivec2(SHADE_EVERY > 1 ? 2 : 1, SHADE_EVERY > 2 ? 2 : 1);

ivec2 sea_of_block(ivec2 block, uint turn) {
#if SHADE_EVERY == 2
    return block + ivec2((block.y + frame.checkerboard + int(turn)) & 1, 0);
#else
    return block + ivec2(turn & 1u, turn >> 1);
#endif
}

#if SHADE_EVERY > 1
// Bits: turns of the first pixel that shows the sea from above and of the first that shows it from below. Each is
// shaded.
uint sea_turns(ivec2 block) {
    uint turns = 0u;
    bool above = false, below = false;
    for (uint turn = 0u; turn < uint(SHADE_EVERY); ++turn) {
        ivec2 pixel = sea_of_block(block, turn);
        bool sea = sea_at(pixel), under = lens_in_water(ndc_of_pixel(vec2(pixel) + 0.5));
        if (sea && !(under ? below : above)) turns |= 1u << turn;
        below = below || (sea && under);
        above = above || (sea && !under);
    }
    return turns;
}
#endif
