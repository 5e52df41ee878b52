// Debug view: the edges of the triangles, coloured by level.
flat in int v_level;
layout(location = 0) out vec4 o_color;

void main() {
    float hue = fract(float(v_level) * 0.381966);
    vec3 color = clamp(abs(fract(hue + vec3(0.0, 0.6667, 0.3333)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    o_color = vec4(mix(vec3(1.0), color, 0.7), 1.0);
}
