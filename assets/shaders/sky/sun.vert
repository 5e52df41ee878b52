// A square around the sun's disc, infinitely far away. No attributes: the corner comes from gl_VertexID (triangle
// strip).
#include "common/camera.glsl"

out vec2 v_slope;  // tangents of the angle from the centre, in two directions: exact however narrow the view

void main() {
    vec3 sun = frame.sun_direction;
    vec3 helper = abs(sun.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
    vec3 u = normalize(cross(sun, helper));
    vec3 v = cross(u, sun);
    float reach = tan(frame.sun_radius_rad) + 2.0 * frame.pixel_rad;
    vec2 corner = vec2((gl_VertexID & 1) != 0 ? 1.0 : -1.0, (gl_VertexID & 2) != 0 ? 1.0 : -1.0);
    v_slope = corner * reach;
    gl_Position = clip_position(sun + u * v_slope.x + v * v_slope.y);
    gl_Position.z = 0.0;
}
