// Rays in a shell of air, by altitude. Bruneton writes radii; here every difference of squared radii is a product of
// altitudes, so that a camera 2 m above a floor of 6 360 000 m keeps its digits in f32. The functions are the same.
//
// h: altitude above the floor, 0 .. thickness, metres. mu: cosine of the angle to the zenith. Distances in metres.
#include "generated/air_model.glsl"
#include "common/safe.glsl"

float paper_thickness() {
    return air_model.thickness_m;
}

float paper_radius(float h) {
    return air_model.radius_m + h;
}

// Distance from altitude h to the floor along a ray that touches it: sqrt(r^2 - R^2). Bruneton's rho.
float paper_tangent(float h) {
    return safe_sqrt(h * (2.0 * air_model.radius_m + h));
}

// The same from the top of the air: Bruneton's H.
float paper_longest_tangent() {
    return paper_tangent(paper_thickness());
}

// Cosine of the horizon's zenith angle at altitude h.
float paper_horizon(float h) {
    return -paper_tangent(h) / paper_radius(h);
}

bool paper_hits_floor(float h, float mu) {
    float along = paper_radius(h) * mu;
    float tangent = paper_tangent(h);
    return along < 0.0 && -along >= tangent;
}

// To where a ray that hits the floor ends, or one that does not leaves through the top. 0 for a camera on that
// boundary.
float paper_distance_to_boundary(float h, float mu, bool hits_floor) {
    float along = paper_radius(h) * mu;
    float tangent = paper_tangent(h);
    float above = max((paper_thickness() - h) * (2.0 * air_model.radius_m + paper_thickness() + h), 0.0);
    // The solutions are root - along and its partner: the one that does not cancel, and the other by their product.
    float root = safe_sqrt(hits_floor ? (along - tangent) * (along + tangent) : along * along + above);
    float larger = root + abs(along);
    float product = hits_floor ? tangent * tangent : above;
    return !hits_floor && along < 0.0 ? larger : safe_divide(product, larger, 0.0);
}

float paper_distance_to_floor(float h, float mu) {
    return paper_distance_to_boundary(h, mu, true);
}

float paper_distance_to_top(float h, float mu) {
    return paper_distance_to_boundary(h, mu, false);
}

// Where a ray is after a distance. Held inside the shell: rounding may put its end just outside.
float paper_altitude_along(float h, float mu, float distance_m) {
    float r = paper_radius(h);
    float rise = distance_m * (distance_m + 2.0 * r * mu);
    return clamp(h + rise / (r + safe_sqrt(r * r + rise)), 0.0, paper_thickness());
}

// A ray's cosine after a distance, or the sun's for `cosine` = mu_s and `step_m` = distance * nu.
float paper_cosine_along(float h, float cosine, float step_m, float h_there) {
    return clamp_cos((paper_radius(h) * cosine + step_m) / paper_radius(h_there));
}

// Moves a camera in space to where its ray enters the air; a camera inside, or below the floor, to within the shell.
// False: the ray misses the air. distance_m: how far the camera was moved.
bool paper_enter(inout float h, inout float mu, inout float mu_s, float nu, out float distance_m) {
    distance_m = 0.0;
    float above = h - paper_thickness();
    if (!(above > 0.0)) {
        h = max(h, 0.0);
        return true;
    }
    float top = air_model.top_radius_m;
    float r = top + above;
    float along = r * mu;
    float tangent2 = above * (2.0 * top + above);
    float under = along * along - tangent2;
    if (along >= 0.0 || under <= 0.0) {
        return false;
    }
    float root = sqrt(under);
    distance_m = tangent2 / (root - along);
    h = paper_thickness();
    mu = clamp_cos(-root / top);
    mu_s = clamp_cos((r * mu_s + distance_m * nu) / top);
    return true;
}
