// Where things lie in the tables, and back (Bruneton and Neyret 2008, section 4; Bruneton 2017). A unit number 0..1 is
// the centre of the first .. the centre of the last texel.
#include "atmosphere/paper/geometry.glsl"

float paper_coordinate(float unit, float size) {
    return (0.5 + unit * (size - 1.0)) / size;
}

// What the scattering tables leave open: x the number of layers for nu, y the cosine at which the sun's axis ends.
struct PaperLayout {
    float nu_size;
    float mu_s_min;
};

// -- transmittance: (mu, r) ----------------------------------------------------------------------------------------

vec2 paper_transmittance_unit(float h, float mu) {
    float tangent = paper_tangent(h);
    float longest = paper_longest_tangent();
    float shortest = paper_thickness() - h;
    float unit = (paper_distance_to_top(h, mu) - shortest) / (tangent + longest - shortest);
    return vec2(clamp(unit, 0.0, 1.0), tangent / longest);
}

float paper_altitude_of_tangent(float tangent) {
    return tangent * tangent / (air_model.radius_m + sqrt(air_model.radius_m * air_model.radius_m + tangent * tangent));
}

// mu of a ray from altitude h that leaves through the top after a distance.
float paper_mu_to_top(float h, float distance_m) {
    float above = (paper_thickness() - h) * (2.0 * air_model.radius_m + paper_thickness() + h);
    float twice = 2.0 * paper_radius(h) * distance_m;
    return twice > 0.0 ? clamp_cos((above - distance_m * distance_m) / twice) : 1.0;
}

// mu of a ray that ends on the floor after a distance.
float paper_mu_to_floor(float h, float distance_m) {
    float tangent = paper_tangent(h);
    float twice = 2.0 * paper_radius(h) * distance_m;
    return twice > 0.0 ? clamp_cos(-(tangent * tangent + distance_m * distance_m) / twice) : -1.0;
}

void paper_transmittance_place(vec2 unit, out float h, out float mu) {
    float longest = paper_longest_tangent();
    h = min(paper_altitude_of_tangent(unit.y * longest), paper_thickness());
    float shortest = paper_thickness() - h;
    mu = paper_mu_to_top(h, mix(shortest, unit.y * longest + longest, unit.x));
}

// -- scattering: nu and mu_s along x, mu along y (rays to the floor below, to the top above), r along z -------------

// A place in a scattering table: two texels' worth of nu to mix.
struct PaperPlace {
    vec3 first;
    vec3 second;
    float blend;
};

// The sun's axis, 0 for mu_s_min and below, 1 for the zenith.
float paper_sun_unit(float mu_s, float mu_s_min) {
    float longest = paper_longest_tangent();
    float span = longest - paper_thickness();
    float a = (paper_distance_to_top(0.0, mu_s) - paper_thickness()) / span;
    float last = (paper_distance_to_top(0.0, mu_s_min) - paper_thickness()) / span;
    return max(1.0 - a / last, 0.0) / (1.0 + a);
}

float paper_sun_place(float unit, float mu_s_min) {
    float longest = paper_longest_tangent();
    float span = longest - paper_thickness();
    float last = (paper_distance_to_top(0.0, mu_s_min) - paper_thickness()) / span;
    float a = (last - unit * last) / (1.0 + unit * last);
    return paper_mu_to_top(0.0, paper_thickness() + min(a, last) * span);
}

// (mu, r) as texture coordinates.
vec2 paper_view_coordinates(float h, float mu, bool hits_floor, vec2 size) {
    float tangent = paper_tangent(h);
    float longest = paper_longest_tangent();
    float least = hits_floor ? h : paper_thickness() - h;
    float most = hits_floor ? tangent : tangent + longest;
    // On the floor itself all rays down are equally short.
    float unit = safe_divide(paper_distance_to_boundary(h, mu, hits_floor) - least, most - least, 0.0);
    float from_middle = 0.5 * paper_coordinate(clamp(unit, 0.0, 1.0), 0.5 * size.x);
    return vec2(hits_floor ? 0.5 - from_middle : 0.5 + from_middle, paper_coordinate(tangent / longest, size.y));
}

PaperPlace paper_scattering_place(
    PaperLayout layout_, ivec3 size, float h, float mu, float mu_s, float nu, bool hits_floor
) {
    vec2 view = paper_view_coordinates(h, mu, hits_floor, vec2(size.yz));
    float sun = paper_coordinate(paper_sun_unit(mu_s, layout_.mu_s_min), float(size.x) / layout_.nu_size);
    float layer = clamp(0.5 * nu + 0.5, 0.0, 1.0) * (layout_.nu_size - 1.0);
    float below = floor(layer);
    PaperPlace place;
    place.first = vec3((below + sun) / layout_.nu_size, view);
    place.second = vec3((min(below + 1.0, layout_.nu_size - 1.0) + sun) / layout_.nu_size, view);
    place.blend = layer - below;
    return place;
}

// What a texel of a scattering table stands for. nu is moved to where directions with these mu and mu_s exist.
void paper_scattering_texel(
    PaperLayout layout_, ivec3 size, ivec3 texel,
    out float h, out float mu, out float mu_s, out float nu, out bool hits_floor
) {
    int sun_size = size.x / int(layout_.nu_size);
    float longest = paper_longest_tangent();
    float tangent = longest * float(texel.z) / float(size.z - 1);
    h = min(paper_altitude_of_tangent(tangent), paper_thickness());
    int half_size = size.y / 2;
    hits_floor = texel.y < half_size;
    if (hits_floor) {
        float unit = float(half_size - 1 - texel.y) / float(half_size - 1);
        mu = paper_mu_to_floor(h, mix(h, tangent, unit));
    } else {
        float unit = float(texel.y - half_size) / float(half_size - 1);
        float shortest = paper_thickness() - h;
        mu = paper_mu_to_top(h, mix(shortest, tangent + longest, unit));
    }
    mu_s = paper_sun_place(float(texel.x % sun_size) / float(sun_size - 1), layout_.mu_s_min);
    nu = 2.0 * float(texel.x / sun_size) / (layout_.nu_size - 1.0) - 1.0;
    float spread = sin_from_cos(mu) * sin_from_cos(mu_s);
    nu = clamp(nu, mu * mu_s - spread, mu * mu_s + spread);
}

// -- irradiance: (mu_s, r) ------------------------------------------------------------------------------------------

vec2 paper_irradiance_coordinates(float h, float mu_s, vec2 size) {
    vec2 unit = vec2(0.5 * mu_s + 0.5, clamp(h * air_model.per_thickness, 0.0, 1.0));
    return vec2(paper_coordinate(unit.x, size.x), paper_coordinate(unit.y, size.y));
}
