// How dense clouds of water are at a place: extinction relative to that of the layer's densest cloud, 0..1. Ice has a
// sheet instead: cirrus.glsl.
//
//   float cloud_density(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims)
//   float cloud_column(int layer, CloudWeather w, float density)        optical depth, from base to top
//
// place: metres from the anchor in planet axes; share: height in the layer, 0 base .. 1 top; footprint_m: what the
// sample stands for, a pixel's width or a step's length. rims: octaves of billows on the rim, 0..2.
//
// Noise is spread evenly over 0..1, so "noise above 1 - cover" is cloud on a share `cover` of the space. What a
// footprint is too wide to show is not dropped but averaged: the share of the values it hides that lie above the
// threshold, so the same cloud that is a thing with edges from near is a grey of the right mean from far, and coverage
// is the same at all distances (docs/cloud-pictures.md, "Density"). Shape and rims are what Schneider 2015 calls base
// shape and detail: the rims erode the shape's edges.
#include "generated/bindings.glsl"
#include "clouds/weather_map.glsl"
#include "clouds/cirrus.glsl"

layout(binding = CLOUD_SHAPE_UNIT) uniform sampler3D u_cloud_shape;
layout(binding = CLOUD_RIMS_UNIT) uniform sampler3D u_cloud_rims;

// A program for places without any cirrus knows so at build time, and takes less time.
#ifdef CLOUD_NO_CIRRUS
#define CLOUD_IS_CIRRUS(layer) false
#else
#define CLOUD_IS_CIRRUS(layer) (cloud_view.layers[layer].kind == CLOUD_CIRRUS)
#endif

const float CLOUD_RIM = 0.24;         // of the rims' noise against the shape's
const float CLOUD_RIM_NEAR = 0.09;
const float CLOUD_EDGE = 0.07;        // of noise above the threshold until the cloud is densest
const float CLOUD_SCARCE = 0.12;      // cover below which the threshold rises out of reach
// mean filled share of a cloud's height: bases, tops and places between are thin
const float CLOUD_MEAN_FILL = 0.4;
const float CLOUD_OWN_FILL = 0.85;    // the same of a cloud up to its own top
const float CLOUD_CLUMP = 0.5;        // way through a cloud that is too small to be told apart, of its height
// sqrt(0.5) - 0.5 of two volumes whose weights are a unit vector, and twice the rims' weights
const float CLOUD_MOST_NOISE = 0.54;

const float CLOUD_LEAST_HALF_WIDTH = 0.015;   // of a threshold that hides nothing
const float CLOUD_LEAST = 1e-4;               // cover below which no noise makes cloud

// Octaves (factors of two) of optical thickness for a spread of 1: by weather, 0..1, and from the least noise to the
// most; of towers, which else would all be white, those that the least takes away besides.
const float CLOUD_BY_DEPTH = 5.5, CLOUD_BY_NOISE = 2.0, CLOUD_HOLLOW = 1.5;
// Of weather that is as thick as without a spread: of fields, of clouds by themselves, which are white whatever the
// weather, and more by cover.
const float CLOUD_MEAN_DEPTH = 0.6, CLOUD_SCARCE_DEPTH = 0.235, CLOUD_COVER_DEPTH = 0.65;
const float CLOUD_ALIKE = 0.65;           // of a sheet's octaves below towers, that are taken off for a spread of 1
const float CLOUD_SEAMS = 0.06;       // of a closed sheet's cover
// of the cells' volume in the noise, of the clouds', and the sum of their squares
const float CLOUD_CLUSTERS = 0.6, CLOUD_CELLS = 0.47, CLOUD_BOTH = 0.5809;
// Streets of the trades. Of noise at most; from street to street on the mean, in thicknesses of the first layer; of the
// cells' noise, how much they replace.
const float CLOUD_STREETS = 0.28, CLOUD_STREET_WIDE = 2.31, CLOUD_STREET_CELLS = 0.6;
// of CLOUD_STREETS: their mean, which is taken off, and the variance about it
const float CLOUD_STREET_MEAN = 0.587, CLOUD_STREET_VARIANCE = 0.234;
const float CLOUD_STREET_MOST = 1.5;   // of CLOUD_STREETS: no street is higher

