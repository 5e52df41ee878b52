// The bed as it is seen through the water: sand with ripples, and patches of stones and weed, whose detail ends at the
// pixel.
#include "common/camera.glsl"
#include "ocean/look/noise.glsl"

vec3 sea_bed(vec3 D, float depth_m, float footprint_m) {
    // From 32 m down to ripples, as long as a pixel shows them.
    float patches = 0.0, grain = 0.0, weight = 1.0;
    int i = 0, k = 9;
    float seen = clamp(2.0 - footprint_m * 4.0 / (NESTED_BASE_M * exp2(float(k))), 0.0, 1.0);
    if (seen > 0.0) do {
        float n = seen * sea_noise(D, k);
        patches += weight * (i < 3 ? n : 0.0);
        grain += (i < 1 ? 0.2 : 0.5) * n;
        weight *= 0.6;
        k -= i == 2 ? 2 : 3;
        seen = clamp(2.0 - footprint_m * 4.0 / (NESTED_BASE_M * exp2(float(k))), 0.0, 1.0);
    } while (++i < 4 && seen > 0.0);
    // Waves keep the sand clean where it is shallow.
    float overgrown = ocean.bed_detail * smoothstep(0.5, 1.6, patches + min(0.12 * depth_m, 0.6) - 0.35)
        * smoothstep(0.4, 2.5, depth_m);
    vec3 sand = ocean.bed_albedo * (1.0 + 0.16 * ocean.bed_detail * clamp(grain, -2.5, 2.5));
    vec3 dark = ocean.bed_albedo * vec3(0.34, 0.42, 0.36) * (1.0 + 0.35 * clamp(grain, -2.0, 2.0));
    return max(mix(sand, dark, 0.85 * overgrown), 0.0);
}
