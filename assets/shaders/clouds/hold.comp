// Clouds of a still picture that has all its rays, while anti-aliasing looks at other places in the pixels: what was
// gathered, from the pixel itself or, along an outline, from the one beside it that was seen up to the same surface.
#include "generated/bindings.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 3) uniform sampler2D u_history;
layout(binding = 4) uniform sampler2D u_history_depth;   // up to which that was seen
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;

const float SAME_SURFACE = 0.7;   // least ratio of distances, as in resolve.comp

// Depth is near / distance: its ratio is that of the distances. 1: the same, or both are the sky; 0: one is.
float likeness(float a, float b) {
    return a == b ? 1.0 : min(a, b) / max(a, b);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), most = imageSize(o_clouds) - 1;
    if (any(greaterThan(pixel, most))) return;
    float depth = texelFetch(u_depth, pixel, 0).r, best = likeness(texelFetch(u_history_depth, pixel, 0).r, depth);
    best = best >= SAME_SURFACE ? 1.0 : best;
    ivec2 from = pixel;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = clamp(pixel + (i < 2 ? ivec2(0, 2 * i - 1) : ivec2(2 * i - 5, 0)), ivec2(0), most);
        float found = likeness(texelFetch(u_history_depth, at, 0).r, depth);
        from = found > best ? at : from;
        best = max(found, best);
    }
    imageStore(o_clouds, pixel, texelFetch(u_history, from, 0));
}
