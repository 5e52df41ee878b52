// Gullies: relief whose furrows run down the slope and branch; the GPU's side of systems/terrain/gullies.py, which says
// how they are made and whose names these are.
#include "common/noise.glsl"
#include "generated/terrain_gully_numbers.glsl"

// Which way is down for the next layer of gullies.
struct Gullies {
    vec3 falls;      // slope of the ground with the furrows so far
    mat3 d_falls;    // how it changes with the place
    vec3 up;
    float rough;     // metres by metre of relief
    float strength;  // 0..1
    float furrows, seen_furrows;  // metres of relief that are gullies, and what of these the gradients' band shows
    vec3 d_furrows;               // of the seen ones
};

// A layer of gullies at a place.
struct Gully {
    float share;         // of waves; the rest is noise
    float wave;          // in amplitudes of the layer
    vec3 d_share, d_wave;  // by the place, 1/m
};

vec2 gully_circle(float angle) { return vec2(cos(angle), sin(angle)); }

vec2 gully_times(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

vec2 gully_corner(uint x, uint y, uint z) { return vec2(lattice_hash(x, y, z).xy) * NOISE_GRADIENT_SCALE; }

// The wave (x) and the one a quarter further on (y), and their derivatives by the place in cells. turning: of `along`
// by it; bent: of the lattice coordinate.
vec2 gully_wave(ivec3 cell, vec3 f, vec3 along, mat3 turning, mat3 bent, out vec3 d_wave, out vec3 d_next) {
    NOISE_LATTICE_SIDES(cell, a, b)
    vec3 u = noise_weights(f), du = noise_weight_slopes(f);
    vec2 sx = gully_circle(-GULLY_TURN * along.x), sy = gully_circle(-GULLY_TURN * along.y),
        sz = gully_circle(-GULLY_TURN * along.z), sxy = gully_times(sx, sy);
    vec2 c0 = gully_corner(a.x, a.y, a.z), c1 = gully_times(gully_corner(b.x, a.y, a.z), sx);
    vec2 c2 = gully_times(gully_corner(a.x, b.y, a.z), sy), c3 = gully_times(gully_corner(b.x, b.y, a.z), sxy);
    vec2 c4 = gully_times(gully_corner(a.x, a.y, b.z), sz),
        c5 = gully_times(gully_corner(b.x, a.y, b.z), gully_times(sx, sz));
    vec2 c6 = gully_times(gully_corner(a.x, b.y, b.z), gully_times(sy, sz)),
        c7 = gully_times(gully_corner(b.x, b.y, b.z), gully_times(sxy, sz));
    vec2 dx0 = c1 - c0, dx1 = c3 - c2, dx2 = c5 - c4, dx3 = c7 - c6;
    NOISE_STEPS(vec2, u)
    vec2 total = y0 + u.z * dz;
    vec2 by_x = mix(mix(dx0, dx1, u.y), mix(dx2, dx3, u.y), u.z), by_y = mix(dy0, dy1, u.z);
    vec3 by_r = vec3(by_x.x, by_y.x, dz.x), by_i = vec3(by_x.y, by_y.y, dz.y);
    // Of the corners on the far side along each axis.
    vec3 far_r = u * (total.x + (1.0 - u) * by_r), far_i = u * (total.y + (1.0 - u) * by_i);
    vec3 change_r = (by_r * du) * bent + GULLY_TURN * (far_i * turning);
    vec3 change_i = (by_i * du) * bent - GULLY_TURN * (far_r * turning);
    vec3 phase = GULLY_TURN * (along * bent + f * turning);
    vec3 whole_r = change_r - total.y * phase, whole_i = change_i + total.x * phase;
    vec2 there = gully_circle(GULLY_TURN * dot(along, f));
    float per_length = inversesqrt(dot(total, total) + GULLY_ROUND);
    vec2 value = gully_times(total, there) * per_length;
    there *= per_length;
    vec3 longer = (total.x * change_r + total.y * change_i) * (per_length * per_length);
    d_wave = whole_r * there.x - whole_i * there.y - value.x * longer;
    d_next = whole_r * there.y + whole_i * there.x - value.y * longer;
    return value;
}

// A layer at fraction f of its cell; turns the slope by its furrows. bent: how the place that its lattice is asked at
// changes with the place.
Gully gully_layer(ivec3 cell, vec3 f, float wavelength_m, float amplitude_m, mat3 bent, inout Gullies t) {
    vec3 level = t.falls - t.up * dot(t.up, t.falls);
    float steep = length(level), per_slope = 1.0 / max(steep, 1e-6);
    vec3 down = level * per_slope, along = cross(t.up, down);
    mat3 d_level, turning;
    vec3 d_steep;
    for (int k = 0; k < 3; ++k) {
        d_level[k] = t.d_falls[k] - t.up * dot(t.up, t.d_falls[k]);
        d_steep[k] = dot(down, d_level[k]);
        turning[k] = cross(t.up, d_level[k] - down * d_steep[k]) * per_slope;
    }
    float frequency = 1.0 / wavelength_m;
    vec3 d_wave, d_next;
    vec2 value = gully_wave(cell, f, along, turning * wavelength_m, bent, d_wave, d_next);
    float s = clamp((steep - GULLY_LEAST) * (1.0 / (GULLY_FULL - GULLY_LEAST)), 0.0, 1.0);
    Gully gully;
    gully.share = t.strength * (s * s * (3.0 - 2.0 * s));
    gully.wave = GULLY_AMPLITUDE * value.x;
    gully.d_share = (t.strength / (GULLY_FULL - GULLY_LEAST)) * (6.0 * s * (1.0 - s)) * d_steep;
    gully.d_wave = GULLY_AMPLITUDE * frequency * d_wave;
    // What a wave adds to the slope where its phase alone changes.
    float steers = t.rough * (-GULLY_AMPLITUDE * GULLY_TURN * amplitude_m * frequency), pull = gully.share * value.y;
    vec3 d_pull = gully.d_share * value.y + gully.share * frequency * d_next;
    t.falls += steers * pull * along;
    for (int k = 0; k < 3; ++k) t.d_falls[k] += steers * (along * d_pull[k] + pull * turning[k]);
    return gully;
}
