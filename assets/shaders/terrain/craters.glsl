// Impact craters: systems/terrain/craters.py, which says where the numbers come from, statement by statement. An octave is a 3D
// lattice with a crater a cell; eight cells can reach a point. The first loop finds those that do (about one in sixteen),
// the second works them out: on software GPUs that is half the time of eight whole craters.
#include "common/noise.glsl"

const float CRATER_PEAK_NARROW = 12.0;

// The crater of the cell at `base` + `side`: 24 signed bits an axis, its place and its draws.
ivec3 crater_draws(ivec3 base, ivec3 side) {
    uvec3 word = uvec3(base + side) * 1664525u + 1013904223u;
    return lattice_hash(word.x, word.y, word.z);
}

ivec3 crater_side(ivec3 base, int parity) {
    return (ivec3(parity, parity >> 1, parity >> 2) ^ base) & 1;
}

// One octave at the place `fraction` of `cell`, in float or double. up: the foot on the sphere over the radius; curve: cells
// over the radius; shape: wall, floor, rim, peak; width_m: of a cell; accept: of 4096 draws; spacing_m limits heights to
// what vertices that far apart may need. ground: adds to xyz the gradient of what begin_m does not show and end_m does (begin_m 0:
// all), to w how freshly dug the ground is, 0..1.
#define TERRAIN_CRATER_OCTAVE(REAL, REAL3) \
    REAL terrain_crater_octave( \
        ivec3 cell, REAL3 fraction, REAL3 up, REAL curve, vec4 shape, float width_m, int accept, float spacing_m, \
        float begin_m, float end_m, inout vec4 ground \
    ) { \
        REAL3 f = fraction - REAL(0.5); \
        ivec3 below = ivec3(lessThan(f, REAL3(0.0))); \
        ivec3 base = cell - below; \
        f += REAL3(below) + REAL(0.5); \
        int reached = 0; \
        for (int parity = 0; parity < 8; ++parity) { \
            ivec3 side = crater_side(base, parity), draws = crater_draws(base, side); \
            vec3 v = vec3(f) - vec3(side) - (vec3(draws >> 12) + 2048.5) * (1.0 / 4096.0); \
            reached |= dot(v, v) < 0.25001 && (draws.z & 4095) < accept ? 1 << parity : 0; \
        } \
        REAL total = REAL(0.0); \
        vec4 bent = vec4(0.0); \
        while (reached != 0) { \
            ivec3 side = crater_side(base, findLSB(reached)), draws = crater_draws(base, side); \
            reached &= reached - 1; \
            REAL3 v = f - REAL3(side) - (REAL3(draws >> 12) + REAL(2048.5)) * REAL(1.0 / 4096.0); \
            REAL vv = dot(v, v); \
            vec2 u = vec2(draws.xy & 4095) * (1.0 / 4096.0); \
            REAL e = vv * curve - REAL(2.0) * dot(v, up); \
            REAL root = sqrt(REAL(1.0) + e * curve); \
            REAL z = e / (REAL(1.0) + root); \
            REAL room = max((REAL(0.25) - z * z) / root, REAL(1e-9)), kept = clamp(REAL(16.0) * room - REAL(1.0), REAL(0.0), REAL(1.0)); \
            REAL inverse = REAL(4.0) * REAL(1.0 + 3.0 * u.x) / room; \
            REAL q = min(max(vv - z * z, REAL(0.0)) / root * inverse, REAL(4.0)); \
            float size = inversesqrt(float(inverse)); \
            REAL fresh = kept * (REAL(0.15LF) + REAL(0.85LF) * REAL(u.y) * REAL(u.y)); \
            REAL top = max(REAL(1.0) - REAL(CRATER_PEAK_NARROW) * q, REAL(0.0)); \
            REAL bottom = REAL(shape.z) - REAL(shape.y) + REAL(shape.w) * top * top; \
            float d_bottom = -2.0 * CRATER_PEAK_NARROW * shape.w * float(top); \
            REAL bowl = REAL(shape.z) + REAL(shape.x) * (q - REAL(1.0)); \
            REAL width = REAL(0.15LF) * REAL(shape.y); \
            REAL t = clamp(REAL(0.5) + REAL(0.5) * (bowl - bottom) / width, REAL(0.0), REAL(1.0)); \
            REAL inside = bottom + (bowl - bottom) * t + width * t * (REAL(1.0) - t); \
            float d_inside = d_bottom + (shape.x - d_bottom) * float(t); \
            REAL left = (REAL(4.0) - q) * REAL(1.0LF / 3.0LF); \
            REAL outside = REAL(shape.z) * left * left * left; \
            float d_outside = -shape.z * float(left * left); \
            width = REAL(shape.z) * (REAL(2.2LF) - REAL(1.6LF) * fresh); \
            t = clamp(REAL(0.5) + REAL(0.5) * (outside - inside) / width, REAL(0.0), REAL(1.0)); \
            REAL profile = outside + (inside - outside) * t - width * t * (REAL(1.0) - t); \
            float slope = d_outside + (d_inside - d_outside) * float(t); \
            t = clamp(REAL(1.5) - q, REAL(0.0), REAL(1.0)); \
            REAL cover = kept * t * t * (REAL(3.0) - REAL(2.0) * t); \
            float d_cover = -6.0 * float(kept * t * (REAL(1.0) - t)); \
            float wide_m = 2.0 * size * width_m; \
            float seen = terrain_layer_weight(wide_m, end_m) - (begin_m > 0.0 ? terrain_layer_weight(wide_m, begin_m) : 0.0); \
            float steep = size * float(fresh) * slope - float(total) / width_m * d_cover; \
            float dug = max(4.0 * float(fresh) - 3.0, 0.0) * min(float(left), 1.0); \
            bent = bent * (1.0 - seen * float(cover)) \
                + seen * vec4((2.0 * float(inverse) / float(root) * steep) * vec3(v), dug); \
            REAL shown = REAL(terrain_height_weight(wide_m, spacing_m)); \
            total = total * (REAL(1.0) - shown * cover) \
                + shown * profile * fresh * REAL(width_m) / sqrt(inverse); \
        } \
        ground += bent; \
        return total; \
    }

TERRAIN_CRATER_OCTAVE(float, vec3)
TERRAIN_CRATER_OCTAVE(double, dvec3)
