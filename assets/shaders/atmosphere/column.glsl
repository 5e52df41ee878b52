// Light gathered along one ray through the air, slice by slice: Gauss rule of two points in each slice.
//
// Whoever includes this defines column_middle() and column_source().
#include "atmosphere/slices.glsl"

const float AIR_DEEPEST = 8.0;   // optical depth of a slice beyond which nothing in it counts

struct AirColumn {
    float h, mu, mu_s, nu;   // at the start of the ray, inside the air; nu: cosine between ray and sun
    float path, lowest, split;
    vec3 depth;              // optical depth so far
    float thickest;          // extinction at the end of the last slice, of the strongest wavelength
    vec3 taken;              // integral of extinction times transmittance so far: 1 - exp(-depth), by the same rule as
    vec3 first, second;      // the two integrals of source times transmittance
};

// Called once a slice, with its middle: what varies slowly is looked up there.
void column_middle(float h, float mu, float mu_s, float nu);

// Emission per metre (two kinds that are kept apart) at altitude h, where the ray has cosine mu to the zenith.
void column_source(float h, float mu, float mu_s, float nu, vec3 density, out vec3 first, out vec3 second);

AirColumn air_column(float h, float mu, float mu_s, float nu, float path) {
    AirColumn c;
    c.h = h;
    c.mu = mu;
    c.mu_s = mu_s;
    c.nu = nu;
    c.path = path;
    c.lowest = clamp(-(air_model.radius_m + h) * mu, 0.0, path);
    c.split = air_split(c.lowest, path);
    vec3 extinction = air_extinction(air_density(h));
    c.thickest = max(max(extinction.r, extinction.g), extinction.b);
    c.depth = c.taken = c.first = c.second = vec3(0.0);
    return c;
}

void air_column_node(inout AirColumn c, float t, float height, float weight, vec3 depth, vec3 density,
    vec3 extinction) {
    float r = air_model.radius_m + c.h, there = air_model.radius_m + height;
    vec3 first, second;
    column_source(height, clamp_cos((r * c.mu + t) / there), clamp_cos((r * c.mu_s + t * c.nu) / there), c.nu, density,
        first, second);
    vec3 seen = weight * exp(-depth);
    c.taken += seen * extinction;
    c.first += seen * first;
    c.second += seen * second;
}

void air_column_slice(inout AirColumn c, int slice, int slices) {
    const float X1 = 0.211324865, X2 = 0.788675135;
    float t0 = air_slice_distance(float(slice) / float(slices), c.path, c.lowest, c.split);
    float t1 = air_slice_distance(float(slice + 1) / float(slices), c.path, c.lowest, c.split);
    // In thick air what lies deep in a slice cannot be seen: nodes stay where it can. A ray of no length still has a
    // source.
    float dt = max(min(t1 - t0, AIR_DEEPEST / max(c.thickest, 1e-20)), 1e-4);
    float ta = t0 + X1 * dt, tb = t0 + X2 * dt;
    float ha = air_height_along(c.h, c.mu, ta), hb = air_height_along(c.h, c.mu, tb);
    vec3 da = air_density(ha), db = air_density(hb);
    vec3 ea = air_extinction(da), eb = air_extinction(db);
    // Depth to each node under the straight line through the two extinctions.
    vec3 slope = (eb - ea) / (X2 - X1);
    vec3 depth_a = c.depth + dt * max(ea * X1 - slope * (0.5 * X1 * X1), 0.0);
    vec3 depth_b = c.depth + dt * max(ea * X2 + slope * (0.5 * X2 * X2 - X1 * X2), 0.0);
    float weight = 0.5 * dt, middle = t0 + 0.5 * dt, h_middle = air_height_along(c.h, c.mu, middle);
    float r = air_model.radius_m + c.h, there = air_model.radius_m + h_middle;
    column_middle(h_middle, clamp_cos((r * c.mu + middle) / there), clamp_cos((r * c.mu_s + middle * c.nu) / there),
        c.nu);
    air_column_node(c, ta, ha, weight, depth_a, da, ea);
    air_column_node(c, tb, hb, weight, depth_b, db, eb);
    c.depth += 0.5 * (t1 - t0) * (ea + eb);
    c.thickest = max(max(eb.r, eb.g), eb.b);
}

// Mean source function so far, per extinction: the integrals over 1 - exp(-depth), by the same quadrature, so that it
// stays exact for short and thin paths and is never negative.
vec3 air_column_mean(AirColumn c, vec3 integral) {
    return integral / max(c.taken, 1e-30);
}
