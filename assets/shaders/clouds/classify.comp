// What each tile of 8 x 4 rays meets: 0 no layer (nothing, or ground before it), 1 layers in which the weather has no
// cloud there, 2 cloud, 3 cloud with cirrus. As exact as the march: it knows the weather at the same places. What no
// cloud is met by is written at once.
#include "generated/bindings.glsl"
#include "clouds/view_ray.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
layout(binding = 1, r32f) uniform writeonly image2D o_distance;
layout(std430, binding = FLAG_BUFFER) writeonly buffer FlagBuffer { uint flags[]; };

shared uint s_found;

void main() {
    if (gl_LocalInvocationIndex == 0u) s_found = 0u;
    barrier();
    ivec2 at = cloud_block_of(ivec2(gl_GlobalInvocationID.xy)), size = imageSize(o_clouds);
    ViewRay v = cloud_view_ray(at);
    vec2 intervals[2 * CLOUD_VIEW_LAYERS];
    int owners[2 * CLOUD_VIEW_LAYERS];
    int count = all(lessThan(at, size)) ? cloud_intervals(v.mu, v.end, intervals, owners) : 0;
    uint found = count > 0 ? 1u : 0u;
    int k = 0;
    if (count > 0) do {
        CloudViewLayer shell = cloud_view.layers[owners[k]];
        bool cirrus = shell.kind == CLOUD_CIRRUS;
        float from = intervals[k].x, to = intervals[k].y, most = shell.kind == CLOUD_UNIFORM ? 1.0 : 0.0,
            least = cirrus ? CIRRUS_LEAST : 0.0, apart = cirrus_apart(shell, from, to),
            segments = segment_count(shell, from, to),
            places = cirrus ? float(cirrus_places(apart)) : segments + 1.0;
        int place = 0;
        do {
            CloudWeather w = weather_along(v.ray, cirrus ? cirrus_place(from, to, apart, place)
                : place == 0 ? from : segment_end(shell, from, to, place - 1, segments));
            most = max(most, (cirrus ? w.high : w.cover) * shell.cover_scale);
        } while (float(++place) < places && most <= least);
        found |= most > least ? (cirrus ? 4u : 2u) : 0u;
    } while (++k < count);
    if (found != 0u) atomicOr(s_found, found);
    imageStore(o_clouds, at, vec4(0.0, 0.0, 0.0, 1.0));
    imageStore(o_distance, at, vec4(UNBOUNDED));
    barrier();
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (gl_LocalInvocationIndex == 0u) flags[tile] = s_found >= 4u ? 3u : min(s_found, 2u);
}
