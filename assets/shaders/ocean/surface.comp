// How the sea lies in each of its pixels: the normal of all waves that a pixel can show, and the variance of the slopes
// of those that it can't. The mesh says where the surface is and how far it was moved sideways.
//
// A lane takes SEA_RUN pixels side by side: each wave is fetched and placed once for all of them, and then is a
// straight wave from pixel to pixel (with its rings' curve, if its origin is near). Where pixels lie in even steps on
// the calm sea, as its waves go, their phases are turned from one to the next, from the first of each SEA_PART pixels
// on. Waves that are long on the whole tile come from the tile's nodes, if SEA_SWELL says that there are any.
//
//   SHADE_EVERY   2 or 4: only pixels that are shaded get what they need, one of each block and others where it shows
//   no sea
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "common/spread.glsl"
#include "common/texel.glsl"
#include "ocean/waves.glsl"
#include "ocean/sea_pixel.glsl"
#include "ocean/swell.glsl"
#include "ocean/shaded.glsl"

layout(local_size_x = SEA_LANES) in;   // 128 / SEA_RUN / SHADE_EVERY
// Work on single pixels is written for a part and called by literal numbers: loops of 16 turns are not unrolled, and
// arrays whose index is not known when compiling lie in slow memory.
#if SEA_RUN > 8
#define SEA_PART 8
#define SEA_PARTS 2
#else
#define SEA_PART SEA_RUN
#define SEA_PARTS 1
#endif
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
#ifdef SEA_SWELL
layout(std430, binding = SWELL_BUFFER) readonly buffer SwellBuffer { SwellTile swell[]; };
#endif
layout(binding = COAST_NORMAL_IMAGE) writeonly uniform image2D u_normal_out;
layout(binding = 1) writeonly uniform image2D u_rough_out;

const float DEEP = 4.0;     // as in swell.comp
const float EVEN = 0.04;    // rad: phases off by less are taken as even steps

SeaPlace g_places[SEA_RUN];
bool g_sea[SEA_RUN];
vec2 g_offset[SEA_RUN];      // of each pixel from the middle of the run, m
vec2 g_lift[SEA_RUN];
vec3 g_squeeze[SEA_RUN];
vec3 g_hidden;
vec4 g_footprint;
vec2 g_depth;              // at the first and the last pixel
vec2 g_start[SEA_PARTS], g_step[SEA_PARTS];   // m: the pixels' offsets as even steps

shared uint s_uneven;
#if SHADE_EVERY > 1
uint g_turns[SEA_RUN];       // of each block, as sea_turns() has them
shared uint s_turns;
#endif

// A wave's slopes in SEA_PART pixels from `base` on.
void add_part(int base, SeaWave wave, float per_m, bool near, bool shallow, bool even, float first, float more, vec2 up,
    vec2 up_sine,
    vec3 side, vec3 side_cosine) {
    vec2 cycles_per_px = wave.direction * per_m;
    if (even) {
        vec2 turned = sea_circle(wave.cycles + dot(cycles_per_px, g_start[base / SEA_PART])),
            turn = sea_circle(dot(cycles_per_px, g_step[base / SEA_PART]));
        for (int k = base; k < base + SEA_PART; ++k) {
            g_lift[k] += turned.y * up;
            g_squeeze[k] += turned.x * side;
            turned = vec2(turned.x * turn.y + turned.y * turn.x, turned.y * turn.y - turned.x * turn.x);
        }
        return;
    }
    float curve = 0.5 * wave.spread * per_m;
    for (int k = base; k < base + SEA_PART; ++k) {
        float cycles = wave.cycles + dot(cycles_per_px, g_offset[k]);
        if (near) {
            float across = wave.direction.x * g_offset[k].y - wave.direction.y * g_offset[k].x;
            cycles += curve * across * across;
        }
        vec2 circle = sea_circle(cycles);
        if (shallow) circle *= first + more * float(k);
        g_lift[k] += circle.y * up;
        g_squeeze[k] += circle.x * side;
        if (near) {
            g_lift[k] += circle.x * up_sine;
            g_squeeze[k] += circle.y * side_cosine;
        }
    }
}

void add_wave(SeaWave wave, float per_m, bool near, bool shallow, bool even) {
    vec2 d = wave.direction;
    vec3 dd = vec3(d * d, d.x * d.y);
    float seen = sea_seen(wave, g_footprint);
    vec2 ends = shallow ? vec2(sea_shoaling(wave.k * g_depth.x), sea_shoaling(wave.k * g_depth.y)) : vec2(1.0);
    float mean = 0.5 * (ends.x + ends.y), more = (ends.y - ends.x) / float(max(SEA_RUN - 1, 1));
    g_hidden += sea_hidden(wave, seen, mean);
    float whole = seen * wave.weight * wave.k, rate = seen * wave.rate;
    vec2 up = d * (wave.amplitude * whole), up_sine = d * (wave.amplitude * rate);
    vec3 side = dd * (-wave.sideways * whole);
    vec3 side_cosine = wave.sideways * (rate * dd + seen * wave.weight * wave.spread * vec3(dd.y, dd.x, -dd.z));
    add_part(0, wave, per_m, near, shallow, even, ends.x, more, up, up_sine, side, side_cosine);
#if SEA_PARTS > 1
    add_part(SEA_PART, wave, per_m, near, shallow, even, ends.x, more, up, up_sine, side, side_cosine);
#endif
}

