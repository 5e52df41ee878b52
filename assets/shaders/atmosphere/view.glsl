// Air as one camera sees it, in tables over the directions around it: coordinates and look-ups.
//
// The air is a shell around a sphere, so what a camera sees depends on its altitude, the sun's height there, and the
// direction about the zenith: rows run over the length of the ray in the air (rays that end on the floor, then rays
// that leave it), columns over the azimuth from the sun, slices along the ray. Held is the mean source function of the
// ray up to there, integral of (source x transmittance) / (1 - transmittance), which hardly varies along a ray and
// stays sharp for points 1 m away; and the mean extinction, in finer steps. No phase function is in it: the aureole is
// exact.
//
// Whoever includes this defines air_light_at() and air_mean_extinction(): look-ups of the tables.
#include "generated/air_view.glsl"
#include "atmosphere/slices.glsl"

const int AIR_FINE = 4;   // steps of the table of extinction in each slice

// A direction at the camera.
struct AirRay {
    float mu, sine;    // to the zenith
    float azimuth;     // cosine of the azimuth from the sun
    float nu;          // cosine to the sun
};

// The part of a ray that lies in the air.
struct AirPath {
    float start;           // distance from the camera
    float h, mu;           // where it starts
    float length_m;        // 0: the ray misses the air
    float excess;          // length beyond that of the vertical ray
    float lowest, split;   // see column.glsl
    bool floor_hit;
};

vec3 air_mean_extinction(ivec2 texel);

AirPath air_path(AirView v, float mu, float sine) {
    AirPath p;
    float h = v.altitude_m, r = air_model.radius_m + h;
    float miss = r * sine;   // of the planet's centre
    if (h > air_model.thickness_m) {
        // From space: exact entry point. Differences of squares are formed from factors.
        float inside2 = (air_model.top_radius_m - miss) * (air_model.top_radius_m + miss);
        float below2 = (air_model.radius_m - miss) * (air_model.radius_m + miss);
        float half_chord = safe_sqrt(inside2);
        bool meets = mu < 0.0 && inside2 > 0.0;
        p.floor_hit = meets && below2 >= 0.0;
        p.h = air_model.thickness_m;
        p.mu = -half_chord / air_model.top_radius_m;
        p.start = meets ? max(-r * mu - half_chord, 0.0) : 0.0;
        float to_floor = (inside2 - below2) / max(half_chord + safe_sqrt(below2), 1e-10);
        p.length_m = meets ? (p.floor_hit ? to_floor : 2.0 * half_chord) : 0.0;
    } else {
        p.start = 0.0;
        p.h = h;
        p.mu = mu;
        float to_floor = air_to_floor(h, mu);
        p.floor_hit = to_floor >= 0.0;
        p.length_m = p.floor_hit ? to_floor : air_to_top(h, mu);
    }
    p.lowest = clamp(-(air_model.radius_m + p.h) * p.mu, 0.0, p.length_m);
    p.split = air_split(p.lowest, p.length_m);
    // The difference of two lengths would lose the nadir among its roundings; from the sine it doesn't.
    float start_r = air_model.radius_m + p.h, sine_start = sine * r / start_r, steep = abs(p.mu);
    float less = p.floor_hit || p.mu > 0.0 ? sine_start * sine_start / (1.0 + steep) : 1.0 + steep;
    float around =
        p.floor_hit ? 2.0 * air_model.radius_m + p.h - p.length_m : start_r + p.length_m + air_model.top_radius_m;
    p.excess = less * 2.0 * start_r * p.length_m / around;
    return p;
}

float air_row(AirView v, AirPath p) {
    AirRows rows = p.floor_hit ? v.floor_rays : v.open_rays;
    float row = air_path_row(clamp(p.excess / max(rows.range_m, 1e-6), 0.0, 1.0), rows.kappa);
    return row * float(v.rows - 1) + (p.floor_hit ? 0.0 : float(v.rows));
}

