// A map of ice that falls through wind, on a square that wraps: r fibres, g hooks (tufts with tails that curve), b soft
// patches. What is seen of cirrus is the trail of falling crystals: heads stay, what has fallen drifts through slower
// air that turns with height (Heymsfield 1975). Stages: 0 where ice forms, and potentials of the winds; 1 the winds,
// their curl; 2 trails, as line integrals of what falls (Cabral and Leedom 1993), one-sided; 3 stirred by eddies.
#include "clouds/tiled_noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) uniform writeonly image2D o_map;
layout(binding = 1, rgba32f) uniform writeonly image2D o_winds;
layout(binding = 0) uniform sampler2D u_map;
layout(binding = 1) uniform sampler2D u_winds;

float noise_at(vec2 place, int cells, int seed) {
    return tiled_gradient(vec3(place * float(cells), 0.5), cells, seed);
}

float octaves_at(vec2 place, int cells, int octaves, float gain, int seed) {
    float sum = 0.0, weight = 1.0;
    for (int k = 0; k < octaves; ++k) {
        sum += weight * noise_at(place, cells, seed + k);
        weight *= gain;
        cells *= 2;
    }
    return sum;
}

// Grains of ice, one in a cell, a few of them bright.
float grains_at(vec2 place, int cells, float rarity, int seed) {
    vec2 at = place * float(cells);
    ivec2 cell = ivec2(floor(at));
    float sum = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec2 away = ivec2(i % 3, i / 3) - 1;
        vec3 chance = 0.5 + 0.5 * vec3(tiled_hash(ivec3(cell + away, 0), cells, seed)) * NOISE_GRADIENT_SCALE;
        vec2 to = vec2(away) + chance.xy - at + vec2(cell);
        sum += pow(chance.z, rarity) * exp(-6.0 * dot(to, to));
    }
    return sum;
}

#if STAGE == 0
void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    vec2 place = (vec2(at) + 0.5) / vec2(imageSize(o_map));
    float patches = smoothstep(-0.25, 0.45, octaves_at(place, 5, 4, 0.6, 3));
    float tufts = smoothstep(0.12, 0.45, octaves_at(place, 17, 3, 0.6, 13));
    float fibres = grains_at(place, 1024, 18.0, 30) + 0.3 * grains_at(place, 320, 14.0, 31);
    float hooks = grains_at(place, 1024, 12.0, 33) + 0.4 * grains_at(place, 256, 12.0, 34);
    float soft = smoothstep(-0.35, 0.6, octaves_at(place, 8, 5, 0.6, 60));
    imageStore(o_map, at, vec4(fibres * patches, hooks * tufts, soft, 0.0));
    imageStore(o_winds, at, vec4(octaves_at(place, 2, 3, 0.4, 50), octaves_at(place, 5, 4, 0.3, 70), 0.0, 0.0));
}
#elif STAGE == 1
void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(o_map);
    ivec2 east = (at + ivec2(1, 0)) % size, west = (at + size - ivec2(1, 0)) % size, north = (at + ivec2(0, 1)) % size,
        south = (at + size - ivec2(0, 1)) % size;
    vec4 slope_x = texelFetch(u_winds, east, 0) - texelFetch(u_winds, west, 0),
        slope_y = texelFetch(u_winds, north, 0) - texelFetch(u_winds, south, 0);
    imageStore(o_winds, at, 0.5 * float(size.x) * vec4(slope_y.x, -slope_x.x, slope_y.y, -slope_x.y));
    imageStore(o_map, at, texelFetch(u_map, at, 0));
}
#elif STAGE == 2
const int FIBRE_STEPS = 200, HOOK_STEPS = 150, SOFT_STEPS = 24;

vec2 wind_at(vec2 place, float turn) {
    vec2 v = normalize(vec2(1.0, 0.0) + 0.55 * textureLod(u_winds, place, 0.0).xy);
    float c = cos(turn), s = sin(turn);
    return vec2(c * v.x - s * v.y, s * v.x + c * v.y);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    vec2 here = (vec2(at) + 0.5) / vec2(imageSize(o_map)), place = here;
    float sum = 0.0, weights = 0.0, length_ = 0.7 + 0.8 * noise_at(here, 6, 90);
    for (int i = 0; i < FIBRE_STEPS; ++i) {
        float age = float(i) / float(FIBRE_STEPS), weight = exp(-3.0 * age) * (1.0 - age);
        sum += weight * textureLod(u_map, place, 0.0).r;
        weights += weight;
        place -= 0.0014 * length_ * wind_at(place, 0.5 * (1.0 - age));
    }
    float fibres = sum / weights;
    sum = weights = 0.0;
    place = here;
    for (int i = 0; i < HOOK_STEPS; ++i) {
        float age = float(i) / float(HOOK_STEPS), weight = (1.0 - age) * sqrt(1.0 - age);
        sum += weight * textureLod(u_map, place, 0.0).g;
        weights += weight;
        place -= 0.0012 * length_ * (0.35 + 1.5 * age) * wind_at(place, 1.7 * exp(-4.5 * age));
    }
    float hooks = sum / weights;
    sum = weights = 0.0;
    place = here;
    for (int i = 0; i < SOFT_STEPS; ++i) {
        float age = float(i) / float(SOFT_STEPS), weight = 1.0 - age;
        sum += weight * textureLod(u_map, place, 0.0).b;
        weights += weight;
        place -= 0.003 * wind_at(place, 0.3);
    }
    imageStore(o_map, at, vec4(fibres, hooks, sum / weights, 0.0));
}
#else
void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    vec2 place = (vec2(at) + 0.5) / vec2(imageSize(o_map));
    for (int i = 0; i < 8; ++i) place -= 0.00035 * textureLod(u_winds, place, 0.0).zw;
    imageStore(o_map, at, textureLod(u_map, place, 0.0));
}
#endif
