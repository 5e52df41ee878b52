// Weather of a whole planet on an octahedral map, in the frame that drifts with the wind.
// x: low clouds' cover before its balance (BALANCE: raw, to find the balance; else 0..1); y: how far they tower, 0
// sheets .. 1; z: thin high cloud's cover; w: how deep and wet (fronts, the rain belt).
//
// Bands by latitude (rain belt, dry belts, storm tracks, polar sheets) are bent by noise; noise in eight octaves
// decides within them. It is drawn along zonal winds, and wound up by cyclones, whose fronts are spirals. Two
// generations of noise fade into one another, each carried by the winds since half of its life before its middle, so
// nothing winds up without end.
#include "common/noise.glsl"
#include "common/octahedral.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#ifdef BALANCE
layout(binding = 0, rgba32f) uniform writeonly image2D o_weather;
#else
layout(binding = 0, rgba8) uniform writeonly image2D o_weather;
#endif
layout(location = 0) uniform int u_border;
layout(location = 1) uniform ivec2 u_corner;          // of the tile
// of a generation: seed, its age from -0.5 to 0.5 of its life, weight, unused
layout(location = 2) uniform vec4 u_life[2];
layout(location = 4) uniform vec2 u_balance;         // cover = 0.5 + slope (raw - level)
layout(location = 5) uniform float u_texel_rad;      // octaves that are finer than the map's texels would only be grain
#ifdef IMPORTED
layout(binding = 0) uniform sampler2D u_cover;       // of a file, on a square like this one's
layout(location = 6) uniform float u_cover_border;   // texels
#endif
layout(location = 8) uniform vec4 u_cyclones[2 * CYCLONES];   // direction and size (chord), winding and strength

const float DRIFT_RAD = 0.9;   // of the fastest winds in a generation's life, relative to the frame

float noise_at(vec3 place, int seed) {
    vec3 cell = floor(place);
    return gradient_noise_value(ivec3(cell) + 7919 * seed, place - cell);
}

vec3 about_pole(vec3 d, float angle) {
    float c = cos(angle), s = sin(angle);
    return vec3(c * d.x - s * d.y, s * d.x + c * d.y, d.z);
}

vec3 about(vec3 d, vec3 axis, float angle) {
    float c = cos(angle), s = sin(angle);
    return c * d + s * cross(axis, d) + (1.0 - c) * dot(axis, d) * axis;
}

float band(float latitude, float middle, float width) {
    float x = (latitude - middle) / width;
    return exp(-x * x);
}

#ifdef IMPORTED
float cover_at(vec3 d) {
    float side = float(textureSize(u_cover, 0).x), inner = side - 2.0 * u_cover_border;
    return textureLod(u_cover, ((0.5 + 0.5 * oct_encode(d)) * inner + u_cover_border) / side, 0.0).r;
}
#endif

