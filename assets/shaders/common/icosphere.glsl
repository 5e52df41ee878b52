// Points of the integer lattice on the icosahedron: engine/surface/icosphere.py and icosphere_anchor.py.
//
// A lattice point is (root, b, c) with b, c >= 0 and b + c <= 2^30; a = 2^30 - b - c. Its vector a V0 + b V1 + c V2 is
// an integer vector below 2^53, the same from each root that contains the point. All that follows is a function of that
// vector alone, in pairs of floats: errors are 2^-43 of the radius along it, 2^-45 across, and those of floats.
//
//   Pair3 triangle_vector(int root, ivec2 bc)         not normalised
//   Pair3 triangle_direction(int root, ivec2 bc)      unit, planet axes
//   vec3  triangle_foot_offset(int root, ivec2 bc)    radius * (direction - anchor's direction), metres, planet axes

#include "common/pair.glsl"
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

Pair3 triangle_vector(int root, ivec2 bc) {
    ivec3 corners = PF_ICO_ROOTS[root], weights = ivec3(PF_TRIANGLE_FULL - bc.x - bc.y, bc), high = ivec3(0);
    uvec3 low = uvec3(0u);
    for (int k = 0; k < 3; ++k) {
        ivec3 more_high, more_low;
        uvec3 carry;
        imulExtended(ivec3(weights[k]), PF_ICO_CORNERS[corners[k]], more_high, more_low);
        low = uaddCarry(low, uvec3(more_low), carry);
        high += more_high + ivec3(carry);
    }
    return pair_add(pair_add(vec3(high) * 4294967296.0, vec3(low >> 16) * 65536.0), vec3(low & 65535u));
}

Pair3 triangle_direction(int root, ivec2 bc) {
    return pair_unit(triangle_vector(root, bc));
}

vec3 pf_triangle_offset(Pair3 direction) {
    Pair3 anchor = Pair3(triangle_anchor.direction_high, triangle_anchor.direction_low);
    return pair_sub(direction, anchor).high * triangle_anchor.radius_m;
}

vec3 triangle_foot_offset(int root, ivec2 bc) {
    return pf_triangle_offset(triangle_direction(root, bc));
}

// The same of a point between two lattice points of a root, `part` of the way along the straight line.
vec3 triangle_foot_offset_between(int root, ivec2 bc, ivec2 to, float part) {
    Pair3 p = triangle_vector(root, bc), q = triangle_vector(root, to);
    return pf_triangle_offset(pair_unit(pair_add(p, pair_mul(pair_sub(q, p), vec3(part)))));
}