// Mean over values within `half_width` around x of a ramp from 0 at 0 to 1 at `edge`: the difference of its integral.
float ramp_integral(float x, float edge) {
    float inside = clamp(x, 0.0, edge);
    return 0.5 * inside * inside / edge + max(x - edge, 0.0);
}

float filtered_ramp(float x, float half_width, float edge) {
    return (ramp_integral(x + half_width, edge) - ramp_integral(x - half_width, edge)) / (2.0 * half_width);
}

// Share of the noise's variance that a level doesn't show.
float hidden_variance_share(float level, CloudFilter volume) {
    return clamp(0.5 + (level - volume.half_level) * volume.per_level, 0.0, 1.0);
}

// What a layer makes of the weather: a kind by name has towers and depth of its own.
CloudWeather cloud_weather_of(CloudViewLayer shell, CloudWeather w) {
    return CloudWeather(w.cover, shell.follows * w.towers + shell.towers, w.high, shell.follows * w.deep + shell.deep,
        w.thickness);
}

// How much of the layer's thickness its clouds fill.
float cloud_tallness(CloudViewLayer shell, CloudWeather w) {
    return mix(shell.least_tall, 1.0, w.towers);
}

// How much of the map's cover a height in the layer has: a flat base, then less the higher, so that a cloud's top is as
// high as its noise and the weather let it be.
// An anvil spreads below the layer's top.
float cloud_height_cover(CloudViewLayer shell, float share, CloudWeather w) {
    float x = share / cloud_tallness(shell, w),
        spread = shell.anvil * clamp(8.0 * share - 6.0, 0.0, 1.0) * clamp(12.0 - 12.0 * share, 0.0, 1.0);
    return smoothstep(0.0, shell.base, share) * max(clamp((1.0 - x) * shell.steep, 0.0, 1.0), spread);
}

// Share of a layer's height above which there is no cloud between two places of a ray, whatever the noise; 0: none at
// all.
float cloud_ceiling(int layer, CloudWeather a, CloudWeather b) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float towers = max(cloud_weather_of(shell, a).towers, cloud_weather_of(shell, b).towers),
        reach = shell.kind == CLOUD_CUMULUS ? mix(shell.least_tall, 1.0, towers) : 1.0;
    bool some = max(a.cover, b.cover) * shell.cover_scale > CLOUD_LEAST;
    return shell.kind == CLOUD_UNIFORM || some ? reach : 0.0;
}

// 1 for deep weather, fronts and towers; 0 for sheets.
float cloud_solid(CloudWeather w) {
    return clamp(max(w.deep * w.deep, 1.3 * w.towers - 0.65), 0.0, 1.0);
}

// 1 where convection is shallow and broken: cumulus in open cells and streets.
float cloud_open(CloudWeather w) {
    return clamp(5.0 * w.towers - 2.75, 0.0, 1.0) * clamp(2.2 - 4.0 * w.deep, 0.0, 1.0);
}

// How dense the inside of clouds is that a weather makes: sheets are thin. Optical thickness is spread log-normally
// about that (Cahalan et al. 1994), a column alike from base to top: thick in deep weather, and by noise within it, up
// to the densest there is. The wider the spread, the less do sheets and towers differ on the mean.
float cloud_interior(CloudViewLayer shell, CloudWeather w) {
    float solid = cloud_solid(w), mean = mix(shell.shallow, 1.0, solid),
        spread = shell.follows * cloud_view.thickness_spread;
    float usual = min(CLOUD_SCARCE_DEPTH + w.cover * CLOUD_COVER_DEPTH, CLOUD_MEAN_DEPTH),
        octaves = CLOUD_BY_DEPTH * (w.deep - usual) + CLOUD_BY_NOISE * (w.thickness - 0.5)
            - CLOUD_HOLLOW * solid * (1.0 - w.thickness) - CLOUD_ALIKE * log2(max(mean, 1e-3));
    return min(mean * exp2(spread * octaves), 1.0);
}

// Vertical optical depth of a whole cloud of a weather. density: of the sheet of ice there, if it is one.
float cloud_column(int layer, CloudWeather weather, float density) {
    CloudViewLayer shell = cloud_view.layers[layer];
    CloudWeather w = cloud_weather_of(shell, weather);
    float even = cirrus_filled(shell, vec2(0.0, 1.0));
    float billows = CLOUD_MEAN_FILL * cloud_tallness(shell, w) * cloud_interior(shell, w);
    float mean = shell.kind == CLOUD_UNIFORM ? even : CLOUD_IS_CIRRUS(layer) ? even * density : billows;
    return (shell.top_m - shell.base_m) * shell.extinction_per_m * mean;
}

