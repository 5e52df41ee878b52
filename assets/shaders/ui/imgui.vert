// Vertices of Dear ImGui: window units, colours already encoded for the screen.

// from window units to clip space
uniform vec2 u_scale;
uniform vec2 u_offset;

in vec2 in_position;
in vec2 in_uv;
in vec4 in_color;
out vec2 v_uv;
out vec4 v_color;

void main() {
    v_uv = in_uv;
    v_color = in_color;
    gl_Position = vec4(in_position * u_scale + u_offset, 0.0, 1.0);
}
