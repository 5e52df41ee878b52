// Light of the pixels between those that were shaded (common/surface_tiles.glsl, SHADE_PX 2), from the shaded ones around.
// Only neighbours as far away count, so that outlines stay as sharp as the mesh draws them; where there is none, a
// pixel gets what its block shows. A lane a block: software GPUs take long over each load from an image and each store.
//
//   SURFACE        of the pixels
//   SCENE_FORMAT   of u_radiance
//   BY_LENS        pixels seen through water and those seen through air were shaded by two shaders
#include "common/surfaces.glsl"
#include "common/texel.glsl"
#include "common/spread.glsl"
#ifdef BY_LENS
#include "common/camera.glsl"
#include "contract/waterline.glsl"
#endif

layout(local_size_x = 8, local_size_y = 4) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];   // the indirect dispatch
    uint tiles[];          // x | y << 16
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 3) uniform usampler2D u_surface;
layout(binding = 0, SCENE_FORMAT) uniform image2D u_radiance;

const float ALIKE = 0.75;   // ratio of depths: ground eight pixels below its horizon changes by so much in two

struct Shown {
    vec4 light;    // w: 1 where there is some
    float depth;
};

// Light of a block's first pixel, if that shows the surface.
Shown first_of(ivec2 at) {
    ivec2 last = textureSize(u_surface, 0) - 1;
    bool counts = all(lessThanEqual(at, last));
    at = min(at, last);
    counts = counts && texel_at(u_surface, at).r == SURFACE;
    return Shown(counts ? vec4(imageLoad(u_radiance, at).rgb, 1.0) : vec4(0.0), texel_at(u_depth, at).r);
}

#ifdef BY_LENS
bool in_water(ivec2 block, int k) {
    return lens_in_water(ndc_of_pixel(vec2(block + ivec2(k & 1, k >> 1)) + 0.5));
}
#endif

vec4 alike(Shown there, float depth) {
    return min(there.depth, depth) >= ALIKE * max(there.depth, depth) ? there.light : vec4(0.0);
}

void main() {
    uint tile = tiles[spread_tiles()];
    ivec2 block = ivec2(tile & 0xffffu, tile >> 16) * ivec2(16, 8) + 2 * ivec2(gl_LocalInvocationID.xy), last = textureSize(u_surface, 0) - 1;
    bool shows[4];
    int shaded = 3;   // as find_shown() has it
    for (int i = 3; i >= 0; --i) {
        ivec2 pixel = block + ivec2(i & 1, i >> 1);
        shows[i] = all(lessThanEqual(pixel, last)) && texel_at(u_surface, min(pixel, last)).r == SURFACE;
        shaded = shows[i] ? i : shaded;
    }
    vec3 home = imageLoad(u_radiance, min(block + ivec2(shaded & 1, shaded >> 1), last)).rgb;
    Shown own = Shown(shows[0] ? vec4(home, 1.0) : vec4(0.0), texel_at(u_depth, block).r);
    Shown right = first_of(block + ivec2(2, 0)), down = first_of(block + ivec2(0, 2)), across = first_of(block + 2);
    for (int i = 1; i < 4; ++i) {
        ivec2 pixel = block + ivec2(i & 1, i >> 1);
        vec3 kept = home;
        bool there = shows[i] && (shows[0] || shaded != i);
#ifdef BY_LENS
        int same = i;
        for (int k = i - 1; k >= 0; --k) same = shows[k] && in_water(block, k) == in_water(block, i) ? k : same;
        kept = imageLoad(u_radiance, min(block + ivec2(same & 1, same >> 1), last)).rgb;
        there = shows[i] && (shows[0] || same != i);
#endif
        // Half way between two, or in the middle of four.
        float depth = texel_at(u_depth, min(pixel, last)).r;
        vec4 sum = alike(own, depth);
        if (i != 2) sum += alike(right, depth);
        if (i != 1) sum += alike(down, depth);
        if (i == 3) sum += alike(across, depth);
        if (there) imageStore(u_radiance, pixel, vec4(shows[0] && sum.a > 0.0 ? sum.rgb / sum.a : kept, 1.0));
    }
}
