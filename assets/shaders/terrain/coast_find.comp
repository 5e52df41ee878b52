// Finds the pixels beside coasts whose height has to be asked, 4 x 4 at a time: the height function at one of them, its
// gradient and the roughness there say of the others whether they are land or water, or that they may be either. A lane
// a block, a workgroup a tile.
//
// Define COAST_STEP: 2 lists blocks of 2 x 2 pixels, by the first; COAST_HERE, with TERRAIN_FLOAT: most are asked here,
// by the height alone, and only the others listed; COAST_TILES: all are asked.
#include "generated/bindings.glsl"
#ifdef COAST_HERE
#ifdef COAST_TILES
#define TERRAIN_AROUND_FAR
#endif
#include "terrain/coast_here.glsl"
#endif
#include "terrain/coast_pixel.glsl"
#include "terrain/coast_list.glsl"
#include "common/spread.glsl"
#include "common/texel.glsl"

layout(local_size_x = 8) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};

// Ground a way d off hardly ever differs from a place by more than SLOPE |gradient| d + RELIEF roughness a, where a is
// the amplitude of the layer 16 times as long as d / 3 or the pixel: of 150 000 random pairs on Earth up to 2.9 pixels
// apart it took the wrong side of the sea's level for none with pixels of 500 m and for 2 with 6 km. Pixels that do not
// resolve ranges (a 16th of the longest layer) are all asked, and so are depths through which the bed shows.
const float SLOPE = 3.0, RELIEF = 1.2, LONGER = 16.0, PIXELS = 3.0, RANGES = 1.0 / 16.0;
uniform float u_opaque_m;

float layer_amplitude(float wavelength_m) {
    int layer = clamp(terrain_layers_above(wavelength_m), min(TERRAIN_SHAPE_LAYERS, terrain_table.layer_count - 1),
        terrain_table.layer_count - 1);
    return terrain_table.layers[layer].amplitude_m;
}

void main() {
    uint tile = tiles[spread_tiles()];
    int lane = int(gl_LocalInvocationIndex);
    ivec2 first = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + 4 * ivec2(lane & 3, lane >> 2);
    ivec2 last = textureSize(u_surface, 0) - 1;

    ivec2 middle = min(first + 2, last);
    CoastPixel asked = coast_pixel(middle);
    vec3 spot = asked.D;
#ifdef COAST_HERE
    float extent_m = coast_extent(first, last, spot);
#endif
    float height_m;
    TerrainBroad broad = terrain_broad(spot);
    TerrainPoint ground = terrain_point(broad, spot, length(asked.point) * frame.pixel_rad, height_m);
    float above = frame.anchor_height_m + ground.dh - planet.sea_level_m, slope = SLOPE * length(ground.gradient);
    bool there = texel_at(u_depth, middle).r > 0.0;
#if defined(TERRAIN_CRATERED) || defined(TERRAIN_MAPPED) || defined(TERRAIN_TILED) || defined(COAST_TILES)
    // a rim or a cliff of the map keeps to no layer's amplitude; from far away hardly any pixel is known
    there = false;
#endif

    uint found = 0u, close = 0u;
#ifdef COAST_HERE
    CoastDrawn drawn = CoastDrawn(0u, 0u, 0u);
#endif
    for (int k = 0; k < 16; ++k) {
        ivec2 pixel = first + ivec2(k & 3, k >> 2);
        CoastPixel p = coast_pixel(min(pixel, last));
        vec3 aside = p.D - spot;
        float away = length(aside), pixel_m = length(p.point) * frame.pixel_rad;
        float least = slope * away + RELIEF * ground.roughness * layer_amplitude(LONGER * max(away / PIXELS, pixel_m));
        bool shown = all(lessThanEqual(pixel, last)), inside = shown && p.open;
        bool known = there && pixel_m < RANGES * terrain_table.layers[0].lattice.wavelength_m
            && abs(above) > least
            && (above < -u_opaque_m || above > 0.0 && p.surface == SURFACE_TERRAIN);
        found |= inside && !known ? 1u << k : 0u;
#ifdef COAST_HERE
        close |= away <= extent_m ? 1u << k : 0u;
        coast_drawn(drawn, k, shown ? p.surface : SURFACE_NONE, !inside, known, above < 0.0);
#endif
        if (inside && known && above < 0.0) coast_to_sea(pixel, p,
            max(-above - dot(ground.gradient, aside), u_opaque_m));
    }

#if COAST_STEP == 2
    found |= found >> 1 & 0x7777u;
    found = (found | found >> 4) & 0x0505u;
#endif
#ifdef COAST_HERE
    found &= ~coast_here(found & close, drawn, first, broad, spot, extent_m);
#endif
    uint count = uint(bitCount(found));
    uint place = count > 0u ? atomicAdd(coast_list.count, count) : 0u;
    if (count > 0u) atomicMax(coast_list.groups[0], (place + count + COAST_GROUP - 1u) / COAST_GROUP);
    for (; found != 0u; found &= found - 1u) {
        int k = findLSB(found);
        ivec2 pixel = first + ivec2(k & 3, k >> 2);
        coast_list.pixels[place++] = uint(pixel.x) | uint(pixel.y) << 16;
    }
}
