// Rays of the blocks between those that were followed on a checkerboard's squares (view_ray.glsl): the mean of the four
// around, in which those count that ended on what the block's own pixel shows. And what is shown where there is no
// history: the same of those blocks; of the others a mean with as much noise, or the board would be seen.
#include "clouds/view_ray.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 6) uniform sampler2D u_rays;
layout(binding = 5) uniform sampler2D u_distance;
layout(binding = 0, rgba32f) uniform writeonly image2D o_rays;
layout(binding = 1, r32f) uniform writeonly image2D o_distance;
layout(binding = 2, rgba32f) uniform writeonly image2D o_upsampled;

// Of a ray itself and of those on its squares two blocks off along a diagonal and along a row or column: their squares
// add up to nearly 1 / 4, as those of a mean of four do.
const vec3 KEPT = vec3(0.4375, 0.09375, 0.046875);

struct Mean {
    vec4 color;      // radiance, transmittance
    float weight;
    float distance_sum, opacity;
};

void add_ray(inout Mean m, ivec2 at, float weight, float own) {
    ivec2 size = textureSize(u_rays, 0), most = textureSize(u_depth, 0) - 1;
    bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
    at = clamp(at, ivec2(0), size - 1);
    float depth = texelFetch(u_depth, min(at * STRIDE + u_place, most), 0).r;
    // Depth is near / distance: its ratio is that of the distances.
    float unlike = abs(depth - own) / max(max(depth, own), 1e-20);
    weight = inside ? weight / (1e-3 + unlike * unlike) : 0.0;
    vec4 ray = texelFetch(u_rays, at, 0);
    float away = texelFetch(u_distance, at, 0).r;
    m.color += weight * ray;
    m.weight += weight;
    // Rays that met nothing know no distance.
    float counts = away < UNBOUNDED ? weight * max(1.0 - ray.a, 1e-3) : 0.0;
    m.distance_sum += counts * away;
    m.opacity += counts;
}

void main() {
    ivec2 lane = ivec2(gl_GlobalInvocationID.xy), followed = cloud_block_of(lane),
        between = ivec2(lane.x, followed.y ^ 1);
    ivec2 size = textureSize(u_rays, 0), most = textureSize(u_depth, 0) - 1;
    if (all(lessThan(between, size))) {
        float own = texelFetch(u_depth, min(between * STRIDE + u_place, most), 0).r;
        Mean m = Mean(vec4(0.0), 0.0, 0.0, 0.0);
        for (int i = 0; i < 4; ++i) add_ray(m, between + (i < 2 ? ivec2(2 * i - 1, 0) : ivec2(0, 2 * i - 5)), 1.0, own);
        vec4 color = m.weight > 0.0 ? m.color / m.weight : vec4(0.0, 0.0, 0.0, 1.0);   // a picture of one block
        imageStore(o_rays, between, color);
        imageStore(o_distance, between, vec4(m.opacity > 0.0 ? m.distance_sum / m.opacity : UNBOUNDED));
        imageStore(o_upsampled, between, color);
    }
    if (all(lessThan(followed, size))) {
        float own = texelFetch(u_depth, min(followed * STRIDE + u_place, most), 0).r;
        Mean m = Mean(vec4(0.0), 0.0, 0.0, 0.0);
        add_ray(m, followed, KEPT.x, own);
        for (int i = 0; i < 4; ++i) {
            add_ray(m, followed + ivec2(2 * (i & 1) - 1, (i & 2) - 1), KEPT.y, own);
            add_ray(m, followed + (i < 2 ? ivec2(4 * i - 2, 0) : ivec2(0, 4 * i - 10)), KEPT.z, own);
        }
        imageStore(o_upsampled, followed, m.color / m.weight);
    }
}