#ifdef SEA_SWELL
// Lagrange's weights of the four nodes.
vec4 node_weights(float x) {
    const float a = SWELL_NODES.w, b = SWELL_NODES.z, outer = 0.5 / (a * (a * a - b * b)),
        inner = 0.5 / (b * (b * b - a * a));
    float x2 = x * x, from_b = (x2 - b * b) * outer, from_a = (x2 - a * a) * inner;
    return vec4(from_b * (a - x), from_a * (b - x), from_a * (x + b), from_b * (x + a));
}

void add_swell_part(int base, uint index, vec2 from) {
    vec2 axis = swell[index].axis, to_side = swell[index].per_half_side;
    vec4 across[SEA_PART];
    vec4 along[SEA_PART];
    for (int k = 0; k < SEA_PART; ++k) {
        vec2 at = from + g_offset[base + k];
        // What stands out of the rectangle is by a pixel at most.
        vec2 x = clamp(vec2(dot(at, axis), dot(at, vec2(-axis.y, axis.x))) * to_side, -1.2, 1.2);
        across[k] = node_weights(x.x);
        along[k] = node_weights(x.y);
    }
    for (int m = 0; m < 4; ++m) {
        SwellRow row = swell[index].rows[m];
        mat4x2 lift = transpose(mat2x4(row.lift_east, row.lift_north));
        mat4x3 squeeze = transpose(mat3x4(row.squeeze_ee, row.squeeze_nn, row.squeeze_en));
        for (int k = 0; k < SEA_PART; ++k) {
            vec4 w = across[k] * along[k][m];
            g_lift[base + k] += w.x * lift[0] + w.y * lift[1] + w.z * lift[2] + w.w * lift[3];
            g_squeeze[base + k] += w.x * squeeze[0] + w.y * squeeze[1] + w.z * squeeze[2] + w.w * squeeze[3];
        }
    }
}

void add_swell(uint index, vec2 middle) {
    vec2 from = middle - swell[index].centre_m;
    g_hidden += swell[index].hidden;
    add_swell_part(0, index, from);
#if SEA_PARTS > 1
    add_swell_part(SEA_PART, index, from);
#endif
}
#endif

ivec2 pixel_of(ivec2 first, int k, uint turn) {
    return sea_of_block(first + ivec2(k * SEA_APART.x, 0), turn);
}

void store_part(int base, ivec2 first, uint turn) {
    for (int k = base; k < base + SEA_PART; ++k) {
        if (!g_sea[k]) continue;
        ivec2 pixel = pixel_of(first, k, turn);
        SeaSurface lies = sea_lie(g_places[k], SeaSums(g_lift[k], g_squeeze[k], g_hidden));
        imageStore(u_normal_out, pixel, vec4(oct_encode(lies.normal), 0.0, 0.0));
        imageStore(u_rough_out, pixel, vec4(lies.variance, lies.jacobian));
    }
}

// The pixels of a run.
struct SeaRun {
    vec2 middle;        // of their places, as these are
    float count;        // of those of the sea
    float shallowest;   // m
};

// One pixel of each block, from the run's first block on: sets their places, and the footprint and depths of the run.
SeaRun run_of(ivec2 first, uint turn) {
    SeaRun run = SeaRun(vec2(0.0), 0.0, 3.0e38);
    g_footprint = vec4(0.0);
    for (int k = 0; k < SEA_RUN; ++k) {
        ivec2 pixel = pixel_of(first, k, turn);
#if SHADE_EVERY > 1
        g_sea[k] = ((g_turns[k] >> turn) & 1u) != 0u && sea_waves_at(pixel);
#else
        g_sea[k] = sea_waves_at(pixel);
#endif
        vec3 point = g_sea[k] ? sea_point(pixel) : frame.camera_forward;
        g_places[k] = sea_calm_place(pixel, point);
        float distance_m = length(point);
        float depth_m = sea_depth_decode(texel_at(u_attributes, pixel).rg) * sea_open(g_places[k]);
        if (g_sea[k]) {
            run.middle += g_places[k].at;
            g_footprint += sea_footprint(g_places[k], -point / distance_m, distance_m);
            if (run.count == 0.0) g_depth = vec2(depth_m);
            g_depth.y = depth_m;
            run.shallowest = min(run.shallowest, depth_m);
            run.count += 1.0;
        }
    }
    run.middle /= max(run.count, 1.0);
    g_footprint /= max(run.count, 1.0);
    return run;
}

