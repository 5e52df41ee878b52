// A pixel of the sea in the G-buffer: where the point that it shows lies when the sea is calm.
#include "generated/bindings.glsl"
#include "contract/land_water.glsl"
#include "common/texel.glsl"
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
#ifdef SEA_MOVES
layout(binding = SEA_MOVED_UNIT) uniform sampler2D u_moved;
#endif

bool sea_at(ivec2 pixel) {
    return all(lessThan(pixel, textureSize(u_surface, 0))) && texel_at(u_surface, pixel).r == SURFACE_SEA;
}

// Whether its waves are the sea's: rivers and lakes have none of them.
bool sea_waves_at(ivec2 pixel) {
#ifdef LAND_WATER
    return sea_at(pixel) && !land_water_at(texel_at(u_attributes, pixel).z);
#else
    return sea_at(pixel);
#endif
}

// From the camera, m.
vec3 sea_point(ivec2 pixel) {
    return position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texel_at(u_depth, pixel).r);
}

SeaPlace sea_calm_place(ivec2 pixel, vec3 point) {
    float height;
    vec3 D = foot_offset_of(point, height);
    SeaPlace place = sea_place(D);
#ifdef SEA_MOVES
    vec2 moved = texel_at(u_moved, pixel).xy * (sea_waves.farthest_m / sea_waves.per_foot);
    place = sea_place(D - sea_vector(place, vec3(moved, 0.0)));
#endif
    return place;
}