vec4 weather_at(vec3 d) {
    vec3 wound = d;
    float front = 0.0, gap = 0.0, core = 0.0;
#ifndef IMPORTED   // whose cyclones are in it
    for (int i = 0; i < CYCLONES; ++i) {
        vec4 place = u_cyclones[2 * i], kind = u_cyclones[2 * i + 1];
        float away = length(d - place.xyz) / place.w;
        // A loop, not a branch: software GPUs skip it where no texel is near.
        for (int once = away < 3.0 && kind.y > 0.0 ? 0 : 1; once < 1; ++once) {
            float reach = exp(-away * away * 0.8);
            wound = about(wound, place.xyz, kind.x * kind.y * 2.8 * reach / (0.35 + away));
            vec3 east = normalize(cross(vec3(0.0, 0.0, 1.0), place.xyz)), north = cross(place.xyz, east);
            vec3 aside = d - place.xyz;
            float azimuth = atan(dot(aside, north), dot(aside, east));
            float rough = noise_at(d * 14.0, 31) + 0.5 * noise_at(d * 31.0, 32);
            float turn = kind.x * azimuth - 2.1 * log(max(away, 0.03)) + kind.z + 0.9 * rough;
            float arm = 0.5 + 0.5 * cos(turn);
            float size = smoothstep(0.02, 0.25, away) * exp(-away * away * 0.55);
            front += kind.y * size * arm * arm * arm;
            gap += kind.y * size * smoothstep(0.45, 1.0, 0.5 + 0.5 * cos(turn - 2.0));
            core += kind.y * exp(-away * away * 18.0);
        }
    }
#endif
    float sine = d.z;
    float bend = 9.0 * noise_at(d * 1.7, 40) + 5.0 * noise_at(d * 4.1, 41);
    float latitude = degrees(asin(clamp(sine, -1.0, 1.0))) + bend;
    float rain = band(latitude, 6.0, 8.0), south = abs(latitude);
    float dry = band(south, 24.0, 9.5), storms = band(south, 52.0, 14.0), polar = smoothstep(62.0, 80.0, south);

    float flat_ = 0.0, fine = 0.0, streaks = 0.0, kinds = 0.0;
    float winds = storms - 0.55 * dry - 0.45 * rain;
    float bands = 0.0, given = 0.0;
    for (int j = 0; j < 2; ++j) {
        int seed = int(u_life[j].x);
        float w = u_life[j].z;
        vec3 p = about_pole(wound, -DRIFT_RAD * winds * u_life[j].y);
#ifdef IMPORTED
        // Squares of the weights add up to one: in the middle of a generation it is the map, before and after what
        // winds make of it.
        given += w * w * cover_at(p);
#endif
        vec3 q = p * vec3(1.0, 1.0, 1.5);
        vec3 bent = q + 0.10 * vec3(noise_at(q * 3.0, seed + 1), noise_at(q * 3.0, seed + 2),
            noise_at(q * 3.0, seed + 3))
            + 0.035 * vec3(noise_at(q * 11.0, seed + 4), noise_at(q * 11.0, seed + 5), noise_at(q * 11.0, seed + 6));
        float frequency = 2.3, weight = 1.0, broad = 0.0, small = 0.0;
        for (int k = 0; k < OCTAVES; ++k) {
            float shown = 1.0 - smoothstep(0.3, 0.6, frequency * u_texel_rad);
            float n = shown * weight * noise_at(bent * frequency, seed + 8 + k);
            if (k < 4) broad += n;
            else small += n;
            frequency *= 2.13;
            weight *= 0.72;
        }
        // Fronts along the jets: bands of a few hundred kilometres, thousands long.
        float jet = noise_at(bent * vec3(2.6, 2.6, 3.6), seed + 40) + 0.4 * noise_at(bent * 6.7, seed + 41)
            + 0.12 * noise_at(bent * 31.0, seed + 42);
        bands += w * exp(-jet * jet * 160.0);
        vec3 along = bent * vec3(1.0, 1.0, 3.2);
        float thin = noise_at(along * 3.1, seed + 20) + 0.6 * noise_at(along * 9.0, seed + 21)
            + 0.45 * noise_at(along * 27.0, seed + 22) + 0.3 * noise_at(along * 81.0, seed + 23);
        flat_ += w * broad;
        fine += w * small;
        streaks += w * thin;
        kinds += w * (noise_at(p * 2.6, seed + 30) + 0.5 * noise_at(p * 7.0, seed + 31));
    }
#ifdef IMPORTED
    flat_ = given - 0.5;
    bands = 0.0;
#endif
    float level = 0.10 * rain - 0.50 * dry + 0.20 * storms + 0.14 * polar;
    float ribbon = (storms + 0.25 * dry) * bands;
    float raw = level + 1.15 * flat_ + (1.9 + 1.0 * rain) * fine + 1.1 * front - 1.0 * gap + 1.2 * core + 0.5 * ribbon;
    float deep = clamp(0.22 + 0.15 * rain + 0.6 * front + 0.8 * core + 0.5 * flat_ + 2.4 * fine + 0.35 * ribbon
        - 0.2 * dry, 0.0, 1.0);
    float towers = clamp(0.5 + 0.45 * rain + 0.1 * dry - 0.35 * polar + 0.15 * storms + 0.9 * kinds + 0.4 * front, 0.0,
        1.0);
    float high = clamp(0.42 + 0.9 * streaks + 0.35 * front + 0.3 * rain + 0.2 * ribbon - 0.25 * dry + 0.15 * storms,
        0.0, 1.0);
#ifdef IMPORTED
    raw = given;
#endif
    return vec4(raw, towers, high, deep);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + u_corner, size = imageSize(o_weather);
    if (any(greaterThanEqual(at, size))) return;
    vec2 place = (vec2(at - u_border) + 0.5) / vec2(size - 2 * u_border) * 2.0 - 1.0;
    // Texels of the border stand for what lies across the square's edge: turned half round about the edge's middle.
    if (abs(place.x) > 1.0) place = vec2(2.0 * sign(place.x) - place.x, -place.y);
    if (abs(place.y) > 1.0) place = vec2(-place.x, 2.0 * sign(place.y) - place.y);
    vec4 found = weather_at(oct_decode(place));
#ifdef IMPORTED
    found.x = clamp(found.x, 0.0, 1.0);
#elif !defined(BALANCE)
    found.x = clamp(0.5 + u_balance.y * (found.x - u_balance.x), 0.0, 1.0);
#endif
    imageStore(o_weather, at, found);
}
