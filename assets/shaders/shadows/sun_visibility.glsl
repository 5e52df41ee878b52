// Contract "sun_visibility": shadows of the ground, from a clipmap of the lowest altitudes that see the sun.
#include "common/camera.glsl"
#include "shadows/clipmap.glsl"

layout(binding = 13) uniform sampler2DArray u_shadow_map;

float sun_visibility_of_sphere(float altitude, float mu_s, float angular_radius) {
    float h = max(altitude, 0.0) / planet.radii.x;
    float sin_h = 1.0 / (1.0 + h);
    float cos_h = -sqrt(h * (2.0 + h)) * sin_h;
    float soft = angular_radius * sin_h;
    return smoothstep(-soft, soft, mu_s - cos_h);
}

// Height of the surface, its height above the lowest altitudes that see the upper and the lower limb, shelter from the sky.
vec4 shadow_sample(int level, vec2 place) {
    vec4 window = shadow_map.window[level];
    vec2 at = clamp(place * shadow_frequency(level) + window.xy, vec2(0.0), vec2(shadow_map.counts.y) - 1.001);
    vec2 whole = floor(at), part = at - whole;
    int size = shadow_map.counts.y, layer = shadow_map.layer[level].x;
    ivec2 low = ivec2(whole) + ivec2(window.zw);
    low -= ivec2(low.x >= size ? size : 0, low.y >= size ? size : 0);
    ivec2 high = low + 1;
    high -= ivec2(high.x >= size ? size : 0, high.y >= size ? size : 0);
    vec4 a = texelFetch(u_shadow_map, ivec3(low, layer), 0), b = texelFetch(u_shadow_map, ivec3(high.x, low.y, layer), 0);
    vec4 c = texelFetch(u_shadow_map, ivec3(low.x, high.y, layer), 0), d = texelFetch(u_shadow_map, ivec3(high, layer), 0);
    return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

// Which level shows a place: the finest whose window holds it, the next one coming in over the last quarter; no finer than
// the pixel. known: 1, 0 outside all windows.
float shadow_level(vec2 place, float footprint, out float known) {
    vec2 away = abs(place - shadow_map.view.xy) * (shadow_map.scale.x / shadow_map.view.z);
    float coarsest = float(shadow_map.counts.x - 1);
    float reach = max(max(away.x, away.y), 1e-9), level = max(ceil(log2(reach)), 0.0);
    known = clamp(8.0 - 8.0 * reach * exp2(-coarsest), 0.0, 1.0);
    level += clamp(reach * exp2(-level) * 4.0 - 3.0, 0.0, 1.0);
    level = max(level, log2(max(footprint * shadow_map.detail.x, 1e-9)));
    return clamp(max(level, shadow_map.view.w), 0.0, coarsest);
}

vec2 light_visibility(vec3 point) {
    float height;
    vec3 D = foot_offset_of(point, height);
    vec2 place = shadow_place(D);
    float footprint = length(point) * frame.clock.w;
    float known, level = shadow_level(place, footprint, known);
    int whole = int(level), turn = 0;
    float part = level - float(whole);
    vec4 light = vec4(0.0);
    int turns = part > 0.0 ? 2 : 1;
    do {
        light += (turn == 0 ? 1.0 - part : part) * shadow_sample(min(whole + turn, shadow_map.counts.x - 1), place);
    } while (++turn < turns);

    // Nobody stands below the ground; triangles, of one level of detail or another, count as lying on it.
    float texel = shadow_map.scale.w * exp2(level) * shadow_map.scale.y;
    float above = max(max(height, shadow_map.detail.y) - light.x - 0.5 * texel, 0.0);
    vec2 limbs = light.yz + above;   // x: above the lowest altitude that sees the upper limb
    vec3 up = up_at(point);
    float mu = dot(up, frame.sun_direction.xyz);
    float width = max(limbs.x - limbs.y, 0.25 * texel * max(abs(mu), 0.03));
    float sun = smoothstep(-0.5, 0.5, 0.5 * (limbs.x + limbs.y) / width);
    // Far from the windows, and far above the ground, the planet's bulk hides the sun: of the lowest ground where the windows
    // know the rest, else of the reference sphere.
    float base = known * float(shadow_map.counts.w) > 0.0 ? planet.radii.z : 0.0;
    float bulk = sun_visibility_of_sphere((height - base) * planet.radii.x / (planet.radii.x + base), mu, frame.sun_direction.w);
    vec2 knows = known * vec2(shadow_map.counts.wz);
    return vec2(min(mix(1.0, sun, knows.x), bulk), mix(1.0, light.w, knows.y));
}

float sun_visibility(vec3 point) {
    return light_visibility(point).x;
}
