const float HALF_HIGH = 0.52, HALF_WIDE = 1.03;   // of what holds a tree, over its height and its crown's radius

// A quad of two triangles without a buffer: its corner, -1..1, of one of six vertices.
vec2 quad_corner(int vertex) {
    return vec2(vertex == 1 || vertex == 2 || vertex == 4 ? 1.0 : -1.0, vertex == 2 || vertex >= 4 ? 1.0 : -1.0);
}
