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
#include "generated/weather.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#ifdef BALANCE
layout(binding = 0, rgba32f) uniform writeonly image2D o_weather;
#else
layout(binding = 0, rgba8) uniform writeonly image2D o_weather;
#endif
layout(location = 0) uniform int u_border;
layout(location = 1) uniform ivec2 u_corner;          // of the tile
layout(location = 3) uniform float u_balance_level;   // cover = 0.5 + slope (raw - level)
layout(location = 4) uniform float u_balance_slope;
layout(location = 7) uniform float u_broken_slope;    // how fast broken convection's cover changes, over others'
layout(location = 5) uniform float u_texel_rad;      // octaves that are finer than the map's texels would only be grain
#ifdef IMPORTED
layout(binding = 0) uniform sampler2D u_cover;       // of a file, on a square like this one's
layout(location = 6) uniform float u_cover_border;   // texels
#endif

const float BROKEN_RAW = 0.0;   // of broken convection's cover
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

// What cyclones do to a place: where the air was before they wound it up, and how much there is of their fronts, of the
// dry slots beside these, and of their cores. Shapes are our own, by eye.
struct Cyclonic {
    vec3 wound;
    float front, gap, core;
};

Cyclonic cyclones_at(vec3 d) {
    Cyclonic found = Cyclonic(d, 0.0, 0.0, 0.0);
#ifndef IMPORTED   // whose cyclones are in it
    for (int i = 0; i < CYCLONES; ++i) {
        Cyclone c = weather.cyclones[i];
        float away = length(d - c.direction) / c.size;
        // A loop, not a branch: software GPUs skip it where no texel is near.
        for (int once = away < 3.0 && c.strength > 0.0 ? 0 : 1; once < 1; ++once) {
            float reach = exp(-away * away * 0.8);
            found.wound = about(found.wound, c.direction, c.winding * c.strength * 2.8 * reach / (0.35 + away));
            vec3 east = normalize(cross(vec3(0.0, 0.0, 1.0), c.direction)), north = cross(c.direction, east);
            vec3 aside = d - c.direction;
            float azimuth = atan(dot(aside, north), dot(aside, east));
            float rough = noise_at(d * 14.0, 31) + 0.5 * noise_at(d * 31.0, 32);
            float turn = c.winding * azimuth - 2.1 * log(max(away, 0.03)) + c.phase + 0.9 * rough;
            float arm = 0.5 + 0.5 * cos(turn);
            float size = smoothstep(0.02, 0.25, away) * exp(-away * away * 0.55);
            found.front += c.strength * size * arm * arm * arm;
            found.gap += c.strength * size * smoothstep(0.45, 1.0, 0.5 + 0.5 * cos(turn - 2.0));
            found.core += c.strength * exp(-away * away * 18.0);
        }
    }
#endif
    return found;
}

// Belts of latitude, 0..1 each, bent by noise: rain belt, dry belts, storm tracks, polar sheets.
struct Belts {
    float rain, dry, storms, polar;
};

Belts belts_at(vec3 d) {
    float sine = d.z;
    float bend = 9.0 * noise_at(d * 1.7, 40) + 5.0 * noise_at(d * 4.1, 41);
    float latitude = degrees(asin(clamp(sine, -1.0, 1.0))) + bend, south = abs(latitude);
    return Belts(band(latitude, 6.0, 8.0), band(south, 24.0, 9.5), band(south, 52.0, 14.0),
        smoothstep(62.0, 80.0, south));
}

// Sums over the generations of noise.
struct WeatherNoise {
    float broad, fine;   // the first four octaves; finer ones
    float streaks;       // of cirrus
    float kinds;         // towers or sheets
    float jets;          // bands of cloud along them
    float imported;      // cover of a file
};

