// A quad of two triangles without a buffer: its corner, -1..1, of one of six vertices.
vec2 quad_corner(int vertex) {
    return vec2(vertex == 1 || vertex == 2 || vertex == 4 ? 1.0 : -1.0, vertex == 2 || vertex >= 4 ? 1.0 : -1.0);
}
