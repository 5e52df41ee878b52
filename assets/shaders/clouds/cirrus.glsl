// Ice: fibres, hooks and veils, in a sheet so thin that a ray meets it at one place.
//
//   float cirrus_density(int layer, vec3 place, CloudWeather w, float footprint_m)     0..1
//   float cirrus_filled(CloudViewLayer shell, vec2 shares)     mean of its profile between two shares of its height
//
// place: where a ray crosses the middle of the layer's height, in metres from the anchor in planet axes. Real fibres
// are ribbons some tens of metres wide: sampled all through a layer of a kilometre, a slanted ray would see their mean.
//
// One map of trails (fibres.comp) at four widths: bands of hundreds of kilometres, fibres, hooks, hair. Only bands and
// patches are held against a threshold; fibres are added up, so that mip levels of the map are nearly their means.
#include "clouds/weather_map.glsl"

layout(binding = CLOUD_FIBRES_UNIT) uniform sampler2D u_cloud_fibres;

const float CIRRUS_LEAST = 0.01, CIRRUS_SCARCE = 0.12;   // covers below which there is none, and below which it thins
// Periods of the map in one of its widest, along its axes: turned against one another, so that repeats fall elsewhere.
const vec2 CIRRUS_FIBRES = vec2(19.0, 3.0), CIRRUS_HOOKS = vec2(11.0, 19.0), CIRRUS_HAIR = vec2(37.0, 6.0);
const vec2 CIRRUS_SWAY = vec2(0.0375, 0.009);   // of the widest period: of one wave a period, and of five
const float CIRRUS_SHARP = 0.6;        // levels finer than a footprint: a linear filter blurs by as much
const float CIRRUS_EQUATOR = 0.03;     // sine of the latitude up to which the chart's halves are mixed
const vec2 CIRRUS_APART = vec2(0.37, 0.61);   // of the southern half: along the equator both would be alike

// x, y: a place on the map, in its widest periods; z: how much longer a length is there than it should be.
// Stereographic from a pole, side 1: the southern, for the northern half; -1: the other way round. Angles are kept.
vec3 cirrus_chart(vec3 turned, float side) {
    float radius = 1.0 / cloud_view.bend.per_m;
    vec3 anchor = CLOUD_ORIGIN(bend) * radius, to = anchor + turned;
    float from = length(anchor), distance_m = length(to), scale = 2.0 * radius / (distance_m + side * to.z);
    // The difference to the anchor's place, without differences of large numbers; half a planet away there is no need.
    bool near = side * anchor.z > -0.5 * from;
    vec2 lean = anchor.xy / max(from + side * anchor.z, 0.1 * from);
    float rise = dot(turned, anchor + to) / (from + distance_m) + side * turned.z;
    vec2 origin = side < 0.0 ? CLOUD_ORIGIN(south).xy : CLOUD_ORIGIN(north).xy;
    vec2 at = near ? origin + cloud_view.north.per_m * scale * (turned.xy - lean * rise)
        : cloud_view.north.per_m * scale * to.xy;
    return vec3(side < 0.0 ? at + CIRRUS_APART : at, scale);
}

// Whole waves a period, so that it repeats with them. Parabolas instead of sines: for what is as long as that they are
// as good.
float cirrus_wave(float at) {
    float x = 2.0 * fract(at) - 1.0;
    return 4.0 * x * (1.0 - abs(x));
}

// Fibres bend over hundreds of kilometres. One axis after the other: areas are kept, nothing is drawn out to strokes.
vec2 cirrus_sway(vec2 at, float bend) {
    at.x += bend * (CIRRUS_SWAY.x * cirrus_wave(at.y + 0.13) + CIRRUS_SWAY.y * cirrus_wave(5.0 * at.y + 0.7));
    at.y += bend * (CIRRUS_SWAY.x * cirrus_wave(at.x + 0.41) + CIRRUS_SWAY.y * cirrus_wave(5.0 * at.x + 0.2));
    return at;
}

// The map turned and length(times) times as fine, as far as a footprint tells its cells apart: whole numbers, so that
// it repeats where the widest does. texels, periods: of the footprint, on the widest.
vec3 cirrus_trails(vec2 at, vec2 times, float texels, float periods) {
    float finer = length(times), level = max(log2(max(texels * finer, 1e-6)) - CIRRUS_SHARP, 0.0);
    level = mix(cloud_view.fibre_levels, level, cells_resolved(periods, finer));
    vec2 turned = vec2(dot(at, vec2(times.x, -times.y)), dot(at, times.yx));
    return textureLod(u_cloud_fibres, turned, level + cloud_dither - 0.5).rgb;
}

// On one half's chart. amount: cover.
float cirrus_on(vec3 chart, CloudViewLayer shell, float amount, float footprint_m) {
    vec2 at = cirrus_sway(chart.xy, shell.bend);
    float periods = footprint_m * cloud_view.north.per_m * chart.z, texels = periods * exp2(cloud_view.fibre_levels);
    vec3 bands = cirrus_trails(at, vec2(1.0, 0.0), texels, periods),
        fibres = cirrus_trails(at, CIRRUS_FIBRES, texels, periods),
        hooks = cirrus_trails(at, CIRRUS_HOOKS, texels, periods),
        hair = cirrus_trails(at, CIRRUS_HAIR, texels, periods);
    // Where ice forms, and what kind: fibres of sheets, or tufts.
    float formed = amount + 0.9 * (bands.b - 0.4) + 0.9 * (bands.r - 0.22),
        sheet = smoothstep(0.2, 1.0, formed + 0.4 * (fibres.b - 0.4)),
        tufted = smoothstep(0.2, 0.8, formed + 0.5 * (0.4 - bands.b));
    float fine = mix(0.6 * sheet * fibres.r, 0.5 * tufted * hooks.g, shell.hooks) * (0.1 + 3.6 * hair.r);
    float soft = shell.veil * sheet * (0.04 + 0.2 * hooks.b);
    // Thick places are rare and stay below the densest.
    return (fine + soft) / (1.0 + fine + soft) * smoothstep(CIRRUS_LEAST, CIRRUS_SCARCE, amount);
}

float cirrus_density(int layer, vec3 place, CloudWeather w, float footprint_m) {
    CloudViewLayer shell = cloud_view.layers[layer];
    vec3 turned = cloud_turned(place);
    float sine = CLOUD_ORIGIN(bend).z + turned.z * cloud_view.bend.per_m, side = sine < 0.0 ? -1.0 : 1.0;
    float share = smoothstep(-CIRRUS_EQUATOR, CIRRUS_EQUATOR, abs(sine)), sum = 0.0;
    int halves = share < 1.0 ? 2 : 1, k = 0;
    do {
        sum += share * cirrus_on(cirrus_chart(turned, side), shell, w.high * shell.cover_scale, footprint_m);
        share = 1.0 - share;
        side = -side;
    } while (++k < halves);
    return sum;
}

// Of a sheet that is densest in the middle of its height, mean of a parabola.
float cirrus_filled(CloudViewLayer shell, vec2 shares) {
    return mix(1.0, 2.0 * (shares.x + shares.y)
        - 4.0 / 3.0 * (shares.x * shares.x + shares.x * shares.y + shares.y * shares.y), shell.parabola);
}
