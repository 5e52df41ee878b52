// Clouds over the picture: drawn with "premultiplied" blending, alpha is what they take. Each pixel takes from the four rays
// around it, more from those that ended where its own surface is: clouds in front of one thing are not those behind another.
#include "common/camera.glsl"

layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_distance;
layout(location = 0) uniform ivec2 u_place;
layout(location = 0) out vec4 o_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 at = (vec2(pixel - u_place)) / float(STRIDE);
    ivec2 corner = ivec2(floor(at)), most = textureSize(u_clouds, 0) - 1;
    vec2 share = at - vec2(corner);
    float depth = texelFetch(u_depth, pixel, 0).r;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 side = ivec2(i & 1, i >> 1);
        ivec2 from = clamp(corner + side, ivec2(0), most);
        vec2 near = mix(1.0 - share, share, vec2(side));
        float other = texelFetch(u_depth, min(from * STRIDE + u_place, textureSize(u_depth, 0) - 1), 0).r;
        // Depth is near / distance: its ratio is that of the distances.
        float unlike = abs(depth - other) / max(max(depth, other), 1e-20);
        float weight = (near.x * near.y + 1e-3) / (1e-3 + (max(depth, other) > 0.0 ? unlike * unlike : 0.0));
        sum += weight * texelFetch(u_clouds, from, 0);
        weights += weight;
    }
    vec4 found = sum / weights;
    o_color = vec4(found.rgb, 1.0 - found.a);
}
