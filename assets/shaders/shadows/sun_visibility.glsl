// Contract "sun_visibility": shadows of the ground, from a clipmap of the lowest altitudes that see the sun.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/planet_shadow.glsl"
#include "contract/cloud_shadow.glsl"
#include "shadows/clipmap.glsl"

layout(binding = SHADOW_MAP_UNIT) uniform sampler2DArray u_shadow_map;

float shadow_power(int exponent) {
    return intBitsToFloat((127 + exponent) << 23);
}

// Level's texels are stored at their places on the map, modulo the texture's side; the anchor's is known in texels of
// level 0. (No arrays: software GPUs gather from them lane by lane.)
// Height of the surface, its height above the lowest altitudes that see the upper and the lower limb, shelter from the
// sky.
vec4 shadow_sample(int level, vec2 place) {
    float per_level = shadow_power(-level);
    int below = (1 << level) - 1, side = shadow_map.side;
    ivec2 anchor = shadow_map.anchor_texel;
    vec2 at = place * (shadow_map.frequency * per_level) + vec2((anchor >> level) & (side - 1))
        + (vec2(anchor & below) + shadow_map.anchor_rest) * per_level;
    return textureLod(u_shadow_map, vec3((at + 0.5) / float(side), float((shadow_map.power - level) & 15)), 0.0);
}

// Which level shows a place: the finest whose window holds it, the next one coming in over the last quarter; no finer
// than the pixel. known: 1, 0 outside all windows. Powers of two are made and taken apart by their bits.
float shadow_level(vec2 place, float footprint, out float known) {
    vec2 away = abs(place - shadow_map.foot) * (shadow_map.frequency / shadow_map.half_texels);
    int coarsest = shadow_map.levels - 1;
    float reach = max(away.x, away.y);
    int holds = ((floatBitsToInt(max(reach, 1.0)) + 0x7fffff) >> 23) - 127;
    known = clamp(8.0 - 8.0 * reach * shadow_power(-coarsest), 0.0, 1.0);
    float level = float(holds) + clamp(reach * shadow_power(2 - holds) - 3.0, 0.0, 1.0);
    // A logarithm, straight between powers of two.
    int pixel = floatBitsToInt(max(footprint * shadow_map.texels_per_footprint_m, 1.0));
    level = max(level, float(pixel - (127 << 23)) * (1.0 / 8388608.0));
    return clamp(level, shadow_map.finest_shown, float(coarsest));
}

vec2 light_visibility(vec3 point) {
    float height;
    vec3 D = foot_offset_of(point, height);
    vec2 place = shadow_place(D);
    float footprint = length(point) * frame.pixel_rad;
    float known, level = shadow_level(place, footprint, known);
    int whole = int(level), turn = 0;
    float part = level - float(whole);
    vec4 light = vec4(0.0);
    int turns = part > 0.0 ? 2 : 1;
    do {
        light += (turn == 0 ? 1.0 - part : part) * shadow_sample(min(whole + turn, shadow_map.levels - 1), place);
    } while (++turn < turns);

    // Nobody stands below the ground; triangles, of one level of detail or another, count as lying on it.
    float texel = shadow_map.texel_m * shadow_power(whole) * (1.0 + part);
    float above = max(max(height, shadow_map.sea_level_m) - light.x - 0.5 * texel, 0.0);
    vec2 limbs = light.yz + above;   // x: above the lowest altitude that sees the upper limb
    vec3 up = up_at(point);
    float mu = dot(up, frame.sun_direction);
    float width = max(limbs.x - limbs.y, 0.25 * texel * max(abs(mu), 0.03));
    float sun = smoothstep(-0.5, 0.5, 0.5 * (limbs.x + limbs.y) / width);
    // Far from the windows, and far above the ground, the planet's bulk hides the sun: of the lowest ground where the
    // windows know the rest, else of the reference sphere.
    float base = shadow_map.shadows && known > 0.0 ? planet.lowest_m : 0.0;
    float bulk = sun_visibility_of_sphere((height - base) * planet.radius_m / (planet.radius_m + base), mu,
        frame.sun_radius_rad);
    vec2 knows = known * vec2(shadow_map.shadows, shadow_map.shelter);
    return vec2(min(mix(1.0, sun, knows.x), bulk) * cloud_shadow(point), mix(1.0, light.w, knows.y));
}

float sun_visibility(vec3 point) {
    return light_visibility(point).x;
}
