// Clouds for every pixel from one ray for each block of them: pixels that had their ray in this frame mix it in, the
// others show what the last frame showed at the same place of the clouds, held within what this frame sees around them; where there
// is no past, this frame's rays are spread. Those that ended where the pixel's own surface is count more: clouds in front of
// one thing are not those behind another; and what the last frame saw up to another surface is no past.
#include "common/camera.glsl"

layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_distance;
layout(binding = 3) uniform sampler2D u_before;      // last frame's result, linear
layout(binding = 4) uniform sampler2D u_surface;     // depth up to which that was seen
layout(location = 0) uniform ivec2 u_place;          // of this frame's rays in their blocks
layout(location = 1) uniform int u_past;             // 0: none; 1: the camera moves; 2: it stands still
layout(location = 2) uniform mat3 u_turn;            // camera coordinates to those of the frame before
layout(location = 5) uniform vec3 u_shift;           // m
layout(location = 6) uniform vec4 u_projection;      // of the frame before: 1 / sx, 1 / sy, ox, oy
layout(location = 7) uniform float u_weight;         // of this frame's ray where there is a past
layout(location = 0) out vec4 o_clouds;
layout(location = 1) out float o_surface;

const float ALIKE = 0.7;   // ratio of distances to one surface from frame to frame, and across a pixel's step

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), size = textureSize(u_depth, 0), most = textureSize(u_clouds, 0) - 1;
    ivec2 own = pixel / STRIDE;
    bool fresh = u_place.x >= 0 && own * STRIDE + u_place == pixel;
    vec2 at = vec2(pixel - max(u_place, 0)) / float(STRIDE);
    ivec2 corner = ivec2(floor(at));
    vec2 share = at - vec2(corner);
    float depth = texelFetch(u_depth, pixel, 0).r, weights = 0.0, distance_m = 0.0;
    vec4 sum = vec4(0.0), least = vec4(1e30), largest = vec4(-1e30);
    float far = depth, near_by = depth;
    for (int i = 0; i < 4; ++i) {
        ivec2 side = ivec2(i & 1, i >> 1);
        ivec2 from = clamp(corner + side, ivec2(0), most);
        vec2 near = mix(1.0 - share, share, vec2(side));
        float other = texelFetch(u_depth, min(from * STRIDE + max(u_place, 0), size - 1), 0).r;
        far = min(far, other);
        near_by = max(near_by, other);
        // Depth is near / distance: its ratio is that of the distances.
        float unlike = abs(depth - other) / max(max(depth, other), 1e-20);
        float weight = (near.x * near.y + 1e-3) / (1e-3 + (max(depth, other) > 0.0 ? unlike * unlike : 0.0));
        vec4 found = texelFetch(u_clouds, from, 0);
        sum += weight * found;
        distance_m += weight * min(texelFetch(u_distance, from, 0).r, 1e8);
        weights += weight;
        least = min(least, found);
        largest = max(largest, found);
    }
    vec4 spread = sum / weights;
    distance_m /= weights;
    // Where it was in the last frame; as in common/camera.glsl, x to the right, y up, z forward.
    vec3 ray = normalize(view_ray(ndc_of_pixel(vec2(pixel) + 0.5)));
    vec3 here = distance_m * vec3(dot(ray, frame.camera_right.xyz), dot(ray, frame.camera_up.xyz), dot(ray, frame.camera_forward.xyz));
    vec3 then = u_turn * here + u_shift;
    vec2 ndc = (then.xy / max(then.z, 1e-6) - u_projection.zw) * u_projection.xy;
    vec2 uv = u_past == 2 ? (vec2(pixel) + 0.5) / vec2(size) : 0.5 + 0.5 * ndc;
    bool known = u_past == 2 || (u_past == 1 && then.z > 0.0 && all(lessThan(abs(ndc), vec2(1.0))));
    // Where another surface was, what was seen up to it says nothing. A moving camera finds outlines a little aside.
    float then_depth = texelFetch(u_surface, clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1), 0).r;
    vec2 alike = u_past == 2 ? vec2(depth) : vec2(far, near_by);
    known = known && then_depth >= ALIKE * alike.x && ALIKE * then_depth <= alike.y;
    vec4 past = textureLod(u_before, uv, 0.0);
    vec4 slack = 0.25 * (largest - least);
    vec4 held = u_past == 2 ? past : clamp(past, least - slack, largest + slack);
#ifdef VALIDITY
    // For the debug view: red without a past, green with one, towards yellow as far as it had to be held back; paler where this
    // frame's ray is.
    vec4 apart = abs(past - held) / max(largest - least + 1e-6, vec4(1e-6));
    float kept = clamp(max(max(apart.r, apart.g), max(apart.b, apart.a)), 0.0, 1.0);
    vec3 shade = known ? mix(vec3(0.10, 0.55, 0.20), vec3(0.95, 0.80, 0.10), kept) : vec3(0.80, 0.12, 0.10);
    o_clouds = vec4(fresh ? mix(shade, vec3(1.0), 0.35) : shade, 1.0);
    return;
#endif
    vec4 now = texelFetch(u_clouds, own, 0);
    // Light may be less than none: what the air in shadow doesn't scatter is taken off.
    o_clouds = known ? fresh ? mix(held, now, u_weight) : held : fresh ? now : spread;
    o_clouds.a = max(o_clouds.a, 0.0);
    o_surface = depth;
}
