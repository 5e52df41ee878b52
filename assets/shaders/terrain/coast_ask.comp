// The line between land and water, pixel by pixel: the meshes meet along straight edges some pixels long, the height
// function knows better. Pixels change sides in the G-buffer before anything is shaded. terrain/coast_find.comp lists
// them.
//
// Define COAST_STEP: 2 asks once for each block of 2 x 2.
#include "terrain/coast_pixel.glsl"
#include "terrain/coast_asked.glsl"

#if COAST_STEP == 2
// How far depth may be from linear on screen, relative, before pixels of a block count as parts of different ground.
const float RIDGE = 0.005;

CoastPixel block_pixel(ivec2 pixel) {
    ivec2 last = textureSize(u_surface, 0) - 1;
    CoastPixel p = coast_pixel(min(pixel, last));
    p.open = p.open && all(lessThanEqual(pixel, last));
    return p;
}

// Position and distance, where it counts.
vec4 block_place(CoastPixel p) {
    return p.open ? vec4(p.D, length(p.point)) : vec4(0.0);
}

void ask_pixel(ivec2 pixel, CoastPixel p, TerrainPoint terrain, vec3 middle, bool ridge) {
    float height = frame.anchor_height_m + terrain.dh + dot(terrain.gradient, p.D - middle);
    float above = height - planet.sea_level_m;
    bool asks = p.open && !(ridge && p.surface == SURFACE_TERRAIN);
    if (asks && above < 0.0) coast_to_sea(pixel, p, -above);
    if (asks && above >= 0.0 && p.surface == SURFACE_SEA)
        coast_to_land(pixel, p, terrain.gradient, above, terrain_attributes(terrain, height, p.spacing).xyz);
}

// One height and its gradient for a block of 2 x 2 pixels. No array of them: software GPUs take long to find a place in
// one.
void ask_block(ivec2 first) {
    CoastPixel p = block_pixel(first), right = block_pixel(first + ivec2(1, 0));
    CoastPixel down = block_pixel(first + ivec2(0, 1)), across = block_pixel(first + 1);
    vec4 place = block_place(p) + block_place(right) + block_place(down) + block_place(across);
    float open = float(p.open) + float(right.open) + float(down.open) + float(across.open);
    place /= max(open, 1.0);
    TerrainPoint terrain = terrain_point(place.xyz, COAST_FINEST_PX * float(COAST_STEP) * place.w * frame.pixel_rad);
    // Along a plane depth is linear on screen. Where it is not, the pixels lie before and behind a ridge, and the
    // middle between them is on neither: what was drawn as land stays land.
    bool ridge = abs(p.depth + across.depth - right.depth - down.depth) > RIDGE * (p.depth + across.depth);
    ask_pixel(first, p, terrain, place.xyz, ridge);
    ask_pixel(first + ivec2(1, 0), right, terrain, place.xyz, ridge);
    ask_pixel(first + ivec2(0, 1), down, terrain, place.xyz, ridge);
    ask_pixel(first + 1, across, terrain, place.xyz, ridge);
}
#endif

void main() {
    ivec2 pixel;
    if (!coast_asked(pixel)) return;
#if COAST_STEP == 2
    ask_block(pixel);
#else
    CoastPixel p = coast_pixel(pixel);
    TerrainPoint terrain = terrain_point(p.D, COAST_FINEST_PX * length(p.point) * frame.pixel_rad);
    float height = frame.anchor_height_m + terrain.dh, above = height - planet.sea_level_m;
    if (above < 0.0) coast_to_sea(pixel, p, -above);
    else if (p.surface == SURFACE_SEA) coast_to_land(pixel, p, terrain.gradient, above,
        terrain_attributes(terrain, height, p.spacing).xyz);
#endif
}
