// Light that comes through a cloud which is even sideways and swallows nothing (delta-Eddington, Joseph, Wiscombe and
// Weinman 1976; without absorption it has this closed form, Shettle and Weinman 1970).

// x: share of the sunlight that comes through as a beam, what goes straight on in the droplets' forward peak included;
// y: as light from all over the sky; z: the share of the light of an even sky above that comes through. depth: along
// the sun's ray, mu: the sun's cosine to the zenith, g: the droplets' asymmetry.
vec4 slab_transmittance(float depth, float mu, float g) {
    float forward = max(g, 0.0), kept = (1.0 - forward * forward) * depth;
    float beam = exp(-kept), vertical = (1.0 - g) * depth * mu;
    float total = ((2.0 / 3.0 + mu) + (2.0 / 3.0 - mu) * beam) / (4.0 / 3.0 + vertical);
    return vec4(beam, max(total - beam, 0.0), 1.0 / (1.0 + 0.75 * vertical), 0.0);
}
