layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;
layout(location = 2) out uint o_surface;

void main() {
    o_normal = vec2(0.0);
    o_attributes = vec4(0.0);
    o_surface = 0u;
    gl_FragDepth = 0.0;
}
