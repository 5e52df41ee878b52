// Adds an order's sums to those of all, by the weights that make a few orders stand for all
// (systems/atmosphere/closing.py).
#include "atmosphere/moments.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(rgba32f, binding = 0) readonly uniform image2DArray u_sums;
layout(rgba32f, binding = 1) uniform image2DArray u_total;
layout(rgba32f, binding = 2) readonly uniform image2D u_weights;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(u_sums).xy;
    if (any(greaterThanEqual(texel, size))) return;
    vec3 weight = imageLoad(u_weights, texel).rgb;
    for (int i = 0; i < AIR_MOMENTS + AIR_IRRADIANCE_LAYERS; ++i) {
        ivec3 at = ivec3(texel, i);
        imageStore(u_total, at, vec4(imageLoad(u_total, at).rgb + weight * imageLoad(u_sums, at).rgb, 0.0));
    }
}
