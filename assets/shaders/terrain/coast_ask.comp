// The line between land and water, pixel by pixel: the meshes meet along straight edges some pixels long, the height function
// knows better. Pixels change sides in the G-buffer before anything is shaded. terrain/coast_find.comp lists them.
//
// Define COAST_STEP: 2 asks once for each block of 2 x 2.
#include "terrain/coast_pixel.glsl"
#include "terrain/coast_list.glsl"
#include "common/spread.glsl"

layout(local_size_x = 64) in;

#if COAST_STEP == 2
// How far depth may be from linear on screen, relative, before pixels of a block count as parts of different ground.
const float RIDGE = 0.005;

// One height and its gradient for a block of 2 x 2 pixels.
void ask_block(ivec2 first) {
    ivec2 last = textureSize(u_surface, 0) - 1;
    CoastPixel p[4];
    vec4 depth;
    vec3 middle = vec3(0.0);
    float open = 0.0, away = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 pixel = first + ivec2(k & 1, k >> 1);
        p[k] = coast_pixel(min(pixel, last));
        p[k].open = p[k].open && all(lessThanEqual(pixel, last));
        depth[k] = texelFetch(u_depth, min(pixel, last), 0).r;
        middle += p[k].open ? p[k].D : vec3(0.0);
        away += p[k].open ? length(p[k].point) : 0.0;
        open += p[k].open ? 1.0 : 0.0;
    }
    if (open == 0.0) return;
    middle /= open;
    TerrainPoint terrain = terrain_point(middle, COAST_FINEST_PX * float(COAST_STEP) * (away / open) * frame.clock.w);
    // Along a plane depth is linear on screen. Where it is not, the pixels lie before and behind a ridge, and the middle between
    // them is on neither: what was drawn as land stays land.
    bool ridge = abs(depth.x + depth.w - depth.y - depth.z) > RIDGE * (depth.x + depth.w);
    for (int k = 0; k < 4; ++k) {
        if (!p[k].open || (ridge && p[k].surface == SURFACE_TERRAIN)) continue;
        ivec2 pixel = first + ivec2(k & 1, k >> 1);
        float height = frame.anchor_up.w + terrain.dh + dot(terrain.gradient, p[k].D - middle), above = height - planet.sea.x;
        float spacing = vertex_spacing(p[k].D, p[k].code);
        if (above < 0.0) coast_to_sea(pixel, p[k], -above);
        else if (p[k].surface == SURFACE_SEA) coast_to_land(pixel, p[k], terrain.gradient, above, terrain_attributes(terrain, height, spacing).xyz);
    }
}
#endif

void main() {
    uint index = spread_blocks(8u) * COAST_GROUP + gl_LocalInvocationID.x;
    if (index >= coast_list.count) return;
    ivec2 pixel = coast_listed(coast_list.pixels[index]);
#if COAST_STEP == 2
    ask_block(pixel);
#else
    CoastPixel p = coast_pixel(pixel);
    TerrainPoint terrain = terrain_point(p.D, COAST_FINEST_PX * length(p.point) * frame.clock.w);
    float height = frame.anchor_up.w + terrain.dh, above = height - planet.sea.x, spacing = vertex_spacing(p.D, p.code);
    if (above < 0.0) coast_to_sea(pixel, p, -above);
    else if (p.surface == SURFACE_SEA) coast_to_land(pixel, p, terrain.gradient, above, terrain_attributes(terrain, height, spacing).xyz);
#endif
}
