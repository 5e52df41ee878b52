// Debug view: how far the drawn ground is from the height function, in pixels across the line of sight.
#include "common/camera.glsl"
#include "common/surfaces.glsl"
#include "contract/surface_height.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform usampler2D u_surface;
in vec2 v_ndc;
layout(location = 0) out float o_error_px;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    o_error_px = 0.0;
    if (texelFetch(u_surface, pixel, 0).r != SURFACE_TERRAIN) return;
    vec3 point = position_from_depth(v_ndc, texelFetch(u_depth, pixel, 0).r);
    float height;
    vec3 D = foot_offset_of(point, height);
    float distance_m = length(point);
    float off = surface_height(D, distance_m * frame.pixel_rad) - height;
    vec3 up = up_at(point);
    float along = dot(up, point) / distance_m;
    o_error_px = abs(off) * sqrt(max(1.0 - along * along, 0.0)) / (distance_m * frame.pixel_rad);
}
