// How the sea lies in each of its pixels: the normal of all waves that a pixel can show, and the variance of the slopes of those
// that it can't. The mesh says where the surface is and how far it was moved sideways.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "ocean/waves.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_attributes;
layout(binding = 3) uniform usampler2D u_surface;
#ifdef SEA_MOVES
layout(binding = 4) uniform sampler2D u_moved;
#endif
layout(binding = 0) writeonly uniform image2D u_normal_out;
layout(binding = 1) writeonly uniform image2D u_rough_out;

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * ivec2(16, 8) + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0))) || texelFetch(u_surface, pixel, 0).r != SURFACE_SEA) return;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    float height, distance_m = length(point);
    vec3 D = foot_offset_of(point, height);
    SeaPlace place = sea_place(D);
#ifdef SEA_MOVES
    vec2 moved = texelFetch(u_moved, pixel, 0).xy * (wave_counts.z / wave_north.w);
    place = sea_place(D - sea_vector(place, vec3(moved, 0.0)));
#endif
    float depth = sea_depth_decode(texelFetch(u_attributes, pixel, 0).rg);
    SeaSurface sea = sea_surface(place, depth, sea_footprint(place, -point / distance_m, distance_m));
    imageStore(u_normal_out, pixel, vec4(oct_encode(sea.normal), 0.0, 0.0));
    imageStore(u_rough_out, pixel, vec4(sea.variance, sea.jacobian));
}
