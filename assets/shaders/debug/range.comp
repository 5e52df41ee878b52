// Smallest and largest finite value of a texture (MEASURE: as they are, log2 of luminance, log2 of distance from
// depth), on a grid of at most 256 x 256 places, in one work group.
#include "debug/source.glsl"
#include "common/camera.glsl"
#include "common/color.glsl"

#define MEASURE_VALUES 0
#define MEASURE_LUMINANCE 1
#define MEASURE_DEPTH 2

layout(local_size_x = 256) in;
layout(std430, binding = 5) writeonly buffer RangeOut { vec2 r_range; };
shared vec2 s_range[256];

const float HUGE_VALUE = 3.0e38;

vec2 joined(vec2 range, float value) {
    return !isnan(value) && abs(value) < HUGE_VALUE ? vec2(min(range.x, value), max(range.y, value)) : range;
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    vec2 range = vec2(HUGE_VALUE, -HUGE_VALUE);
    for (int row = 0; row < 256; row++) {
        vec4 value = source_at((vec2(float(lane), float(row)) + 0.5) / 256.0);
#if MEASURE == MEASURE_LUMINANCE
        float bright = luminance_of_radiance(value.rgb);
        if (bright > 0.0) range = joined(range, log2(bright));
#elif MEASURE == MEASURE_DEPTH
        if (value.r > 0.0) range = joined(range, log2(forward_distance(value.r)));
#else
        for (int k = 0; k < COMPONENTS; k++) range = joined(range, value[k]);
#endif
    }
    s_range[lane] = range;
    barrier();
    for (uint stride = 128u; stride > 0u; stride >>= 1u) {
        if (lane < stride) {
            vec2 other = s_range[lane + stride];
            s_range[lane] = vec2(min(s_range[lane].x, other.x), max(s_range[lane].y, other.y));
        }
        barrier();
    }
    if (lane == 0u) r_range = s_range[0].x > s_range[0].y ? vec2(0.0, 1.0) : s_range[0];
}
