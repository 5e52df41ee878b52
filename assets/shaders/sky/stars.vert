// Stars as points of equal size: a Gaussian spot of fixed width in pixels, whose light over all pixels is that of the
// star.
#include "common/camera.glsl"
#ifndef STARS_CLEAR
#include "contract/air.glsl"
#endif

layout(location = 0) uniform mat3 u_star_axes;   // inertial to planet axes
layout(location = 1) uniform float u_brightness;
in vec3 in_direction;   // inertial, unit
in vec3 in_irradiance;  // W m^-2 nm^-1

flat out vec2 v_center;  // pixels
flat out vec3 v_light;   // radiance x pixels

void main() {
    vec3 direction = u_star_axes * in_direction;
    vec4 clip = clip_position(direction);
    vec2 ndc = clip.xy / max(clip.w, 1e-3);
    v_center = (ndc * 0.5 + 0.5) * frame.viewport_px;
    // Solid angle of the pixel: its area in the plane at distance 1, times the cube of the cosine.
    float pixel = 4.0 * frame.projection_scale.x * frame.projection_scale.y * frame.texel_size.x * frame.texel_size.y;
    float solid_angle = pixel * clip.w * clip.w * clip.w;
    v_light = in_irradiance * (u_brightness * frame.hdr_per_radiance / solid_angle);
#ifndef STARS_CLEAR
    v_light *= air_to_space(vec3(0.0), direction);
#endif
    // A point is clipped by its centre: hold those that reach in from just outside on the border.
    bool seen = clip.w > 1e-3 && all(lessThan(abs(ndc), vec2(1.0) + 8.0 * frame.texel_size));
    gl_Position = seen ? vec4(clamp(ndc, vec2(-1.0), vec2(1.0)), 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
    gl_PointSize = STAR_POINT_PX;
}