void add_generation(inout WeatherNoise sum, Generation g, vec3 wound, float winds) {
    vec3 p = about_pole(wound, -DRIFT_RAD * winds * g.age);
#ifdef IMPORTED
    // Squares of the weights add up to one: in the middle of a generation it is the map, before and after what winds
    // make of it.
    sum.imported += g.weight * g.weight * cover_at(p);
#endif
    vec3 q = p * vec3(1.0, 1.0, 1.5);
    vec3 bent = q + 0.10 * vec3(noise_at(q * 3.0, g.seed + 1), noise_at(q * 3.0, g.seed + 2),
        noise_at(q * 3.0, g.seed + 3))
        + 0.035 * vec3(noise_at(q * 11.0, g.seed + 4), noise_at(q * 11.0, g.seed + 5), noise_at(q * 11.0, g.seed + 6));
    float frequency = 2.3, amplitude = 1.0, broad = 0.0, fine = 0.0;
    for (int k = 0; k < OCTAVES; ++k) {
        float visible = 1.0 - smoothstep(0.3, 0.6, frequency * u_texel_rad);
        float n = visible * amplitude * noise_at(bent * frequency, g.seed + 8 + k);
        if (k < 4) broad += n;
        else fine += n;
        frequency *= 2.13;
        amplitude *= 0.68;
    }
    // Fronts along the jets: bands of a few hundred kilometres, thousands long.
    float jet = noise_at(bent * vec3(2.6, 2.6, 3.6), g.seed + 40) + 0.4 * noise_at(bent * 6.7, g.seed + 41)
        + 0.12 * noise_at(bent * 31.0, g.seed + 42);
    sum.jets += g.weight * exp(-jet * jet * 160.0);
    vec3 along = bent * vec3(1.0, 1.0, 3.2);
    float thin = noise_at(along * 3.1, g.seed + 20) + 0.6 * noise_at(along * 9.0, g.seed + 21)
        + 0.45 * noise_at(along * 27.0, g.seed + 22) + 0.3 * noise_at(along * 81.0, g.seed + 23);
    sum.broad += g.weight * broad;
    sum.fine += g.weight * fine;
    sum.streaks += g.weight * thin;
    sum.kinds += g.weight * (noise_at(p * 2.6, g.seed + 30) + 0.5 * noise_at(p * 7.0, g.seed + 31));
}

// Of a direction from the planet's centre, as in the image.
vec4 weather_at(vec3 d) {
    Cyclonic c = cyclones_at(d);
    Belts b = belts_at(d);
    WeatherNoise n = WeatherNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    float winds = b.storms - 0.55 * b.dry - 0.45 * b.rain;
    for (int j = 0; j < 2; ++j) add_generation(n, weather.generations[j], c.wound, winds);
#ifdef IMPORTED
    n.broad = n.imported - 0.5;
    n.jets = 0.0;
#endif
    // Sheets of stratocumulus in the dry belts, over half of their length: the cold sides of seas.
    float decks = b.dry * smoothstep(-0.05, 0.2, noise_at(d * 2.3, 50) + 0.3 * noise_at(d * 6.1, 51));
    float level = 0.10 * b.rain - 0.24 * b.dry + 0.20 * b.storms + 0.14 * b.polar + 0.75 * decks;
    float ribbon = (b.storms + 0.25 * b.dry) * n.jets;
    float raw = level + 1.15 * n.broad + (1.8 + 0.8 * b.rain) * n.fine + 1.1 * c.front - 0.6 * c.gap + 1.2 * c.core
        + 0.5 * ribbon;
    float deep = clamp(0.22 + 0.15 * b.rain + 0.6 * c.front + 0.8 * c.core + 0.5 * n.broad + 2.4 * n.fine
        + 0.35 * ribbon - 0.2 * b.dry - 0.3 * c.gap - 0.2 * decks, 0.0, 1.0);
    float towers = clamp(0.5 + 0.45 * b.rain + 0.1 * b.dry - 0.35 * b.polar + 0.15 * b.storms + 0.9 * n.kinds
        + 0.4 * c.front + 0.3 * c.gap - 0.6 * decks, 0.0, 1.0);
    // Cold air over warm sea, behind fronts and in the trades: neither closed nor clear over hundreds of kilometres.
    float broken = smoothstep(0.55, 0.75, towers) * (1.0 - smoothstep(0.3, 0.55, deep));
    raw = mix(raw, BROKEN_RAW + u_broken_slope * raw, broken);
    // Anvils of the rain belt's clusters.
    float anvils = b.rain * clamp(3.0 * n.fine + 0.6 * n.broad, 0.0, 1.0);
    float high = clamp(0.42 + 0.9 * n.streaks + 0.35 * c.front + 0.3 * b.rain + 0.2 * ribbon - 0.25 * b.dry
        + 0.15 * b.storms + 0.5 * anvils, 0.0, 1.0);
#ifdef IMPORTED
    raw = n.imported;
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
    found.x = clamp(0.5 + u_balance_slope * (found.x - u_balance_level), 0.0, 1.0);
#endif
    imageStore(o_weather, at, found);
}
