// Clouds as the camera sees them, one ray for each block of STRIDE x STRIDE pixels: rgb what they add to the picture, a
// what they leave of it. Over the tiles of 8 x 4 rays that may see any: those with cirrus, or, in a shorter program,
// those without.
#include "generated/bindings.glsl"
#include "clouds/view_ray.glsl"
#include "clouds/weather_march.glsl"
#include "common/spread.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
layout(binding = 1, r32f) uniform writeonly image2D o_distance;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer { uint groups[8]; uint tiles[]; };
layout(location = 5) uniform int u_cirrus;   // which list

void main() {
    uint number = spread_group(), place = tiles[u_cirrus == 0 ? number : uint(tiles.length()) - 1u - number];
    ivec2 at = cloud_block_of(ivec2(place & 0xffffu, place >> 16) * ivec2(8, 4) + ivec2(gl_LocalInvocationID.xy));
    if (any(greaterThanEqual(at, imageSize(o_clouds)))) return;
    ViewRay v = cloud_view_ray(at);
    March m = march_clouds(v.ray, v.mu, v.end, v.jitter);
    imageStore(o_clouds, at, vec4(m.radiance * frame.hdr_per_radiance, m.transmittance));
    imageStore(o_distance, at, vec4(cloud_mean_distance(m)));
}
