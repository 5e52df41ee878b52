// Exposure by histogram, in one dispatch: all groups count, the last one to finish reads the result.
// Deterministic: counts are integers, so the order of the groups doesn't matter.
#include "generated/frame.glsl"
#include "common/color.glsl"
#include "composite/exposure.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 0) uniform sampler2D u_scene;  // radiance, a quarter of the view's size

const int BINS = 256;
const float LOWEST = -20.0;     // log2 cd m^-2 of the first bin
const float PER_STOP = 5.0;     // bins a stop: up to 2^31
layout(std430, binding = 5) buffer Histogram {
    uint h_groups;              // how many groups have finished
    uint h_counts[BINS];
};
layout(std430, binding = 6) writeonly buffer ExposureOut { Exposure e_now; };
layout(std430, binding = 7) readonly buffer ExposureIn { Exposure e_before; };

layout(location = 0) uniform vec2 u_ev100;           // the lowest and the highest
// share of the way to go this frame
layout(location = 1) uniform float u_go_brighter;
layout(location = 4) uniform float u_go_darker;
layout(location = 5) uniform int u_has_history;            // 0: at once where it wants to go
layout(location = 2) uniform float u_compensation_ev;
layout(location = 3) uniform float u_dark_adaptation;  // its strength

shared uint s_counts[BINS];
shared bool s_last;

// Of the middle: 16, falling to 4 at the corners.
uint weight_of(vec2 uv) {
    vec2 from_center = (uv - 0.5) * 2.0;
    return 4u + uint(12.0 * exp(-1.5 * dot(from_center, from_center)) + 0.5);
}

int bin_of(float luminance) {
    return luminance > 0.0 ? clamp(int((log2(luminance) - LOWEST) * PER_STOP), 0, BINS - 1) : -1;
}

float middle_of(int bin) {
    return LOWEST + (float(bin) + 0.5) / PER_STOP;
}

// How bright the picture of a scene should be, by its brightness: night looks dark (Krawczyk et al. 2005, eq. 11),
// as a factor to middle grey, 1 in sunlight.
float key_of(float luminance) {
    float key = 1.03 - 2.0 / (2.0 + log2(luminance + 1.0) * 0.30103);
    return clamp(key / 0.68, 0.02, 1.0);
}

void expose() {
    // What is lit: ten stops down from nearly the brightest. Black space around a bright planet says nothing, and
    // neither do the very brightest pixels.
    float area = 9.2 * float(textureSize(u_scene, 0).x * textureSize(u_scene, 0).y);  // 9.2: mean of weight_of
    uint above = 0u;
    int peak = -1, top = -1;
    float mean = 0.0;
    for (int k = BINS - 1; k >= 0; k--) {
        uint count = s_counts[k];
        above += count;
        mean += float(count) * exp2(middle_of(k));
        if (top < 0 && count > 0u) top = k;
        // A thousandth of the picture: neither single stars nor the sun's disc.
        if (peak < 0 && float(above) > 0.001 * area) peak = k;
    }
    if (peak < 0) peak = top;
    float target = u_ev100.x;  // nothing but black: open wide
    float metered = LOWEST;
    if (peak >= 0) {
        int darkest = max(peak - int(10.0 * PER_STOP), 0);
        uint lit = 0u;
        for (int k = darkest; k <= peak; k++) lit += s_counts[k];
        // Mean of the logarithm between the 10th and the 95th percentile, and the luminance of the 97th.
        float low = 0.10 * float(lit), high = 0.95 * float(lit), seen = 0.0, sum = 0.0, share = 0.0;
        float bright = middle_of(peak);
        bool found = false;
        for (int k = darkest; k <= peak; k++) {
            float count = float(s_counts[k]);
            float part = max(min(seen + count, high) - max(seen, low), 0.0);
            sum += part * middle_of(k);
            share += part;
            seen += count;
            if (!found && seen >= 0.97 * float(lit)) {
                bright = middle_of(k);
                found = true;
            }
        }
        metered = share > 0.0 ? sum / share : bright;
        float key = mix(1.0, key_of(exp2(metered)), u_dark_adaptation);
        target = metered - log2(0.18 * key * SATURATION);
        target = max(target, bright - log2(1.6 * SATURATION));           // highlights may go a little over, not far
        target = max(target, log2(mean / area) - log2(4.0 * SATURATION));  // a sun in the picture closes the aperture
        target -= u_compensation_ev;
    }
    target = clamp(target, u_ev100.x, u_ev100.y);
    float ev = target;
    if (u_has_history != 0) {
        ev = mix(e_before.ev100, target, target < e_before.ev100 ? u_go_brighter : u_go_darker);
    }
    // Arrived: rounding stops it a hair short, and a settled picture would hang on where it came from.
    if (abs(target - ev) < 1e-5) ev = target;
    e_now = Exposure(ev, target, metered, SATURATION * exp2(ev));
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    s_counts[lane] = 0u;
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(u_scene, 0);
    if (all(lessThan(pixel, size))) {
        int bin = bin_of(luminance_of_radiance(texelFetch(u_scene, pixel, 0).rgb));
        if (bin >= 0) atomicAdd(s_counts[bin], weight_of((vec2(pixel) + 0.5) / vec2(size)));
    }
    barrier();
    if (s_counts[lane] > 0u) atomicAdd(h_counts[lane], s_counts[lane]);
    memoryBarrierBuffer();
    barrier();
    if (lane == 0u) {
        uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
        s_last = atomicAdd(h_groups, 1u) == groups - 1u;
    }
    barrier();
    if (!s_last) return;
    memoryBarrierBuffer();
    // Read and clear for the next frame in one.
    s_counts[lane] = atomicExchange(h_counts[lane], 0u);
    if (lane == 0u) h_groups = 0u;
    barrier();
    if (lane == 0u) expose();
}
