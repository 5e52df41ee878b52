// The moving sea at a point of the calm one: where it goes, how it lies, and how rough it is below what can be seen.
//
//   SeaPlace   sea_place(vec3 D)                                     D: foot offset of the calm sea's point from the
//   anchor vec3       sea_moved(SeaPlace place, float depth_m, float spacing_m)      east, north, up in the place's
//   axes, m SeaSurface sea_surface(SeaPlace place, float depth_m, vec4 footprint)     footprint: covariance of a pixel,
//   sea_footprint() vec4       sea_footprint(SeaPlace place, vec3 view, float distance_m)     view: unit, towards the
//   camera
//
// systems/ocean/wave_probe.py asks the same functions on arrays; engine/waves has them in float64. Neither asin nor
// acos: what a wave has travelled from the anchor, x, follows from the offset along it, q1, and across it, q2, in
// radii:
//   sin x = q1 + c0 q2^2 / (sin l + w), w = s0 up + c0 q1, sin l = hypot(w, q2); c0, s0 of the anchor's angle from the
//   origin.
#include "common/constants.glsl"
#include "ocean/wave_block.glsl"

struct SeaPlace {
    vec2 at;       // from the anchor along its tangents, as an arc, m
    vec2 q;        // the same as a chord, in radii
    float up;      // cosine of the angle from the anchor
    vec3 east, north, zenith;   // axes, the anchor's carried along the great circle
};

struct SeaSurface {
    vec3 normal;     // unit, planet axes
    vec3 variance;   // of the slopes that `normal` has not: along east, along north, mixed
    float jacobian;  // area over that of the calm sea: small where crests are about to break
};


SeaPlace sea_place(vec3 D) {
    SeaPlace p;
    vec3 axis = frame.anchor_up;
    p.q = vec2(dot(D, sea_waves.east), dot(D, sea_waves.north)) / planet.radius_m;
    float q2 = dot(p.q, p.q);
    p.up = 1.0 + dot(D, axis) / planet.radius_m;
    p.at = p.q * (sea_waves.radius_m * (1.0 + q2 * (1.0 / 6.0 + q2 * (3.0 / 40.0))));
    p.zenith = normalize(axis + D / planet.radius_m);
    vec3 carry = (axis + p.zenith) / max(1.0 + p.up, 1e-6);
    p.east = sea_waves.east - p.q.x * carry;
    p.north = sea_waves.north - p.q.y * carry;
    return p;
}

// The same by where it lies on the map of arcs: a kilometre away as good, where the planet is large beside that.
SeaPlace sea_place_at(vec2 at) {
    vec2 arc = at / sea_waves.radius_m;
    float x2 = dot(arc, arc);
    SeaPlace p;
    p.at = at;
    p.q = arc * (1.0 - x2 * (1.0 / 6.0 - x2 / 120.0));
    float q2 = dot(p.q, p.q);
    p.up = sqrt(max(1.0 - q2, 0.0));
    vec3 fall = frame.anchor_up * (-q2 / (1.0 + p.up)), aside = sea_waves.east * p.q.x + sea_waves.north * p.q.y;
    p.zenith = normalize(frame.anchor_up + aside + fall);
    vec3 carry = (frame.anchor_up + p.zenith) / (1.0 + p.up);
    p.east = sea_waves.east - p.q.x * carry;
    p.north = sea_waves.north - p.q.y * carry;
    return p;
}

// (sin, cos) of 2 pi times a number of cycles: polynomials of half the angle, 1.2e-6.
vec2 sea_circle(float cycles) {
    float f = cycles - floor(cycles + 0.5), u = f * f;
    float s = f * (3.14158202 + u * (-5.16714278 + u * (2.54189884 - u * 0.55463571)));
    float c = 0.99999995 + u * (-4.93479286 + u * (4.05841191 + u * (-1.33188009 + u * 0.21969665)));
    return vec2(2.0 * s * c, 1.0 - 2.0 * s * s);
}

// asin, for what is seen of one place: 1e-7 up to 0.3.
float sea_asin(float y) {
    float y2 = y * y;
    return y * (1.0 + y2 * (1.0 / 6.0 + y2 * (3.0 / 40.0 + y2 * (15.0 / 336.0 + y2 * (105.0 / 3456.0 + y2 * 0.0223)))));
}

// Factor of a wave's amplitude in shallow water: tanh(k depth), engine/waves/shoaling.py.
float sea_shoaling(float x) {
    return x >= 10.0 ? 1.0 : 1.0 - 2.0 / (1.0 + exp(2.0 * max(x, 0.0)));
}