// Offsets from the run's middle, and even steps from the first pixel of the sea to the last. Returns how far pixels lie
// off these at most, squared.
float even_steps(vec2 middle) {
    for (int k = 0; k < SEA_RUN; ++k) {
        g_offset[k] = g_sea[k] ? g_places[k].at - middle : vec2(0.0);
        g_lift[k] = vec2(0.0);
        g_squeeze[k] = vec3(0.0);
    }
    float uneven = 0.0;
    for (int part = 0; part < SEA_PARTS; ++part) {
        int base = part * SEA_PART, from = base, to = base + SEA_PART - 1;
        while (from < base + SEA_PART - 1 && !g_sea[from]) ++from;
        while (to > from && !g_sea[to]) --to;
        g_step[part] = (g_offset[to] - g_offset[from]) / float(max(to - from, 1));
        g_start[part] = g_offset[from] - float(from - base) * g_step[part];
        for (int k = base; k < base + SEA_PART; ++k) {
            vec2 off = g_offset[k] - g_start[part] - float(k - base) * g_step[part];
            if (g_sea[k]) uneven = max(uneven, dot(off, off));
        }
    }
    return uneven;
}

// The largest of a workgroup: all lanes divide the waves alike, for lanes that go separate ways cost the time of both.
float most_uneven(float uneven) {
    if (gl_LocalInvocationID.x == 0u) s_uneven = 0u;
    memoryBarrierShared();
    barrier();
    atomicMax(s_uneven, floatBitsToUint(uneven));
    memoryBarrierShared();
    barrier();
    return uintBitsToFloat(s_uneven);
}

// All waves that the footprint shows. index: of the tile.
void add_waves(uint index, SeaRun run, float uneven) {
    SeaPlace place = sea_place_at(run.middle);
    WaveBin bin = wave_bin(sea_shortest(g_footprint));
    g_hidden = bin.slope_variance;
#ifdef SEA_SWELL
    add_swell(index, run.middle);
    int feels = swell[index].feels, held = swell[index].held;
#else
    int feels = wave_bin(DEEP / max(run.shallowest, 1e-6)).far_count, held = feels;
#endif
    feels = min(feels, bin.far_count);
    for (int i = 0; i < feels; ++i) {
        Wave at = sea_waves_waves(i);
        add_wave(sea_far_wave(place, at), at.cycles_per_m, false, true, false);
    }
    int even = clamp(wave_bin(EVEN * inversesqrt(max(uneven, 1e-12))).far_count, held, max(bin.far_count, held));
    for (int i = held; i < even; ++i) {
        Wave at = sea_waves_waves(i);
        add_wave(sea_far_wave(place, at), at.cycles_per_m, false, false, true);
    }
    for (int i = even; i < bin.far_count; ++i) {
        Wave at = sea_waves_waves(i);
        add_wave(sea_far_wave(place, at), at.cycles_per_m, false, false, false);
    }
    int first_near = sea_waves.far_count, end_near = first_near + bin.near_count;
    for (int i = first_near; i < end_near; ++i) {
        Wave at = sea_waves_waves(i);
        add_wave(sea_near_wave(place, at), at.cycles_per_m, true, true, false);
    }
}

void store_run(uint index, ivec2 first, uint turn) {
    SeaRun run = run_of(first, turn);
    float uneven = most_uneven(even_steps(run.middle));
    if (run.count == 0.0) return;
    add_waves(index, run, uneven);
    store_part(0, first, turn);
#if SEA_PARTS > 1
    store_part(SEA_PART, first, turn);
#endif
}

void main() {
    const int ROW = TILE_WIDTH / SEA_APART.x;
    uint index = spread_group(), tile = tiles[index];
    int lane = int(gl_LocalInvocationID.x) * SEA_RUN;
    ivec2 first = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + SEA_APART * ivec2(lane & (ROW - 1), lane / ROW);
#if SHADE_EVERY > 1
    uint turns = 0u;
    for (int k = 0; k < SEA_RUN; ++k) {
        g_turns[k] = sea_turns(first + ivec2(k * SEA_APART.x, 0));
        turns |= g_turns[k];
    }
    if (gl_LocalInvocationID.x == 0u) s_turns = 0u;
    memoryBarrierShared();
    barrier();
    atomicOr(s_turns, turns);
    memoryBarrierShared();
    barrier();
    // A loop that is left at its end costs a software GPU nothing where it has one turn; an `if` skips nothing there.
    turns = s_turns;
    uint turn = 0u;
    do {
        store_run(index, first, turn);
        turns &= ~(1u << turn);
        turn = uint(findLSB(turns));
        barrier();
    } while (turns != 0u);
#else
    store_run(index, first, 0u);
#endif
}
