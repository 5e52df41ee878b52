// Points of the integer lattice on the tangent-warped cube, measured from an anchor without cancellation.
//
// Faces 0..5 are +X -X +Y -Y +Z -Z. A lattice point is (face, I, J) with I and J in [0, 2^30]; with a = (I - 2^29) *
// step, b = (J - 2^29) * step, step = (pi / 2) / 2^30, its direction is normalize(tan(a) x + tan(b) y + z) in the
// face's axes. A vertex is a function of these integers only, and a point on a border is computed as a point of the
// lowest face that contains it, so two cells that share a vertex get the same bits.
//
//   ivec3 lattice_canonical(int face, ivec2 ij)      (I, J, face)
//   vec3  lattice_foot_offset(int face, ivec2 ij)    radius * (direction - anchor's direction), metres, planet axes
//   vec3  lattice_direction(int face, ivec2 ij)      unit, planet axes
//
// The relative error of the offset is below 5e-7 from one lattice step to twice the radius. sin and cos are
// polynomials: the built-in ones lose their relative accuracy near zero on some GPUs. No acos, asin or atan.

#include "generated/bindings.glsl"
#include "generated/lattice_block.glsl"

const int PF_LATTICE_HALF = 1 << 29;
const float PF_LATTICE_STEP = 1.4629180792671596e-9;

const ivec3 PF_LATTICE_X[6] = ivec3[6](
    ivec3(0, 0, 1), ivec3(0, 0, -1), ivec3(1, 0, 0), ivec3(1, 0, 0), ivec3(1, 0, 0), ivec3(-1, 0, 0));
const ivec3 PF_LATTICE_Y[6] = ivec3[6](
    ivec3(0, -1, 0), ivec3(0, -1, 0), ivec3(0, 0, -1), ivec3(0, 0, 1), ivec3(0, 1, 0), ivec3(0, 1, 0));
const ivec3 PF_LATTICE_Z[6] = ivec3[6](
    ivec3(1, 0, 0), ivec3(-1, 0, 0), ivec3(0, 1, 0), ivec3(0, -1, 0), ivec3(0, 0, 1), ivec3(0, 0, -1));

// sin(x) / x as a function of x * x, for |x| <= 2.3: 1 ulp.
float pf_lattice_sinc(float x2) {
    precise float s = 1.0 + x2 * (-1.6666667e-1 + x2 * (8.3333333e-3 + x2 * (-1.9841270e-4 + x2 * (2.7557319e-6
        + x2 * (-2.5052108e-8 + x2 * (1.6059044e-10 - x2 * 7.6471637e-13))))));
    return s;
}

// cos(x) as a function of x * x, for |x| <= pi / 4.
float pf_lattice_cos(float x2) {
    precise float c = 1.0 + x2 * (-0.5 + x2 * (4.1666667e-2 + x2 * (-1.3888889e-3 + x2 * (2.4801587e-5
        - x2 * 2.7557319e-7))));
    return c;
}

vec3 pf_lattice_to_planet(int face, vec3 local) {
    precise vec3 v = local.x * vec3(PF_LATTICE_X[face]) + local.y * vec3(PF_LATTICE_Y[face])
        + local.z * vec3(PF_LATTICE_Z[face]);
    return v;  // exact: a permutation with signs
}

// The same point, named by the lowest face that contains it. Integers only.
ivec3 lattice_canonical(int face, ivec2 ij) {
    ivec2 c = ij - PF_LATTICE_HALF;
    // Points inside a face, nearly all, keep their name.
    if (max(abs(c.x), abs(c.y)) < PF_LATTICE_HALF) return ivec3(ij, face);
    ivec3 p = c.x * PF_LATTICE_X[face] + c.y * PF_LATTICE_Y[face] + PF_LATTICE_HALF * PF_LATTICE_Z[face];
    int lowest = p.x == PF_LATTICE_HALF ? 0 : p.x == -PF_LATTICE_HALF ? 1
        : p.y == PF_LATTICE_HALF ? 2 : p.y == -PF_LATTICE_HALF ? 3 : p.z == PF_LATTICE_HALF ? 4 : 5;
    ivec3 x = p * PF_LATTICE_X[lowest];
    ivec3 y = p * PF_LATTICE_Y[lowest];
    return ivec3(x.x + x.y + x.z + PF_LATTICE_HALF, y.x + y.y + y.z + PF_LATTICE_HALF, lowest);
}

// cos a, cos b, tan a, tan b of a lattice point.
vec4 pf_lattice_gnomonic(ivec2 ij) {
    precise vec2 a = vec2(ij - PF_LATTICE_HALF) * PF_LATTICE_STEP;
    precise vec2 a2 = a * a;
    precise vec2 c = vec2(pf_lattice_cos(a2.x), pf_lattice_cos(a2.y));
    precise vec2 t = a * vec2(pf_lattice_sinc(a2.x), pf_lattice_sinc(a2.y)) / c;
    return vec4(c, t);
}

vec3 lattice_direction(int face, ivec2 ij) {
    ivec3 point = lattice_canonical(face, ij);
    vec4 g = pf_lattice_gnomonic(point.xy);
    precise float n = sqrt(1.0 + g.z * g.z + g.w * g.w);
    precise vec3 local = vec3(g.zw, 1.0) / n;
    return pf_lattice_to_planet(point.z, local);
}

vec3 lattice_foot_offset(int face, ivec2 ij) {
    ivec3 point = lattice_canonical(face, ij);
    int f = point.z;
    vec4 g = pf_lattice_gnomonic(point.xy);
    precise float n = sqrt(1.0 + g.z * g.z + g.w * g.w);
    LatticeFace anchor = lattice_block.faces[f];
    if (!anchor.near) {
        // The anchor is more than 0.25 radii away from every point of this face: the difference is as good as its
        // terms.
        precise vec3 local = vec3(g.zw, 1.0) / n;
        precise vec3 difference = pf_lattice_to_planet(f, local) - lattice_block.up - lattice_block.up_low;
        return difference * lattice_block.radius_m;
    }
    vec3 q0 = vec3(anchor.tangent, anchor.norm);
    precise vec2 steps = vec2(point.xy - anchor.nearest) - anchor.fraction;
    precise vec2 d = steps * PF_LATTICE_STEP;
    precise vec2 d2 = d * d;
    // tan a - tan a0 = sin(a - a0) / (cos a0 cos a)
    precise vec2 delta = steps * anchor.step_per_cosine * vec2(pf_lattice_sinc(d2.x), pf_lattice_sinc(d2.y)) / g.xy;
    precise float w = delta.x * (g.z + q0.x) + delta.y * (g.w + q0.y);
    precise float t = w / ((n + q0.z) * q0.z);
    precise vec3 local = vec3(delta.x - q0.x * t, delta.y - q0.y * t, -t) * (lattice_block.radius_m / n);
    return pf_lattice_to_planet(f, local);
}
