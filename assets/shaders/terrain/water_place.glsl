// The place on the ground that a pixel shows, for passes that ask rivers of it.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/surfaces.glsl"
#include "common/texel.glsl"
#include "contract/waterline.glsl"

layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;

struct WaterPlace {
    vec3 point, D;         // from the camera; its foot offset
    float height, depth;   // m over the reference sphere; as the buffer has it
    uint surface;
    bool open;             // ground or sea, seen from the air
};

WaterPlace water_place(ivec2 pixel) {
    WaterPlace place;
    ivec2 at = min(pixel, textureSize(u_surface, 0) - 1);
    vec2 ndc = ndc_of_pixel(vec2(at) + 0.5);
    place.surface = texel_at(u_surface, at).r;
    place.depth = texel_at(u_depth, at).r;
    place.point = position_from_depth(ndc, max(place.depth, 1e-30));
    place.D = foot_offset_of(place.point, place.height);
    place.open = place.depth > 0.0 && (place.surface == SURFACE_TERRAIN || place.surface == SURFACE_SEA)
        && !lens_in_water(ndc);
    return place;
}
