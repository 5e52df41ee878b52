// One triangle over the whole viewport; draw three vertices without any buffer.

out vec2 v_ndc;  // -1..1, y up
out vec2 v_uv;   // 0..1, y up

void main() {
    vec2 corner = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
    v_uv = corner;
    v_ndc = corner * 2.0 - 1.0;
    gl_Position = vec4(v_ndc, 0.0, 1.0);
}