// Share of its depth that the sea has for waves: ice takes it away. FREEZE of engine/waves/shoaling.py.
float sea_open(SeaPlace p) {
    return 1.0 - smoothstep(sea_waves.ice_sine, sea_waves.ice_sine + 0.02, abs(p.zenith.z));
}

// One wave at a place. direction: unit, away from the origin; cycles: its phase; weight: of A and of Q by the fade;
// rate: its change per m; spread: by how much the direction turns per m across; sine: of the angle from the origin.
struct SeaWave {
    vec2 direction;
    float cycles, amplitude, sideways, k, weight, rate, spread, sine;
};

SeaWave sea_far_wave(SeaPlace p, Wave at) {
    SeaWave wave;
    vec2 along = at.heading, across = vec2(-along.y, along.x);
    float q1 = dot(p.at, along), q2 = dot(p.at, across);
    float bend = q2 * q2 * (at.half_cotangent_per_m - at.curve_per_m2 * q1);
    wave.cycles = fract(at.phase_cycles + at.cycles_per_m * q1) + at.cycles_per_m * bend;
    wave.direction = along + across * (2.0 * at.half_cotangent_per_m * q2);
    wave.amplitude = at.amplitude_m;
    wave.sideways = at.sideways_m;
    wave.k = at.cycles_per_m * TWO_PI;
    wave.weight = 1.0;
    wave.rate = wave.spread = 0.0;
    float cotangent = 2.0 * at.half_cotangent_per_m * sea_waves.radius_m;
    wave.sine = inversesqrt(1.0 + cotangent * cotangent);
    return wave;
}

SeaWave sea_near_wave(SeaPlace p, Wave at) {
    SeaWave wave;
    vec2 along = at.heading;
    float cos0 = at.origin_cos, sin0 = at.origin_sin, fade = at.fade_to - at.fade_from;
    float q1 = dot(p.q, along), q2 = dot(p.q, vec2(-along.y, along.x));
    float w = sin0 * p.up + cos0 * q1;
    float sine = max(sqrt(w * w + q2 * q2), 1e-12), cosine = cos0 * p.up - sin0 * q1;
    float excess = w > 0.0 ? q2 * q2 / (sine + w) : sine - w;
    float x = sea_waves.radius_m * sea_asin(q1 + cos0 * excess);
    wave.cycles = fract(at.phase_cycles + at.cycles_per_m * x);
    // Away from the origin, in axes carried from the anchor.
    float fold = 1.0 / (1.0 + p.up);
    wave.direction = (sin0 * (along - p.q * (dot(p.q, along) * fold)) + cos0 * p.q) / sine;
    // 1 - |cos| without cancellation.
    float versine = sine * sine / (1.0 + abs(cosine)), t = clamp((versine - at.fade_from) / fade, 0.0, 1.0);
    wave.weight = t * t * (3.0 - 2.0 * t);
    wave.rate = 6.0 * t * (1.0 - t) / fade * sine * (cosine < 0.0 ? -1.0 : 1.0) / sea_waves.radius_m;
    wave.amplitude = at.amplitude_m;
    wave.sideways = at.sideways_m;
    wave.k = at.cycles_per_m * TWO_PI;
    wave.spread = cosine / (sine * sea_waves.radius_m);
    wave.sine = sine;
    return wave;
}

// A wave's part in what the mesh shows: nothing shorter than two of its spacings, all of what is longer than four.
vec3 sea_wave_moved(SeaWave wave, float depth_m, float spacing_m) {
    float share = wave.weight * smoothstep(2.0, 4.0, TWO_PI / (wave.k * spacing_m)) * sea_shoaling(wave.k * depth_m);
    vec2 circle = sea_circle(wave.cycles);
    return share * vec3(wave.direction * (wave.sideways * circle.y), wave.amplitude * circle.x);
}

vec3 sea_moved(SeaPlace p, float depth_m, float spacing_m) {
    vec3 moved = vec3(0.0);
    WaveBin bin = wave_bin(PI / spacing_m);
    for (int i = 0; i < bin.far_count; ++i) {
        moved += sea_wave_moved(sea_far_wave(p, sea_waves_waves(i)), depth_m, spacing_m);
    }
    int first = sea_waves.far_count;
    for (int i = first; i < first + bin.near_count; ++i) {
        moved += sea_wave_moved(sea_near_wave(p, sea_waves_waves(i)), depth_m, spacing_m);
    }
    return moved;
}