// Thinner because it is in clumps that hide one another: as a binary mixture of cloud and clear air (Pomraning 1991).
// depth: optical, through one of them.
float cloud_clumped(float share, float hidden, float depth) {
    return share / (1.0 + hidden * (1.0 - share) * depth);
}

// What the two wide volumes say of a place, before its rims.
struct CloudNoise {
    float excess;            // above the threshold
    float hidden_variance;   // of what the footprint is too wide to show
    float hidden_share;      // of the volumes' variance
    float interior;          // how dense clouds of the weather are inside
    float thickness;         // more of that, where the wide volume is above the threshold
    float cover;             // at that height
    float streets;           // how high they are, of noise
    float top;               // share of the layer's height up to which cloud reaches there, on the mean
    vec3 turned, tilted;     // metres, in the frames of the volumes
};

// A place in the frames in which noise is looked up.
struct CloudPlace {
    vec3 turned, tilted;   // metres from the anchor
    vec3 from_middle;      // from the planet's centre, in its radii
};

CloudPlace cloud_place(vec3 place) {
    vec3 turned = cloud_turned(place);
    return CloudPlace(turned, cloud_tilted(place), CLOUD_ORIGIN(bend) + turned * cloud_view.bend.per_m);
}

// A parabola for a sine, of a place in periods. -1..1.
float cloud_wave(float periods) {
    float x = 2.0 * fract(periods) - 1.0;
    return 4.0 * x * (1.0 - abs(x));
}

// The two volumes of the shape: noise around 0, as far as the footprint tells its cells apart, and the share of its
// variance that it shows.
struct CloudShape {
    float broad, wide;
    float broad_resolved, wide_resolved;
};

// Clouds, and the cells and clusters that they are in.
// footprint: in metres, times finer.
CloudShape cloud_shape(CloudPlace p, float footprint, float finer) {
    vec3 second = (CLOUD_ORIGIN(wide) + p.tilted * cloud_view.wide.per_m) * finer;
    vec3 first = (CLOUD_ORIGIN(broad) + p.turned * cloud_view.broad.per_m) * finer;
    float first_level = cloud_level(cloud_view.broad_level, footprint),
        second_level = cloud_level(cloud_view.wide_level, footprint);
    float wide = textureLod(u_cloud_cells, second, second_level + cloud_dither - 0.5).r - 0.5,
        broad = textureLod(u_cloud_shape, first, first_level + cloud_dither - 0.5).r - 0.5;
    float first_resolved = cells_resolved(footprint, cloud_view.broad.per_m),
        second_resolved = cells_resolved(footprint, cloud_view.wide.per_m);
    return CloudShape(broad * first_resolved, wide * second_resolved,
        first_resolved * first_resolved * (1.0 - hidden_variance_share(first_level, cloud_view.shape_filter)),
        second_resolved * second_resolved * (1.0 - hidden_variance_share(second_level, cloud_view.cell_filter)));
}

// Streets of cumulus along the trade winds, which follow the circles of latitude but for the waves of 60 to 450 km that
// bend them and move them nearer and apart. Each begins and ends by itself, every 60 km or so. Waves are of the place
// from the planet's centre, in streets: no look-up.
struct CloudStreets {
    float amount;   // 0: cells, 1: streets
    float noise;    // 0 between streets .. 1, where they are
};

CloudStreets cloud_streets(vec3 at, float trades) {
    float bent = at.z + 2.0 * cloud_wave(dot(at, vec3(0.011, 0.013, 0.006)))
        + 0.8 * cloud_wave(dot(at, vec3(-0.029, 0.027, 0.017)))
        + 0.45 * cloud_wave(dot(at, vec3(0.083, 0.061, -0.037)));
    float row = floor(bent), across = bent - row, between = across * (1.0 - across);
    // Rows differ by sequences that are far from any whole numbers (Roberts 2018).
    float broken = cloud_wave(0.113 * at.x + 0.7549 * row) + cloud_wave(0.119 * at.y + 0.5698 * row);
    float patches = cloud_wave(dot(at, vec3(0.0061, -0.0047, 0.0083)))
        + cloud_wave(dot(at, vec3(0.0053, 0.0097, -0.0041)));
    return CloudStreets(trades * clamp(0.25 + patches, 0.0, 1.0), 16.0 * between * between * (0.55 + 0.225 * broken));
}

