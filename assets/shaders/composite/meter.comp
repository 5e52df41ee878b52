// Exposure by histogram, in one dispatch: all groups count, the last one to finish reads the result.
// Deterministic: counts are integers, so the order of the groups doesn't matter.
#include "generated/frame.glsl"
#include "common/color.glsl"
#include "composite/exposure.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 0) uniform sampler2D u_scene;  // radiance, a quarter of the view's size

const int BINS = 512, LANES = 256;
const float LOWEST = -20.0;     // log2 cd m^-2 of the first bin
const float PER_STOP = 10.0;    // bins a stop: up to 2^31
// Exposed light of the 99th percentile, of the median (which is lifted to it, by so much at most), and the most that
// the median may have in a picture without anything white and in one of snow or cloud alone; highlights over white
// ground under this sun in either.
const float HIGHLIGHT = 1.1, GREY = 0.18, MOST_LIFT_EV = 1.0, MOST_CLOSED_EV = 1.0;
const vec2 MEDIANS = vec2(0.25, 0.85), WHITE_SHARES = vec2(0.1, 0.6);
const float LIT_STOPS = 10.0, SUNLIT_STOPS = 5.0, SUNLIT_SHARE = 0.001, LOWEST_SINE = 0.01;
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

int bin_of(float luminance) {
    return luminance > 0.0 ? clamp(int((log2(luminance) - LOWEST) * PER_STOP), 0, BINS - 1) : -1;
}

float middle_of(int bin) {
    return LOWEST + (float(bin) + 0.5) / PER_STOP;
}

// How bright the picture of a scene should be, by its brightness: night looks dark (Krawczyk et al. 2005, eq. 11),
// 1 in sunlight.
float key_of(float luminance) {
    float key = 1.03 - 2.0 / (2.0 + log2(luminance + 1.0) * 0.30103);
    return clamp(key / 0.68, 0.02, 1.0);
}

float count_of(int first, int last) {
    uint count = 0u;
    for (int k = first; k <= last; k++) count += s_counts[k];
    return float(count);
}

// log2 of the luminance that a share of what lies in these bins stays below, straight within a bin.
float percentile(int first, int last, float share) {
    float wanted = share * count_of(first, last), seen = 0.0;
    for (int k = first; k <= last; k++) {
        float count = float(s_counts[k]);
        if (seen + count >= wanted && count > 0.0)
            return LOWEST + (float(k) + clamp((wanted - seen) / count, 0.0, 1.0)) / PER_STOP;
        seen += count;
    }
    return middle_of(last);
}

// The bin of the brightest thousandth of the picture at or below `most`: no single star. -1: nothing is there.
int peak_below(int most, float area) {
    uint above = 0u;
    int top = -1;
    for (int k = most; k >= 0; k--) {
        above += s_counts[k];
        if (top < 0 && above > 0u) top = k;
        if (float(above) > 0.001 * area) return k;
    }
    return top;
}

// Twin: systems/composite/metering.py.
void expose() {
    float area = float(textureSize(u_scene, 0).x * textureSize(u_scene, 0).y);
    float mean = 0.0;
    for (int k = 0; k < BINS; k++) mean += float(s_counts[k]) * exp2(middle_of(k));
    // Nothing that the sun lights is brighter than white facing it: what is, is the sun or a glint.
    float facing = luminance_of_radiance(frame.sun_irradiance) * (1.0 / 3.14159265);
    int most = facing > 0.0 ? bin_of(facing) : BINS - 1;
    int peak = peak_below(most, area);
    if (peak < 0) peak = peak_below(BINS - 1, area);
    float target = u_ev100.x;  // nothing but black: open wide
    float metered = LOWEST;
    if (peak >= 0) {
        // What is lit: ten stops down. Black space around a bright planet says nothing. Of it what the same light may
        // have lit: five stops down.
        most = max(most, peak);
        float bright = percentile(max(peak - int(LIT_STOPS * PER_STOP), 0), most, 0.99);
        metered = percentile(max(int((bright - SUNLIT_STOPS - LOWEST) * PER_STOP), 0), most, 0.5);
        float key = log2(SATURATION * mix(1.0, key_of(exp2(bright)), u_dark_adaptation));
        // Highlights are white; darker scenes are lifted, and only a scene that has white in it may be all bright.
        target = bright - key - log2(HIGHLIGHT);
        target -= clamp(target - (metered - key - log2(GREY)), 0.0, MOST_LIFT_EV);
        float white = facing * max(dot(frame.camera_zenith, frame.sun_direction), LOWEST_SINE);
        float whiteness = smoothstep(WHITE_SHARES.x, WHITE_SHARES.y, exp2(bright) / max(white, 1e-30));
        target = max(target, metered - key - log2(mix(MEDIANS.x, MEDIANS.y, whiteness)));
        // A sun in the picture closes the aperture, by as much as it takes where nothing else is lit by it.
        float closed = exp2(bright) > SUNLIT_SHARE * facing ? MOST_CLOSED_EV : 100.0;
        target += clamp(log2(mean / area) - log2(4.0 * SATURATION) - target, 0.0, closed);
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
    int lane = int(gl_LocalInvocationIndex);
    for (int k = lane; k < BINS; k += LANES) s_counts[k] = 0u;
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(u_scene, 0);
    if (all(lessThan(pixel, size))) {
        int bin = bin_of(luminance_of_radiance(texelFetch(u_scene, pixel, 0).rgb));
        if (bin >= 0) atomicAdd(s_counts[bin], 1u);
    }
    barrier();
    for (int k = lane; k < BINS; k += LANES) {
        if (s_counts[k] > 0u) atomicAdd(h_counts[k], s_counts[k]);
    }
    memoryBarrierBuffer();
    barrier();
    if (lane == 0) {
        uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
        s_last = atomicAdd(h_groups, 1u) == groups - 1u;
    }
    barrier();
    if (!s_last) return;
    memoryBarrierBuffer();
    // Read and clear for the next frame in one.
    for (int k = lane; k < BINS; k += LANES) s_counts[k] = atomicExchange(h_counts[k], 0u);
    if (lane == 0) h_groups = 0u;
    barrier();
    if (lane == 0) expose();
}
