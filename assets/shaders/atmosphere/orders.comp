// Sums of moments and irradiance in the form that look-ups read (moments.glsl, irradiance.glsl): of one order, for the
// next one, and of all, for the picture. The mean of an order, by itself, says how to go on
// (systems/atmosphere/closing.py).
#include "common/constants.glsl"
#include "atmosphere/moments.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(rgba32f, binding = 0) readonly uniform image2DArray u_sums;
layout(rgba32f, binding = 1) writeonly uniform image2DArray u_table;
layout(rgba32f, binding = 2) writeonly uniform image2D u_mean;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(u_sums).xy;
    if (any(greaterThanEqual(texel, size))) return;
    float mu_s = air_sun_of_row(float(texel.x) / float(size.x - 1));
    // The zenith's own column is taken a little aside: its higher moments are 0 / 0.
    float sine_s = max(sin_from_cos(mu_s), 0.02);
    vec3 mean = vec3(0.0);
    for (int m = 0; m <= AIR_DEGREE; ++m) {
        for (int l = m; l <= AIR_DEGREE; ++l) {
            ivec3 at = ivec3(texel, AIR_IRRADIANCE_LAYERS + l * (l + 1) / 2 + m);
            float factorials = 1.0;
            for (int i = l - m + 1; i <= l + m; ++i) factorials *= float(i);
            float norm = float(2 * l + 1) / (4.0 * PI) * (m == 0 ? 1.0 : 2.0) / factorials / pow(sine_s, float(m));
            vec3 sum = imageLoad(u_sums, at).rgb * norm;
            if (l == 0) {
                mean = max(sum, 0.0);
                imageStore(u_mean, texel, vec4(mean, 0.0));
                imageStore(u_table, at, vec4(air_pack(mean), 0.0));
            } else {
                imageStore(u_table, at, vec4(sum / max(mean, 1e-30), 0.0));
            }
        }
    }
    // Shares of what faces up and the three walls get together: bounded, also where no sky is above (irradiance.glsl).
    vec3 total = vec3(0.0), part[AIR_IRRADIANCE_LAYERS];
    for (int i = 0; i < AIR_IRRADIANCE_LAYERS; ++i) {
        part[i] = max(imageLoad(u_sums, ivec3(texel, i)).rgb, 0.0);
        total += part[i];
    }
    imageStore(u_table, ivec3(texel, 0), vec4(air_pack(total), 0.0));
    for (int i = 1; i < AIR_IRRADIANCE_LAYERS; ++i)
        imageStore(u_table, ivec3(texel, i), vec4(part[i - 1] / max(total, 1e-30), 0.0));
}