// The azimuth's columns: uniform in its cosine c where the sun stands high or the ray's lowest point is near, and drawn
// to the terminator where that crosses the azimuths: the sun's cosine at the lowest point is m = mid + slope c, and
// columns are as dense as 1 / (|m| + focus)^2. On top of that they crowd around the sun, whose glow through several
// orders of haze is a few ten degrees wide: half of them with the root of what is left up to its azimuth, that is
// evenly in the angle there.
vec2 air_focus(AirView v, AirPath p, float mu, float sine) {
    float t = p.start + p.lowest;
    float there = air_model.radius_m + air_height_along(p.h, p.mu, p.lowest);
    float r = air_model.radius_m + v.altitude_m;
    return vec2(v.sun_mu * (r + t * mu), t * sine * v.sun_sine) / there;
}

float air_focus_map(float m, float width) {
    return m / (abs(m) + width);
}

float air_column_of(AirView v, vec2 focus, float azimuth) {
    float width = v.focus, first = focus.x - focus.y, last = focus.x + focus.y, m = focus.x + focus.y * azimuth;
    float share = 0.5 + 0.5 * azimuth;
    if (first < 0.0 && last > 0.0) {
        float start = air_focus_map(first, width);
        share = (air_focus_map(m, width) - start) / max(air_focus_map(last, width) - start, 1e-7);
    } else {
        share *= (abs(last) + width) / (abs(m) + width);
    }
    float left = 1.0 - clamp(share, 0.0, 1.0);
    return (1.0 - 0.5 * (safe_sqrt(left) + left)) * float(v.columns - 1);
}

float air_azimuth_of(AirView v, vec2 focus, float column) {
    float width = v.focus, first = focus.x - focus.y, last = focus.x + focus.y,
        left = 1.0 - column / float(v.columns - 1);
    float root = sqrt(0.25 + 2.0 * left) - 0.5, share = 1.0 - root * root;
    if (first < 0.0 && last > 0.0) {
        float start = air_focus_map(first, width);
        float at = start + share * (air_focus_map(last, width) - start);
        float m = width * at / max(1.0 - abs(at), 1e-6);
        share = (m - first) / max(last - first, 1e-7);
    } else {
        share = share * (abs(first) + width) / (abs(last) + width - share * (abs(last) - abs(first)));
    }
    return clamp(2.0 * share - 1.0, -1.0, 1.0);
}

// The ray that a texel (row, column) stands for: its path and its cosine to the sun, and the sun's height at its start.
AirPath air_texel_path(AirView v, int row, float column, out float mu_s, out float nu) {
    bool floor_row = row < v.rows;
    float share = float(floor_row ? row : row - v.rows) / float(v.rows - 1);
    AirRows rows = floor_row ? v.floor_rays : v.open_rays;
    float excess = rows.range_m * air_path_share(share, rows.kappa), path = rows.least_m + excess;
    float h = v.altitude_m, r = air_model.radius_m + h;
    AirPath p;
    p.floor_hit = floor_row;
    p.h = min(h, air_model.thickness_m);
    float start_r = air_model.radius_m + p.h;
    // 1 - |mu| for a vertical ray's excess of 0 and onwards: from mu itself the sine of a ray to the nadir would be
    // 5e-4.
    float around = floor_row ? 2.0 * air_model.radius_m + p.h - path : start_r + path + air_model.top_radius_m;
    float less = clamp(excess * around / max(2.0 * start_r * path, 1e-20), 0.0, 2.0);
    p.mu = floor_row ? less - 1.0 : 1.0 - less;
    float mu = p.mu, sine = sqrt(less * (2.0 - less));
    p.start = 0.0;
    if (h > air_model.thickness_m) {
        sine *= start_r / r;
        mu = -sin_from_cos(sine);
        p.start = start_r * p.mu - r * mu;
    }
    p.length_m = path;
    p.lowest = clamp(-start_r * p.mu, 0.0, path);
    p.split = air_split(p.lowest, path);
    nu = mu * v.sun_mu + sine * v.sun_sine * air_azimuth_of(v, air_focus(v, p, mu, sine), column);
    mu_s = clamp_cos((r * v.sun_mu + p.start * nu) / start_r);
    nu = clamp_cos(nu);
    return p;
}

// Where in the tables a ray lies; the last member is its share between the two rows and the two columns.
struct AirCell {
    ivec2 corner;   // column, row
    vec2 share;
};

