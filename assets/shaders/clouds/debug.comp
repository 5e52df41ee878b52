// For debug views: which class a ray's tile has, and how many samples of density the march takes along it.
#include "generated/bindings.glsl"
#include "clouds/view_ray.glsl"
#include "clouds/weather_march.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba8) uniform writeonly image2D o_classes;
layout(binding = 1, r32f) uniform writeonly image2D o_steps;
layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };

void main() {
    uint kind = flags[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x];
    ivec2 at = cloud_block_of(ivec2(gl_GlobalInvocationID.xy));
    ivec2 size = imageSize(o_steps);
    if (at.y >= size.y) at.y ^= 1;   // the last of an odd number of rows: the block without a ray
    if (any(greaterThanEqual(at, size))) return;
    ViewRay v = cloud_view_ray(at);
    March m = march_clouds(v.ray, v.mu, kind >= 2u ? v.end : 0.0, v.jitter);
    vec3 color = kind >= 2u ? vec3(0.9, 0.9, 0.85) : kind == 1u ? vec3(0.1, 0.25, 0.6) : vec3(0.03);
    for (int k = 0; k < (u_checkerboard < 0 ? 1 : 2); ++k) {
        imageStore(o_classes, at, vec4(color * (0.4 + 0.6 * m.transmittance), 1.0));
        imageStore(o_steps, at, vec4(m.samples));
        at.y ^= 1;   // of two blocks the one without a ray
    }
}
