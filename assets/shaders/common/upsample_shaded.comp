// Light of the pixels between those that were shaded (common/surface_tiles.glsl), from the shaded ones around.
// Only neighbours as far away count, so that outlines stay as sharp as the mesh draws them; where there is none, a
// pixel gets what its block shows, or the other square of its pair. A lane a block: software GPUs take long over each
// load from an image and each store.
//
//   SHADE_EVERY    2 or 4, as they were shaded
//   SURFACE        of the pixels
//   SCENE_FORMAT   of u_radiance
//   BY_LENS        pixels seen through water and those seen through air were shaded by two shaders
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"
#include "common/texel.glsl"
#include "common/spread.glsl"
#include "generated/frame.glsl"
#ifdef BY_LENS
#include "common/camera.glsl"
#include "contract/waterline.glsl"
#endif

layout(local_size_x = HALF_TILE_WIDTH, local_size_y = HALF_TILE_HEIGHT) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];   // the indirect dispatch
    uint tiles[];          // x | y << 16
};
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(binding = RADIANCE_IMAGE, SCENE_FORMAT) uniform image2D u_radiance;

const float ALIKE = 0.75;   // ratio of depths: ground eight pixels below its horizon changes by so much in two

struct Shown {
    vec4 light;    // w: 1 where there is some
    float depth;
};

// Light of a pixel that was shaded if it shows the surface.
Shown shaded_at(ivec2 at) {
    ivec2 last = textureSize(u_surface, 0) - 1;
    bool counts = all(lessThanEqual(at, last)) && all(greaterThanEqual(at, ivec2(0)));
    at = clamp(at, ivec2(0), last);
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

#if SHADE_EVERY == 2
// The more, the more alike two neighbours on opposite sides are.
float evenness(vec4 sides[2]) {
    vec2 light = vec2(dot(sides[0].rgb, vec3(1.0)), dot(sides[1].rgb, vec3(1.0)));
    float differ = sides[0].a * sides[1].a > 0.0 ? abs(light.x - light.y) / max(light.x + light.y, 1e-30) : 1.0;
    return 1.0 / (0.03 + differ * differ);
}

void main() {
    uint tile = tiles[spread_tiles()];
    ivec2 block = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + 2 * ivec2(gl_LocalInvocationID.xy),
        last = textureSize(u_surface, 0) - 1;
    // The black squares of the block, and of those around it that the white ones touch.
    int first = frame.checkerboard & 1;
    Shown blacks[2] = Shown[](shaded_at(block + ivec2(first, 0)), shaded_at(block + ivec2(1 - first, 1)));
    for (int i = 0; i < 2; ++i) {
        int column = i == 0 ? 1 - first : first;
        ivec2 white = block + ivec2(column, i);
        bool inside = all(lessThanEqual(white, last));
        // Where the black square of the row shows something else, the white one was shaded itself.
        bool left_out = inside && blacks[i].light.a > 0.0 && texel_at(u_surface, min(white, last)).r == SURFACE;
#ifdef BY_LENS
        left_out = left_out && in_water(block, 2 * i) == in_water(block, 2 * i + 1);
#endif
        float depth = texel_at(u_depth, min(white, last)).r;
        // Along an edge more than across it, or it would be a row of dots.
        vec4 beside[2] = vec4[](alike(blacks[i], depth), alike(shaded_at(white + ivec2(2 * column - 1, 0)), depth));
        vec4 above[2] = vec4[](alike(blacks[1 - i], depth), alike(shaded_at(white + ivec2(0, 2 * i - 1)), depth));
        vec4 sum = evenness(beside) * (beside[0] + beside[1]) + evenness(above) * (above[0] + above[1]);
        if (left_out) imageStore(u_radiance, white, vec4(sum.a > 0.0 ? sum.rgb / sum.a : blacks[i].light.rgb, 1.0));
    }
}
#else
void main() {
    uint tile = tiles[spread_tiles()];
    ivec2 block = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + 2 * ivec2(gl_LocalInvocationID.xy),
        last = textureSize(u_surface, 0) - 1;
    bool shows[4];
    int shaded = 3;   // as find_shown() has it
    for (int i = 3; i >= 0; --i) {
        ivec2 pixel = block + ivec2(i & 1, i >> 1);
        shows[i] = all(lessThanEqual(pixel, last)) && texel_at(u_surface, min(pixel, last)).r == SURFACE;
        shaded = shows[i] ? i : shaded;
    }
    vec3 home = imageLoad(u_radiance, min(block + ivec2(shaded & 1, shaded >> 1), last)).rgb;
    Shown own = Shown(shows[0] ? vec4(home, 1.0) : vec4(0.0), texel_at(u_depth, block).r);
    Shown right = shaded_at(block + ivec2(2, 0)), down = shaded_at(block + ivec2(0, 2)), across = shaded_at(block + 2);
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
#endif
