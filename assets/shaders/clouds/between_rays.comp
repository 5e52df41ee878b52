// Rays of the blocks between those that were followed on a chessboard's squares (view_ray.glsl): the mean of the four around, in
// which those count that ended on what the block's own pixel shows.
#include "clouds/view_ray.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0) uniform sampler2D u_rays;
layout(binding = 1) uniform sampler2D u_far;
layout(binding = 0, rgba32f) uniform writeonly image2D o_rays;
layout(binding = 1, r32f) uniform writeonly image2D o_distance;

void main() {
    ivec2 lane = ivec2(gl_GlobalInvocationID.xy), at = ivec2(lane.x, 2 * lane.y + ((lane.x + u_squares + 1) & 1));
    ivec2 size = textureSize(u_rays, 0), most = textureSize(u_depth, 0) - 1;
    if (any(greaterThanEqual(at, size))) return;
    float own = texelFetch(u_depth, min(at * STRIDE + u_place, most), 0).r;
    vec4 light = vec4(0.0);
    float far = 0.0, taken = 0.0, all_ = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 from = at + (i < 2 ? ivec2(2 * i - 1, 0) : ivec2(0, 2 * i - 5));
        if (any(lessThan(from, ivec2(0))) || any(greaterThanEqual(from, size))) continue;
        float depth = texelFetch(u_depth, min(from * STRIDE + u_place, most), 0).r;
        // Depth is near / distance: its ratio is that of the distances.
        float unlike = abs(depth - own) / max(max(depth, own), 1e-20), weight = 1.0 / (1e-3 + unlike * unlike);
        vec4 ray = texelFetch(u_rays, from, 0);
        float away = texelFetch(u_far, from, 0).r;
        light += weight * ray;
        all_ += weight;
        // Rays that met nothing know no distance.
        float counts = away < NOT_ALL ? weight * max(1.0 - ray.a, 1e-3) : 0.0;
        far += counts * away;
        taken += counts;
    }
    imageStore(o_rays, at, light / all_);
    imageStore(o_distance, at, vec4(taken > 0.0 ? far / taken : NOT_ALL));
}
