// Points of the integer lattice on the icosahedron, in double: engine/surface/icosphere.py and icosphere_anchor.py.
//
// A lattice point is (root, b, c) with b, c >= 0 and b + c <= 2^30; a = 2^30 - b - c. Its vector a V0 + b V1 + c V2 is
// an integer vector below 2^53: exact in double in any order, and the same from each root that contains the point. All
// that follows is a function of that vector and of the lowest root that contains it.
//
//   dvec3 triangle_vector(int root, ivec2 bc)         not normalised, exact
//   dvec3 triangle_direction(int root, ivec2 bc)      unit, planet axes
//   vec3  triangle_foot_offset(int root, ivec2 bc)    radius * (direction - anchor's direction), metres, planet axes
//
// The relative error of the offset is that of its conversion to float, 6e-8, from one lattice step to twice the radius.

#include "generated/triangle_anchor.glsl"

const int PF_TRIANGLE_FULL = 1 << 30;
const ivec3 PF_ICO_CORNERS[12] = ivec3[12](
    ivec3(0, 2178309, 3524578), ivec3(0, 2178309, -3524578), ivec3(0, -2178309, 3524578),
    ivec3(0, -2178309, -3524578), ivec3(3524578, 0, 2178309), ivec3(-3524578, 0, 2178309),
    ivec3(3524578, 0, -2178309), ivec3(-3524578, 0, -2178309), ivec3(2178309, 3524578, 0),
    ivec3(2178309, -3524578, 0), ivec3(-2178309, 3524578, 0), ivec3(-2178309, -3524578, 0));
const ivec3 PF_ICO_ROOTS[20] = ivec3[20](
    ivec3(0, 2, 4), ivec3(0, 5, 2), ivec3(0, 4, 8), ivec3(0, 10, 5), ivec3(0, 8, 10), ivec3(1, 6, 3), ivec3(1, 3, 7),
    ivec3(1, 8, 6), ivec3(1, 7, 10), ivec3(1, 10, 8), ivec3(2, 9, 4), ivec3(2, 5, 11), ivec3(2, 11, 9), ivec3(3, 6, 9),
    ivec3(3, 11, 7), ivec3(3, 9, 11), ivec3(4, 6, 8), ivec3(4, 9, 6), ivec3(5, 10, 7), ivec3(5, 7, 11));
const ivec3 PF_ICO_LOWEST_OF_EDGE[20] = ivec3[20](
    ivec3(0, 0, 0), ivec3(1, 1, 0), ivec3(0, 2, 2), ivec3(3, 3, 1), ivec3(2, 4, 3), ivec3(5, 5, 5), ivec3(5, 6, 6),
    ivec3(7, 7, 5), ivec3(6, 8, 8), ivec3(8, 4, 7), ivec3(10, 10, 0), ivec3(1, 11, 11), ivec3(11, 12, 10),
    ivec3(5, 13, 13), ivec3(14, 14, 6), ivec3(13, 12, 14), ivec3(16, 7, 2), ivec3(10, 13, 16), ivec3(3, 8, 18),
    ivec3(18, 14, 11));
const int PF_ICO_LOWEST_OF_CORNER[12] = int[12](0, 5, 0, 5, 0, 1, 5, 6, 2, 10, 3, 11);

dvec3 triangle_vector(int root, ivec2 bc) {
    ivec3 corners = PF_ICO_ROOTS[root];
    int a = PF_TRIANGLE_FULL - bc.x - bc.y;
    return double(a) * dvec3(PF_ICO_CORNERS[corners.x]) + double(bc.x) * dvec3(PF_ICO_CORNERS[corners.y])
        + double(bc.y) * dvec3(PF_ICO_CORNERS[corners.z]);
}

double pf_triangle_length(dvec3 v) {
    precise double squares = v.x * v.x + v.y * v.y + v.z * v.z;
    return sqrt(squares);
}

dvec3 triangle_direction(int root, ivec2 bc) {
    dvec3 v = triangle_vector(root, bc);
    precise dvec3 direction = v / pf_triangle_length(v);
    return direction;
}

// Which root's numbers of the anchor are used: the lowest that contains the point, so that edges have one choice.
int pf_triangle_row(int root, ivec2 bc) {
    ivec3 weights = ivec3(PF_TRIANGLE_FULL - bc.x - bc.y, bc);
    if (min(weights.x, min(weights.y, weights.z)) > 0) return root;
    ivec3 corners = PF_ICO_ROOTS[root], edges = PF_ICO_LOWEST_OF_EDGE[root];
    if (weights.x == PF_TRIANGLE_FULL) return PF_ICO_LOWEST_OF_CORNER[corners.x];
    if (weights.y == PF_TRIANGLE_FULL) return PF_ICO_LOWEST_OF_CORNER[corners.y];
    if (weights.z == PF_TRIANGLE_FULL) return PF_ICO_LOWEST_OF_CORNER[corners.z];
    return weights.z == 0 ? edges.x : weights.x == 0 ? edges.y : edges.z;
}

vec3 pf_triangle_offset(dvec3 p, int row) {
    double norm = pf_triangle_length(p);
    double radius_m = triangle_anchor.radius_m;
    TriangleRoot root = triangle_anchor.roots[row];
    if (root.length == 0.0LF) {
        precise dvec3 far = (p / norm - triangle_anchor.direction) * radius_m;
        return vec3(far);
    }
    precise dvec3 d = (p - root.whole) - root.rest;
    precise dvec3 q0 = root.whole + root.rest;
    precise dvec3 sums = p + q0;
    precise double w = d.x * sums.x + d.y * sums.y + d.z * sums.z;
    precise double t = w / ((norm + root.length) * root.length);
    precise dvec3 offset = (d - q0 * t) * (radius_m / norm);
    return vec3(offset);
}

vec3 triangle_foot_offset(int root, ivec2 bc) {
    return pf_triangle_offset(triangle_vector(root, bc), pf_triangle_row(root, bc));
}

// The same of a point between two lattice points of a root, `part` of the way along the straight line.
vec3 triangle_foot_offset_between(int root, ivec2 bc, ivec2 to, float part) {
    dvec3 p = triangle_vector(root, bc), q = triangle_vector(root, to);
    return pf_triangle_offset(p + (q - p) * double(part), root);
}