// Planet axes of a vector along a place's axes.
vec3 sea_vector(SeaPlace p, vec3 along) {
    return p.east * along.x + p.north * along.y + p.zenith * along.z;
}

// Covariance (ee, nn, en; w: its smaller eigenvalue) in m^2 of what a pixel sees of the calm sea. A flat view sees a
// long way of it, but slopes that stand up to the camera less: the mean sea's tilt counts up to FLATTEST.
const float SEA_FLATTEST = 0.02;
vec4 sea_footprint(SeaPlace p, vec3 view, float distance_m) {
    float across = sea_waves.footprint_px * distance_m * frame.pixel_rad;
    float tilt = max(abs(dot(view, p.zenith)), SEA_FLATTEST);
    vec2 level = vec2(dot(view, p.east), dot(view, p.north));
    float length2 = dot(level, level);
    level *= inversesqrt(max(length2, 1e-12));
    float more = length2 > 1e-12 ? 1.0 / (tilt * tilt) - 1.0 : 0.0;
    return across * across * vec4(vec3(1.0, 1.0, 0.0) + more * vec3(level * level, level.x * level.y), 1.0);
}

// The largest wave number that a pixel of this footprint shows in some direction.
float sea_shortest(vec4 footprint) {
    return PI * inversesqrt(max(footprint.w, 1e-12));
}

// Sums over waves of what `sea_surface` needs.
struct SeaSums {
    vec2 lift;       // slopes of the height
    vec3 squeeze;    // of the sideways movement: ee, nn, en
    vec3 variance;
};

// The share of a wave that pixels show: it goes to 0 where they are half a wavelength wide.
float sea_seen(SeaWave wave, vec4 footprint) {
    float k_cut = wave.k * (1.0 / PI);
    vec3 dd = vec3(wave.direction * wave.direction, wave.direction.x * wave.direction.y);
    float cut = max(1.0 - k_cut * k_cut * dot(footprint.xyz, vec3(dd.xy, 2.0 * dd.z)), 0.0);
    return cut * cut;
}

// Slope variance of a wave that shows this share of its amplitude. shallow: factor of all of it.
vec3 sea_hidden(SeaWave wave, float seen, float shallow) {
    float steep = wave.amplitude * wave.k * wave.weight * shallow;
    return 0.5 * steep * steep * (1.0 - seen * seen)
        * vec3(wave.direction * wave.direction, wave.direction.x * wave.direction.y);
}

void sea_add(inout SeaSums sums, SeaWave wave, vec4 footprint, float depth_m) {
    vec2 d = wave.direction, circle = sea_circle(wave.cycles);
    vec3 dd = vec3(d * d, d.x * d.y);
    float seen = sea_seen(wave, footprint), shallow = sea_shoaling(wave.k * depth_m);
    float share = seen * shallow, whole = share * wave.weight, rate = share * wave.rate;
    sums.lift += d * (wave.amplitude * (whole * wave.k * circle.y + rate * circle.x));
    float squeeze = wave.sideways * (rate * circle.y - whole * wave.k * circle.x);
    float turn = wave.sideways * whole * circle.y * wave.spread;
    sums.squeeze += squeeze * dd + turn * vec3(dd.y, dd.x, -dd.z);
    sums.variance += sea_hidden(wave, seen, shallow);
}

// The cross product of the tangents of the moved sea.
SeaSurface sea_lie(SeaPlace p, SeaSums sums) {
    vec2 t = 1.0 + sums.squeeze.xy, lift = sums.lift;
    float shear = sums.squeeze.z, area = t.x * t.y - shear * shear;
    vec3 normal = vec3(shear * lift.y - lift.x * t.y, shear * lift.x - lift.y * t.x, area);
    return SeaSurface(normalize(sea_vector(p, normal)), sums.variance, area);
}

SeaSurface sea_surface(SeaPlace p, float depth_m, vec4 footprint) {
    WaveBin bin = wave_bin(sea_shortest(footprint));
    SeaSums sums = SeaSums(vec2(0.0), vec3(0.0), bin.slope_variance);
    for (int i = 0; i < bin.far_count; ++i) sea_add(sums, sea_far_wave(p, sea_waves_waves(i)), footprint, depth_m);
    int first = sea_waves.far_count;
    for (int i = first; i < first + bin.near_count; ++i) {
        sea_add(sums, sea_near_wave(p, sea_waves_waves(i)), footprint, depth_m);
    }
    return sea_lie(p, sums);
}