// All kinds of layer without a branch: software GPUs execute both sides of one, and a loop's body once even for no
// turns.
CloudNoise cloud_noise(int layer, vec3 place, float share, CloudWeather weather, float footprint_m) {
    CloudViewLayer shell = cloud_view.layers[layer];
    CloudWeather w = cloud_weather_of(shell, weather);
    CloudPlace p = cloud_place(place);
    CloudShape shape = cloud_shape(p, footprint_m * shell.finer, shell.finer);
    // Convection over sea: closed cells with thin seams under sheets, where clouds tower open ones, whose rims are
    // cloud; in the trades streets, or cells that are no open ones. Streets fade before a footprint has half of one.
    float open = cloud_open(w), trades = clamp(2.5 - 5.0 * abs(p.from_middle.z), 0.0, 1.0),
        turned_out = 1.0 - 2.0 * open * (1.0 - trades),
        street_m = CLOUD_STREET_WIDE * cloud_view.thickness_m / shell.finer,
        shown = clamp(1.5 - 3.0 * footprint_m / street_m, 0.0, 1.0);
    float shallow = 1.0 - cloud_solid(w);
    float most = clamp(w.cover * shell.cover_scale, 0.0, 1.0) * (1.0 - CLOUD_SEAMS * shallow),
        cover = most * cloud_height_cover(shell, share, w);
    // Neither where cover ends nor where it closes: rows would be teeth of its border.
    CloudStreets streets = cloud_streets(p.from_middle / (cloud_view.bend.per_m * street_m),
        open * trades * clamp(min(4.0 * most - 0.4, 4.0 - 5.0 * most), 0.0, 1.0));
    float amplitude = CLOUD_STREETS * streets.amount,
        clusters = CLOUD_CLUSTERS * (1.0 - CLOUD_STREET_CELLS * streets.amount);
    float hidden = max(1.0 - CLOUD_CELLS * CLOUD_CELLS / CLOUD_BOTH * shape.broad_resolved
        - CLOUD_CLUSTERS * CLOUD_CLUSTERS / CLOUD_BOTH * shape.wide_resolved, 0.0);
    // Three times a variance is the square of an even spread's half width.
    float variance = 0.25 * shell.rough * shell.rough * (CLOUD_CELLS * CLOUD_CELLS * (1.0 - shape.broad_resolved)
            + clusters * clusters * (1.0 - shape.wide_resolved))
        + 3.0 * CLOUD_STREET_VARIANCE * amplitude * amplitude * (1.0 - shown * shown);
    float wide = shell.rough * clusters * turned_out * shape.wide,
        noise = shell.rough * CLOUD_CELLS * shape.broad + wide
            + shown * amplitude * (2.0 * streets.noise - CLOUD_STREET_MEAN);
    // Two volumes in one reach beyond 0.5, and rims on top of them: without this there would be cloud where there is no
    // cover, cut off along the line where cover begins.
    float scarce = 1.0 - clamp(cover / CLOUD_SCARCE, 0.0, 1.0);
    float excess = noise - (0.5 - cover) - (CLOUD_MOST_NOISE + CLOUD_STREET_MOST * amplitude) * scarce * scarce;
    // At the base, of the clouds among what is hidden: a cloud's top is where its noise meets the threshold. Scarce
    // clouds are no towers.
    float at_base = excess + most - cover, spread = sqrt(variance), least = min(0.2 * spread, 0.5 * most),
        above = at_base > spread ? at_base : max(0.5 * (at_base + spread), least);
    float top = cloud_tallness(shell, w) * clamp(1.0 - (1.0 - above / max(most, CLOUD_LEAST)) / shell.steep, 0.0, 1.0);
    return CloudNoise(excess, variance, hidden, cloud_interior(shell, w), wide - 0.5 + most, cover,
        amplitude, top, p.turned, p.tilted);
}

