// After an order is gathered: its moments in the form that look-ups read (for the next order), added to the total of all orders
// (for the picture), and cleared. The last order stands for the geometric series of those that follow it.
#include "atmosphere/moments.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(rgba32f, binding = 0) uniform image2DArray u_sums;
layout(rgba32f, binding = 1) uniform image2DArray u_total_sums;
layout(rgba32f, binding = 2) writeonly uniform image2DArray u_order_table;
layout(rgba32f, binding = 3) writeonly uniform image2DArray u_total_table;
layout(location = 0) uniform ivec2 u_flags;   // 1: the first order; 1: the last one

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(u_sums).xy;
    if (any(greaterThanEqual(texel, size))) return;
    float mu_s = air_sun_of_row(float(texel.x) / float(size.x - 1));
    // The zenith's own column is taken a little aside: its higher moments are 0 / 0.
    float sine_s = max(sin_from_cos(mu_s), 0.02);
    vec3 mean = imageLoad(u_sums, ivec3(texel, AIR_IRRADIANCE_LAYERS)).rgb, last = air_unpack(texelFetch(u_air_moments, ivec3(texel, AIR_IRRADIANCE_LAYERS), 0).rgb);
    vec3 ratio = clamp(mean / (4.0 * PF_PI) / max(last, 1e-30), 0.0, 0.97);
    vec3 tail = u_flags.y == 1 && u_flags.x == 0 ? ratio / (1.0 - ratio) : vec3(0.0);
    vec3 total_mean = vec3(0.0);
    for (int m = 0; m <= AIR_DEGREE; ++m) {
        for (int l = m; l <= AIR_DEGREE; ++l) {
            int layer = AIR_IRRADIANCE_LAYERS + l * (l + 1) / 2 + m;
            ivec3 at = ivec3(texel, layer);
            float factorials = 1.0;
            for (int i = l - m + 1; i <= l + m; ++i) factorials *= float(i);
            float norm = float(2 * l + 1) / (4.0 * PF_PI) * (m == 0 ? 1.0 : 2.0) / factorials / pow(sine_s, float(m));
            vec3 sum = imageLoad(u_sums, at).rgb;
            vec3 total = (u_flags.x == 1 ? vec3(0.0) : imageLoad(u_total_sums, at).rgb) + sum * (1.0 + tail);
            imageStore(u_total_sums, at, vec4(total, 0.0));
            imageStore(u_sums, at, vec4(0.0));
            sum *= norm;
            total *= norm;
            if (l == 0) {
                mean = sum;
                total_mean = total;
                imageStore(u_order_table, at, vec4(air_pack(sum), 0.0));
                imageStore(u_total_table, at, vec4(air_pack(total), 0.0));
            } else {
                imageStore(u_order_table, at, vec4(sum / max(mean, 1e-30), 0.0));
                imageStore(u_total_table, at, vec4(total / max(total_mean, 1e-30), 0.0));
            }
        }
    }
    // Shares of what faces up and the three walls get together: bounded, also where no sky is above (irradiance.glsl).
    vec3 order_all = vec3(0.0), total_all = vec3(0.0), order_part[AIR_IRRADIANCE_LAYERS], total_part[AIR_IRRADIANCE_LAYERS];
    for (int i = 0; i < AIR_IRRADIANCE_LAYERS; ++i) {
        ivec3 at = ivec3(texel, i);
        vec3 sum = imageLoad(u_sums, at).rgb;
        vec3 total = (u_flags.x == 1 ? vec3(0.0) : imageLoad(u_total_sums, at).rgb) + sum * (1.0 + tail);
        imageStore(u_total_sums, at, vec4(total, 0.0));
        imageStore(u_sums, at, vec4(0.0));
        order_part[i] = sum;
        total_part[i] = total;
        order_all += sum;
        total_all += total;
    }
    imageStore(u_order_table, ivec3(texel, 0), vec4(air_pack(order_all), 0.0));
    imageStore(u_total_table, ivec3(texel, 0), vec4(air_pack(total_all), 0.0));
    for (int i = 1; i < AIR_IRRADIANCE_LAYERS; ++i) {
        imageStore(u_order_table, ivec3(texel, i), vec4(order_part[i - 1] / max(order_all, 1e-30), 0.0));
        imageStore(u_total_table, ivec3(texel, i), vec4(total_part[i - 1] / max(total_all, 1e-30), 0.0));
    }
}
