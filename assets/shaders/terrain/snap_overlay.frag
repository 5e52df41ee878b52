// Debug view: edges of the mesh before and after a snap.
uniform vec3 u_color;
layout(location = 0) out vec4 o_color;

void main() {
    o_color = vec4(u_color, 1.0);
}
