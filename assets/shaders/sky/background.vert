// Where the air can be: from inside it the whole picture, from space a fan around the cone that it fills, infinitely
// far away. No attributes: corners come from gl_VertexID (triangle fan; the first vertex is the middle).
#include "common/camera.glsl"

// tangent of the cone's half angle (negative: everything), angle between corners
layout(location = 0) uniform vec2 u_shell;

void main() {
    if (u_shell.x < 0.0) {
        gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
        return;
    }
    vec3 down = -frame.camera_zenith;
    vec3 u = normalize(cross(down, abs(down.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    float angle = float(gl_VertexID - 1) * u_shell.y;
    vec3 aside = u * cos(angle) + cross(down, u) * sin(angle);
    gl_Position = clip_position(down + (gl_VertexID == 0 ? vec3(0.0) : aside * u_shell.x));
    gl_Position.z = 0.0;
}
