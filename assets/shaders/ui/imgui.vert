// Vertices of Dear ImGui: window units, colours already encoded for the screen.

uniform vec4 u_transform;  // scale xy and offset xy from window units to clip space

in vec2 in_position;
in vec2 in_uv;
in vec4 in_color;
out vec2 v_uv;
out vec4 v_color;

void main() {
    v_uv = in_uv;
    v_color = in_color;
    gl_Position = vec4(in_position * u_transform.xy + u_transform.zw, 0.0, 1.0);
}
