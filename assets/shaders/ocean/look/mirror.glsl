// What the sea mirrors: ground, trees and falling water that are in the picture, else the sky.
#include "generated/bindings.glsl"
#include "common/texel.glsl"
#include "ocean/look/fresnel.glsl"
#include "ocean/look/pixel.glsl"
#include "ocean/look/sky_map.glsl"
#include "contract/land_water.glsl"

layout(binding = SKY_MAP_UNIT) uniform sampler2D u_sky_map;   // ocean/sky.comp

#ifdef OCEAN_REFLECTIONS
layout(binding = SCENE_UNIT) uniform sampler2D u_scene;   // what was shaded before: pixels of the ground are complete

// Radiance along a ray from a point, where it meets ground that the picture shows (xyz), and how sure that is (w). A
// ray is straight on screen, and so is depth = near / z along it. share: how much of what it finds counts. white: of
// falling water, whose own light may not be there yet.
vec4 mirrored_ground(vec3 from, vec3 direction, float share, vec3 white) {
    vec4 start = clip_position(from), far = clip_position(direction);
    vec2 first = start.xy / start.w, towards = far.xy / max(far.w, 1e-6) - first;
    float depth = start.z / start.w;
    // To the border of the picture, or to where the ray vanishes.
    vec2 room = (sign(towards) - first) / (abs(towards) + 1e-9) * sign(towards);
    float end = min(min(room.x > 0.0 ? room.x : 1.0, room.y > 0.0 ? room.y : 1.0), 1.0);
    vec2 size = vec2(textureSize(u_depth, 0));
    float low = 0.0, high = 0.0, found = 0.0;
    int turns = far.w > 0.02 && share > 0.0 ? OCEAN_REFLECTIONS : 0;
    for (int i = 0; i < turns; ++i) {
        // Denser at the start, where what is mirrored is near.
        float share = (float(i) + 1.0) / float(OCEAN_REFLECTIONS), s = end * share * (0.3 + 0.7 * share);
        ivec2 texel = ivec2((0.5 + 0.5 * (first + towards * s)) * size);
        float there = texel_at(u_depth, clamp(texel, ivec2(0), ivec2(size) - 1)).r;
        high = s;
        // Behind what is drawn there, which lies behind the water itself.
        found = there > depth * (1.0 - s) && there < 0.98 * depth ? 1.0 : 0.0;
        if (found > 0.0) break;
        low = s;
    }
    turns = found > 0.0 ? 4 : 0;
    for (int i = 0; i < turns; ++i) {
        float s = 0.5 * (low + high);
        ivec2 texel = ivec2((0.5 + 0.5 * (first + towards * s)) * size);
        float there = texel_at(u_depth, clamp(texel, ivec2(0), ivec2(size) - 1)).r;
        bool behind = there > depth * (1.0 - s) && there < 0.98 * depth;
        low = behind ? low : s;
        high = behind ? s : high;
    }
    vec2 at = first + towards * high;
    ivec2 texel = clamp(ivec2((0.5 + 0.5 * at) * size), ivec2(0), ivec2(size) - 1);
    uint surface = texel_at(u_surface, texel).r;
    bool ground = surface == SURFACE_TERRAIN || surface == SURFACE_COVER, falls = false;
#ifdef OCEAN_LAND_WATER
    float code = surface == SURFACE_SEA ? texelFetch(u_attributes, texel, 0).z : 0.0;
    falls = land_water_at(code) && land_water_decode(code).x > LAND_WATER_FALLS + 0.5 / 14.0;
    float height_m, there = max(texel_at(u_depth, texel).r, 1e-30);
    vec3 place = foot_offset_of(position_from_depth(ndc_of_pixel(vec2(texel) + 0.5), there), height_m);
    white *= falling_white(place, forward_distance(there) * frame.pixel_rad, falls);
#endif
    // Turning the camera moves what is mirrored hardly across the border at the sides, tilting it does at the top.
    float aside = clamp(abs(at.x - first.x), 1e-3, 0.03);
    float sure = found * (ground || falls ? share : 0.0) * smoothstep(0.0, aside, 1.0 - abs(at.x))
        * smoothstep(0.0, 0.15, 1.0 - abs(at.y));
    vec3 seen = falls ? white : sure > 0.0 ? texelFetch(u_scene, texel, 0).rgb * frame.radiance_per_hdr : vec3(0.0);
    return vec4(seen, sure);
}
#else
vec4 mirrored_ground(vec3 from, vec3 direction, float share, vec3 white) {
    return vec4(0.0);
}
#endif

// Radiance of what comes from a direction to a point of the sea. open_sky: of air between the sea and a camera up high.
// spread: of the slopes that mirror. One ray stands for all: over rough water, where they spread over more than the
// ground is high, it would find ground and sky by turns, and the sky alone is nearer to their mean. white: of foam
// there.
vec3 mirrored(SeaPixel p, vec3 direction, float spread, vec3 open_sky, vec3 white) {
    // Facets that would mirror the sea itself show the sky low above it, by way of a second facet.
    float rise = dot(direction, p.zenith);
    direction = normalize(direction + p.zenith * max(0.02 - rise, 0.0));
    vec4 ground = mirrored_ground(p.point, direction, clamp(1.3 - 10.0 * spread, 0.0, 1.0), white);
    return mix(textureLod(u_sky_map, sky_map_place(direction), 0.0).rgb + open_sky, ground.rgb, ground.a);
}
