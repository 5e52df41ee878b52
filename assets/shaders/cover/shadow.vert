// The same quads, facing the sun, on the map of their shadows.
#include "generated/bindings.glsl"
#include "cover/axes.glsl"
#include "cover/lobes.glsl"
#include "cover/quad.glsl"
#include "generated/cover.glsl"

layout(std430, binding = TREE_BUFFER) readonly buffer TreeBuffer { CoverTree trees[]; };
uniform vec3 u_x, u_y, u_sun;   // across the map, and to the sun: planet axes
uniform vec3 u_up;              // at the map's middle
uniform int u_first;
uniform float u_per_m;          // 1 / half the map's side

out vec3 v_from;                // where the ray to the ground begins, in the tree's own space
flat out vec3 v_ray;
out float v_start_m;            // of that, metres to the sun from the map's middle
flat out vec4 v_form;           // radius, species, turn, height in metres
flat out vec4 v_lobes[TREE_LOBES];
#ifdef COVER_SPECIES
flat out int v_own;             // which of the planet's own, from 1 on; 0: none of them
#endif

void main() {
    CoverTree tree = trees[u_first + gl_InstanceID];
#ifdef COVER_SPECIES
    v_own = int(tree.species) >> 3;
    tree.species = float(int(tree.species) & 7);
#endif
    vec2 corner = quad_corner(gl_VertexID);
    vec3 middle = tree.foot_m + (0.5 * tree.height_m) * u_up;
    float half_m = HALF_HIGH * tree.height_m, wide_m = HALF_WIDE * tree.radius_m, along = abs(dot(u_sun, u_up));
    // The map's y axis is the one that the zenith leans along.
    vec2 reach = vec2(wide_m, half_m * sqrt(1.0 - along * along) + wide_m * along);
    vec3 point = middle + corner.x * reach.x * u_x + corner.y * reach.y * u_y;
    mat3 axes = tree_axes(u_up, tree.turn);
    vec3 start = point + 2.0 * tree.height_m * u_sun;
    v_from = (start - tree.foot_m) * axes * (1.0 / tree.height_m);
    v_ray = -u_sun * axes;
    v_start_m = dot(start, u_sun);
    tree_lobes(tree.species, tree.radius_m / tree.height_m, tree.turn, v_lobes);
    v_form = vec4(tree.radius_m / tree.height_m, tree.species, tree.turn, tree.height_m);
    gl_Position = vec4(dot(point, u_x) * u_per_m, dot(point, u_y) * u_per_m, 0.5, 1.0);
}
