#include "common/camera.glsl"

in vec3 in_position;
uniform vec3 u_shift;   // the mesh's anchor from the frame's, metres

void main() {
    gl_Position = clip_position(in_position + u_shift - frame.camera_offset_m);
    // Both meshes lie within a pixel of one another: edges are shown a little in front of the ground.
    gl_Position.z *= 1.02;
}
