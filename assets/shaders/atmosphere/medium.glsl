// Clear air: densities, extinction, phase functions, and the geometry of rays through a spherical shell.
//
// h: altitude above the floor (the reference sphere), r = R + h, mu: cosine to the zenith, t: distance along a ray. All
// lengths in metres. Below the floor the floor's density holds; above the top there is nothing.
#include "common/safe.glsl"
#include "generated/air_model.glsl"

// Densities relative to the floor (Rayleigh, Mie) and to the layer's centre (absorber, a tent as in Bruneton 2017).
vec3 air_density(float h) {
    h = max(h, 0.0);
    float tent = max(1.0 - abs(h - air_model.absorber_height_m) * air_model.absorber_slope_per_m, 0.0);
    return vec3(exp(-h / air_model.rayleigh_height_m), exp(-h / air_model.mie_height_m), tent);
}

// Extinction per metre at the three wavelengths.
vec3 air_extinction(vec3 density) {
    return density.x * air_model.rayleigh_per_m + density.y * air_model.mie_extinction_per_m
        + density.z * air_model.absorption_per_m;
}

// Rayleigh's phase function, 1/sr.
float air_rayleigh_phase(float nu) {
    return 3.0 / (16.0 * PI) * (1.0 + nu * nu);
}

// Cornette and Shanks 1992, equation 8, 1/sr. The base 1 + g^2 - 2 g nu without its cancellation near the peak.
float air_mie_phase(float nu) {
    float g = air_model.mie_asymmetry, g2 = g * g, size = abs(g);
    float base = (1.0 - size) * (1.0 - size) + 2.0 * size * (1.0 - sign_nonzero(g) * nu);
    return 3.0 / (8.0 * PI) * (1.0 - g2) / (2.0 + g2) * (1.0 + nu * nu) / (base * sqrt(base));
}

// Altitude after a distance t. Without the cancellation of sqrt(r^2 + ...) - R.
float air_height_along(float h, float mu, float t) {
    float r = air_model.radius_m + h;
    float q = t * (2.0 * r * mu + t);
    return h + q / (safe_sqrt(r * r + q) + r);
}

// h (2 R + h): the square of the distance to the horizon.
float air_horizon2(float h) {
    return h * (2.0 * air_model.radius_m + h);
}

// Cosine to the zenith of the horizon, h >= 0.
float air_horizon_cos(float h) {
    return -sqrt(air_horizon2(h)) / (air_model.radius_m + h);
}

// Distance to the top of the air from inside (0 <= h <= thickness).
float air_to_top(float h, float mu) {
    float b = (air_model.radius_m + h) * mu;
    float c = max((air_model.thickness_m - h) * (air_model.top_radius_m + air_model.radius_m + h), 0.0);
    float root = sqrt(b * b + c);
    return b < 0.0 ? root - b : c / max(root + b, 1e-20);
}

// Distance to the floor for h >= 0; negative where the ray misses it. c = h (2R + h) keeps the test right near the
// floor.
float air_to_floor(float h, float mu) {
    float b = (air_model.radius_m + h) * mu, c = air_horizon2(h);
    float discriminant = b * b - c;
    return mu < 0.0 && discriminant >= 0.0 ? c / max(sqrt(discriminant) - b, 1e-20) : -1.0;
}

// 1 - exp(-depth), from a series where the difference would round to nothing.
vec3 air_taken(vec3 depth, vec3 transmittance) {
    vec3 thin = depth * (1.0 - depth * (0.5 - depth * (1.0 / 6.0)));
    return mix(1.0 - transmittance, thin, lessThan(depth, vec3(0.01)));
}

// Values that fall exponentially over the nodes of a table are stored as their fourth root: linear interpolation is
// then 16 times as accurate as of the value itself (relative error d^2 / 32 instead of d^2 / 2 for a step of e^d, to
// leading order).
vec3 air_pack(vec3 value) {
    return sqrt(sqrt(max(value, 0.0)));
}

vec3 air_unpack(vec3 stored) {
    stored *= stored;
    return stored * stored;
}

// Nodes dense at both ends of a range of path lengths: x in 0..1 to y in 0..1, more of them at the short end for a
// larger kappa. air_path_share is the inverse.
float air_path_row(float x, float kappa) {
    float a = kappa * sqrt(x), b = sqrt(1.0 - x);
    return a / (a + b);
}

float air_path_share(float y, float kappa) {
    float b = kappa * (1.0 - y);
    return y * y / max(y * y + b * b, 1e-20);
}
