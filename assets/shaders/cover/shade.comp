// Light of trees. Leaves: Lambert's law, softened because a tuft has leaves of many directions, and light that comes
// through from behind. Chosen by eye: how much of either.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "contract/air.glsl"
#include "contract/cover_light.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#ifdef COVER_SPECIES
#include "cover/translucency.glsl"
#endif

#if LIGHT_EVERY == 4
const ivec2 BLOCK = ivec2(2, 2);
layout(local_size_x = HALF_TILE_WIDTH, local_size_y = HALF_TILE_HEIGHT) in;
#elif LIGHT_EVERY == 2
const ivec2 BLOCK = ivec2(2, 1);
layout(local_size_x = HALF_TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
#else
const ivec2 BLOCK = ivec2(1, 1);
layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
#endif
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer { uint tile_groups[4]; uint tiles[]; };
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = NORMAL_UNIT) uniform sampler2D u_normal;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(RADIANCE_FORMAT, binding = RADIANCE_IMAGE) writeonly uniform image2D u_radiance;

const float STARLIGHT = 1.5e-8;      // as terrain/shade.comp
const float GROUND_ALBEDO = 0.12;    // of what lies around: light from below
const float WRAP = 0.35;             // share of a tuft's leaves that turn to where its normal doesn't
const float THROUGH = 0.45;          // light that leaves let through, as a share of what they throw back
const vec3 YELLOWED = vec3(1.25, 1.15, 0.55);   // colour of that
const float BIAS_M = 0.8;            // leaves nearer to the sun than this are the tuft's own

struct Leaf {
    bool shown;
    vec3 point, normal;
    vec4 attributes;
};

Leaf leaf_at(ivec2 pixel) {
    Leaf leaf;
    leaf.shown = all(lessThan(pixel, textureSize(u_surface, 0)))
        && texelFetch(u_surface, pixel, 0).r == SURFACE_COVER;
    leaf.point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    leaf.normal = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    leaf.attributes = texelFetch(u_attributes, pixel, 0);
    return leaf;
}

// 1: leaves; 0: snow on them, which lets no light through.
float leafy(vec3 albedo) {
    return cover_map.snow.w > 0.0 ? clamp(1.5 - 5.0 * albedo.b, 0.0, 1.0) : 1.0;
}

// The same air at another distance, as if it were as dense there.
Air air_at(Air between, float share) {
    vec3 left = pow(max(between.transmittance, 1e-6), vec3(share));
    vec3 more = (1.0 - left) / max(1.0 - between.transmittance, 1e-6);
    return Air(left, between.in_scatter * mix(vec3(share), more, greaterThan(1.0 - between.transmittance, vec3(1e-4))));
}

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 first = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + BLOCK * ivec2(gl_LocalInvocationID.xy);
    // What differs little from pixel to pixel: light from around, the air.
    vec3 middle = vec3(0.0), facing = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < LIGHT_EVERY; ++i) {
        Leaf leaf = leaf_at(first + ivec2(i & 1, i >> 1));
        if (leaf.shown) {
            middle += leaf.point;
            facing += leaf.normal;
            count += 1.0;
        }
    }
    if (count == 0.0) return;
    middle /= count;
    facing = normalize(facing + 1e-6);
    vec3 zenith = up_at(middle), sun = frame.sun_direction;
    vec3 sunlight = frame.sun_irradiance * sun_visibility(middle) * air_to_space(middle, sun);
    vec3 around = skylight(middle, facing) + frame.sun_irradiance * STARLIGHT
        + sunlight * max(dot(zenith, sun), 0.0) * (GROUND_ALBEDO * (0.5 - 0.5 * dot(facing, zenith)));
    Air between = air_from_camera(middle);
    float per_m = inversesqrt(dot(middle, middle));

    for (int i = 0; i < LIGHT_EVERY; ++i) {
        ivec2 pixel = first + ivec2(i & 1, i >> 1);
        Leaf leaf = leaf_at(pixel);
        if (!leaf.shown) continue;
        vec3 albedo = leaf.attributes.rgb * leaf.attributes.rgb;
        bool green = leaf.attributes.a > 0.5;
        float open = green ? 2.0 * leaf.attributes.a - 1.0 : 2.0 * leaf.attributes.a, lets = THROUGH;
#ifdef COVER_SPECIES
        if (is_coded_leaf(leaf.attributes)) {
            vec2 light = decoded_leaf(leaf.attributes);
            green = true;
            open = light.x;
            lets = light.y;
        }
#endif
        float left = cover_light(leaf.point, BIAS_M) * mix(0.35, 1.0, open);
        float mu = dot(leaf.normal, sun), away_m = length(leaf.point), back = dot(leaf.point, sun) / away_m;
        float front = green ? max((mu + WRAP) / (1.0 + WRAP), 0.0) : max(mu, 0.0);
        // Seen against the sun leaves glow where they are thin.
        float through = green ? lets * leafy(albedo) * (0.35 * max(-mu, 0.0) + 0.65 * max(back, 0.0) * open) : 0.0;
        vec3 radiance = sunlight * left * (albedo * front + albedo * YELLOWED * through) / PI;
        radiance += albedo / PI * open * around;
#if LIGHT_EVERY > 1
        Air here = air_at(between, away_m * per_m);
#else
        Air here = between;
#endif
        radiance = radiance * here.transmittance + here.in_scatter;
        imageStore(u_radiance, pixel, vec4(radiance * frame.hdr_per_radiance, 1.0));
    }
}
