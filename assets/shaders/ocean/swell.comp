// The long waves of each tile, see swell.glsl. A lane a tile.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "common/spread.glsl"
#include "common/texel.glsl"
#include "ocean/waves.glsl"
#include "ocean/sea_pixel.glsl"
#include "ocean/swell.glsl"

layout(local_size_x = 8) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
layout(std430, binding = SWELL_BUFFER) writeonly buffer SwellBuffer { SwellTile swell[]; };

const float LONGEST_PHASE = 0.9;   // k h at which a wave is long: errors of 0.3 %
const float DEEP = 4.0;            // k times the depth from which a wave doesn't feel the bed: 1 - tanh is 7e-4

// Every second pixel each way, so the rectangle is a little larger than what they span.
const float MARGIN = 1.15;

vec2 turned(vec2 circle, vec2 by) {
    return vec2(circle.x * by.y + circle.y * by.x, circle.y * by.y - circle.x * by.x);
}

// A tile's rectangle of the sea, along axes that keep it small: across and along the view.
struct SwellRectangle {
    vec2 centre, axis, size;   // size: half of each side, metres
    vec4 footprint;            // of one of its pixels
    float shallowest;          // m
    bool any_sea;
};

SwellRectangle rectangle_of(ivec2 first) {
    vec3 ray = view_ray(ndc_of_pixel(vec2(first) + vec2(8.0, 4.0)));
    vec2 ahead = vec2(dot(ray, sea_waves.east), dot(ray, sea_waves.north));
    float ahead2 = dot(ahead, ahead), shallowest = 3.0e38;
    vec2 axis = ahead2 > 1e-6 * dot(ray, ray) ? vec2(ahead.y, -ahead.x) * inversesqrt(ahead2) : vec2(1.0, 0.0);
    vec2 low = vec2(3.0e38), high = vec2(-3.0e38);
    vec4 footprint = vec4(0.0);
    for (int k = 0; k < 32; ++k) {
        ivec2 pixel = first + ivec2(k & 7, k >> 3) * 2 + ((k >> 3) & 1);
        bool sea = sea_waves_at(pixel);
        vec3 point = sea ? sea_point(pixel) : vec3(0.0, 0.0, 1.0);
        SeaPlace place = sea_calm_place(pixel, point);
        vec2 at = vec2(dot(place.at, axis), dot(place.at, vec2(-axis.y, axis.x)));
        low = sea ? min(low, at) : low;
        high = sea ? max(high, at) : high;
        float depth_m = sea_depth_decode(texel_at(u_attributes, pixel).rg) * sea_open(place);
        shallowest = sea ? min(shallowest, depth_m) : shallowest;
        float distance_m = length(point);
        if (sea) footprint = sea_footprint(place, -point / distance_m, distance_m);
    }
    vec2 middle = 0.5 * (low + high), size = max(0.5 * MARGIN * (high - low), 1e-3);
    vec2 centre = middle.x * axis + middle.y * vec2(-axis.y, axis.x);
    return SwellRectangle(centre, axis, size, footprint, shallowest, low.x <= high.x);
}

// At each of the rectangle's 4 x 4 nodes.
struct SwellSums {
    vec2 lift[16];
    vec3 squeeze[16];
    vec3 hidden;   // variance of slopes: of the whole rectangle
};

void add_wave(inout SwellSums sums, SwellRectangle r, SeaWave wave, float cycles_per_m) {
    vec2 d = wave.direction, axis = r.axis;
    vec2 cycles = cycles_per_m * r.size * vec2(dot(d, axis), dot(d, vec2(-axis.y, axis.x)));
    float seen = sea_seen(wave, r.footprint);
    sums.hidden += sea_hidden(wave, seen, 1.0);
    vec2 up = d * (wave.amplitude * wave.k * seen);
    vec3 side = vec3(d * d, d.x * d.y) * (-wave.sideways * wave.k * seen);
    vec2 along[4];
    for (int n = 0; n < 4; ++n) along[n] = sea_circle(wave.cycles + cycles.x * SWELL_NODES[n]);
    for (int m = 0; m < 4; ++m) {
        vec2 by = sea_circle(cycles.y * SWELL_NODES[m]);
        for (int n = 0; n < 4; ++n) {
            vec2 circle = turned(along[n], by);
            sums.lift[4 * m + n] += circle.y * up;
            sums.squeeze[4 * m + n] += circle.x * side;
        }
    }
}

void store_nodes(uint index, SwellSums sums) {
    for (int n = 0; n < 16; n += 4) {
        vec2 l0 = sums.lift[n], l1 = sums.lift[n + 1], l2 = sums.lift[n + 2], l3 = sums.lift[n + 3];
        vec3 s0 = sums.squeeze[n], s1 = sums.squeeze[n + 1], s2 = sums.squeeze[n + 2], s3 = sums.squeeze[n + 3];
        swell[index].rows[n / 4] = SwellRow(vec4(l0.x, l1.x, l2.x, l3.x), vec4(l0.y, l1.y, l2.y, l3.y),
            vec4(s0.x, s1.x, s2.x, s3.x), vec4(s0.y, s1.y, s2.y, s3.y), vec4(s0.z, s1.z, s2.z, s3.z));
    }
}

void main() {
    uint index = spread_group() * 8u + gl_LocalInvocationID.x;
    if (index >= tile_groups[0]) return;
    SwellRectangle r = rectangle_of(ivec2(tiles[index] & 0xffffu, tiles[index] >> 16) * TILE_PX);
    // Whole bins of waves, so that all that are counted in are long enough.
    float longest = LONGEST_PHASE / max(r.size.x, r.size.y);
    int feels = r.any_sea ? wave_bin(DEEP / max(r.shallowest, 1e-6)).far_count : 0;
    int held = r.any_sea ? max(wave_bin(longest * 0.84).far_count, feels) : 0;
    SeaPlace place = sea_place_at(r.centre);
    SwellSums sums;
    sums.hidden = vec3(0.0);
    for (int n = 0; n < 16; ++n) {
        sums.lift[n] = vec2(0.0);
        sums.squeeze[n] = vec3(0.0);
    }
    for (int i = feels; i < held; ++i) {
        Wave wave = sea_waves_waves(i);
        add_wave(sums, r, sea_far_wave(place, wave), wave.cycles_per_m);
    }
    swell[index].centre_m = r.centre;
    swell[index].axis = r.axis;
    swell[index].per_half_side = 1.0 / r.size;
    swell[index].feels = feels;
    swell[index].held = held;
    swell[index].hidden = sums.hidden;
    store_nodes(index, sums);
}
