#include "common/camera.glsl"
#include "generated/props.glsl"

layout(std430, binding = 0) readonly buffer InstanceBuffer { PropInstance instances[]; };
uniform int u_first;
in vec3 in_position;
in vec3 in_normal;

out vec3 v_normal;
flat out vec4 v_color;
out vec4 v_back;   // see props.motion

void main() {
    PropInstance prop = instances[u_first + gl_InstanceID];
    vec3 a = prop.a_m, b = prop.b_m, c = prop.c_m;
    gl_Position = clip_position(prop.place_m + a * in_position.x + b * in_position.y + c * in_position.z);
    // The inverse transpose, without the determinant.
    v_normal = cross(b, c) * in_normal.x + cross(c, a) * in_normal.y + cross(a, b) * in_normal.z;
    v_color = vec4(prop.color, prop.roughness);
    v_back = vec4(prop.back_a_m * in_position.x + prop.back_b_m * in_position.y + prop.back_c_m * in_position.z
        + prop.back_m, prop.was_there);
}