// How dense clouds are inside: sheets that close the sky are of thick and thin places all the same.
float cloud_inside(CloudNoise n) {
    return exp2(-2.0 * (1.0 - smoothstep(-0.25, 0.4, n.thickness))) * n.interior;
}

// Vertical optical depth of the cloud at a place, from its own base to its own top.
float cloud_own_column(int layer, CloudNoise n) {
    CloudViewLayer shell = cloud_view.layers[layer];
    return (shell.top_m - shell.base_m) * shell.extinction_per_m * cloud_inside(n)
        * max(n.top - 0.5 * shell.base, 0.0) * CLOUD_OWN_FILL;
}

// Billows stand on the cloud that the wide volumes make: away from it they would be balls of their own.
float cloud_relief(CloudViewLayer shell, float excess) {
    return shell.relief * smoothstep(-0.2, 0.05, excess);
}

// How far the noise lies below any cloud, whatever the rims are; 0: there may be some.
float cloud_gap(int layer, CloudNoise n, float footprint_m) {
    float relief = cloud_relief(cloud_view.layers[layer], n.excess);
    footprint_m *= cloud_view.layers[layer].finer;
    float rim_variance = CLOUD_RIM * CLOUD_RIM * hidden_variance_share(cloud_level(cloud_view.fine_level, footprint_m),
        cloud_view.rim_filter)
        + CLOUD_RIM_NEAR * CLOUD_RIM_NEAR * hidden_variance_share(cloud_level(cloud_view.finest_level, footprint_m),
            cloud_view.rim_filter);
    float half_width = max(sqrt(n.hidden_variance + relief * relief * rim_variance), CLOUD_LEAST_HALF_WIDTH);
    float most = n.excess + (CLOUD_RIM + CLOUD_RIM_NEAR) * relief + half_width;
    float gap = max(-most, n.cover >= CLOUD_LEAST ? 0.0 : 1e-6);
    return cloud_view.layers[layer].kind == CLOUD_UNIFORM ? 0.0 : gap;
}

// rims: octaves of billows on the rim, 0..2.
float cloud_rimmed(int layer, CloudNoise n, float share, float footprint_m, int rims) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float excess = n.excess, variance = n.hidden_variance;
    float relief = cloud_relief(shell, excess);
    int turns = excess > -0.3 - 0.5 * sqrt(variance) && n.hidden_share < 0.99 ? rims : 0, i = 0;
    // Left at its end: software GPUs go through the turn, too, in which a loop is left at its head.
    if (rims > 0) do {
        vec3 at = (i == 0 ? CLOUD_ORIGIN(fine) + n.tilted * cloud_view.fine.per_m
            : CLOUD_ORIGIN(finest) + n.turned * cloud_view.finest.per_m) * shell.finer;
        float level = cloud_level(i == 0 ? cloud_view.fine_level : cloud_view.finest_level,
            footprint_m * shell.finer);
        float weight = turns > 0 ? (i == 0 ? CLOUD_RIM : CLOUD_RIM_NEAR) * relief : 0.0;
        float rim = textureLod(u_cloud_rims, at, level + cloud_dither - 0.5).r - 0.5;
        // Billows above, wisps below: at the base the noise is turned round.
        excess += 2.0 * weight * rim * mix(-1.0, 1.0, smoothstep(0.0, 0.25, share));
        variance += weight * weight * hidden_variance_share(level, cloud_view.rim_filter);
    } while (++i < turns);
    float dense = filtered_ramp(excess, max(sqrt(variance), CLOUD_LEAST_HALF_WIDTH), CLOUD_EDGE)
        * step(CLOUD_LEAST, n.cover);
    float interior = cloud_inside(n);
    float billows = interior * cloud_clumped(dense, n.hidden_share,
        interior * shell.extinction_per_m * CLOUD_CLUMP * n.top * (shell.top_m - shell.base_m));

    float even = shell.cover_scale > 0.0 ? 1.0 : 0.0;
    float density = shell.kind == CLOUD_UNIFORM ? even : billows;
    return density * mix(1.0, 4.0 * share * (1.0 - share), shell.parabola);
}

float cloud_density(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims) {
    return cloud_rimmed(layer, cloud_noise(layer, place, share, w, footprint_m), share, footprint_m, rims);
}