// Mean source function of a ray up to a slice, packed: both kinds without their phase functions. One layer more holds
// what a whole ray scatters towards the camera per metre of it in the air.
void air_light_at(AirView v, AirCell cell, int layer, out vec3 first, out vec3 second);

AirCell air_cell(AirView v, AirPath p, AirRay ray) {
    vec2 at = vec2(air_column_of(v, air_focus(v, p, ray.mu, ray.sine), ray.azimuth), air_row(v, p));
    AirCell cell;
    cell.corner = min(ivec2(at), ivec2(v.columns - 2, (p.floor_hit ? 0 : v.rows) + v.rows - 2));
    cell.share = at - vec2(cell.corner);
    return cell;
}

vec3 air_mean_extinction_at(AirCell cell, int slice) {
    ivec2 at = ivec2(cell.corner.y, slice);
    return mix(air_mean_extinction(at), air_mean_extinction(at + ivec2(1, 0)), cell.share.y);
}

// What the air between the camera and a distance along a ray does: transmittance, and the light that it scatters
// towards the camera for a unit sun; path: metres of it in the air. Beyond the floor, where ground lies below it, the
// floor's air goes on.
void air_between(AirView v, AirRay ray, float distance_m, out vec3 transmittance, out vec3 first, out vec3 second,
    out float path) {
    AirPath p = air_path(v, ray.mu, ray.sine);
    float t = clamp(distance_m - p.start, 0.0, p.length_m);
    float deeper = p.floor_hit ? max(distance_m - p.start - p.length_m, 0.0) : 0.0;
    float slice = air_slice_of(t, p.length_m, p.lowest, p.split) * float(v.slices);
    AirCell cell = air_cell(v, p, ray);
    int low = min(int(slice), v.slices - 1);
    vec3 low_first, low_second, high_first, high_second;
    air_light_at(v, cell, low, low_first, low_second);
    air_light_at(v, cell, low + 1, high_first, high_second);
    float fine = slice * float(AIR_FINE);
    int fine_low = min(int(fine), AIR_FINE * v.slices - 1);
    vec3 extinction = air_unpack(mix(air_mean_extinction_at(cell, fine_low), air_mean_extinction_at(cell, fine_low + 1),
        fine - float(fine_low)));
    vec3 depth = t * extinction + deeper * air_extinction(air_density(0.0));
    transmittance = exp(-depth);
    vec3 taken = air_taken(depth, transmittance);
    first = taken * air_unpack(mix(low_first, high_first, slice - float(low)));
    second = taken * air_unpack(mix(low_second, high_second, slice - float(low)));
    path = t + deeper;
}

// For the whole ray, to space or to the floor.
void air_whole(AirView v, AirRay ray, out vec3 transmittance, out vec3 first, out vec3 second, out float path) {
    AirPath p = air_path(v, ray.mu, ray.sine);
    air_between(v, ray, p.start + p.length_m, transmittance, first, second, path);
}

int air_whole_layer(AirView v) {
    return v.slices + 1;
}

// That layer's texel: from the mean source function of the whole ray and its mean extinction.
vec3 air_whole_light(vec3 mean_source, vec3 mean_extinction, float length_m) {
    float length_used_m = max(length_m, 1.0);   // a ray of no length has a limit
    vec3 depth = mean_extinction * length_used_m;
    return air_pack(mean_source * air_taken(depth, exp(-depth)) / length_used_m);
}

// Light from a ray that meets nothing. Where the floor is in its way (ground that lies below the floor leaves such a
// gap) that of the ray that grazes the floor.
void air_open(AirView v, AirRay ray, out vec3 first, out vec3 second, out float path) {
    AirPath p = air_path(v, ray.mu, ray.sine);
    if (p.floor_hit) {
        p.floor_hit = false;
        p.mu = air_horizon_cos(p.h);
        p.length_m = v.open_rays.least_m + v.open_rays.range_m;
        p.excess = v.open_rays.range_m;
        p.lowest = sqrt(air_horizon2(p.h));
    }
    air_light_at(v, air_cell(v, p, ray), air_whole_layer(v), first, second);
    path = p.length_m;
    first = path * air_unpack(first);
    second = path * air_unpack(second);
}
