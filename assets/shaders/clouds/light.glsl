// How clouds of the weather stand in for slabs, whose light is known (scattered.glsl): an even sheet that closes the
// sky is one, and is lit as one. A cloud with gaps beside it has sides, and a place in it is lit as if the slab was
// turned towards the sun.
#include "clouds/density.glsl"

// of the square of the sun's cosine: how far clouds that are as tall as wide are turned
const float CLOUD_TURNED = 0.7;
const float CLOUD_LEAK = 0.5;   // through sides, on the way down: of light per optical depth that turns it

// Vertical optical depth of an even layer below a place in it.
float depth_below(int layer, float share) {
    CloudViewLayer shell = cloud_view.layers[layer];
    return (shell.top_m - shell.base_m) * shell.extinction_per_m * share
        * mix(1.0, share * (2.0 - 4.0 / 3.0 * share), shell.parabola);
}

// 0: a sheet from edge to edge, 1: towers with the sun between them. Small gaps already leave tops that are far from
// flat.
float cloud_sides(int layer, CloudWeather w) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float gaps = 1.0 - clamp(w.cover * shell.cover_scale, 0.0, 1.0);
    return shell.kind == CLOUD_CUMULUS ? sqrt(gaps) * cloud_tallness(shell, cloud_weather_of(shell, w)) : 0.0;
}

// Share of the sky that is closed, as far as the ground below is concerned: cirrus hardly dims it.
float cloud_closed(int layer, CloudWeather w) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float cumulus = clamp(w.cover * shell.cover_scale, 0.0, 1.0);
    return shell.kind == CLOUD_CUMULUS ? cumulus : CLOUD_IS_CIRRUS(layer) ? 0.0 : 1.0;
}

// The sun's cosine for slabs that are turned towards it; level_sun: to the zenith.
float cloud_facing(float level_sun, float sides) {
    return sqrt(mix(level_sun * level_sun, 1.0, CLOUD_TURNED * sides));
}

// Share of a slab's light scattered more than once that a cloud with sides still has below an optical depth of `up`. As
// the turn towards the sun fitted to paths of light through such clouds (docs/clouds.md, "Against paths of light").
float cloud_kept(float up, float sides, float g) {
    return exp(-CLOUD_LEAK * sides * (1.0 - g) * up);
}

// Vertical optical depth below a place. column: of its cloud, from base to top; up: above the place, towards the sun.
float cloud_under(int layer, float share, float column, float up) {
    return cloud_view.layers[layer].kind == CLOUD_UNIFORM ? depth_below(layer, share) : max(column - up, 0.0);
}
