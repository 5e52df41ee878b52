#include "cover/tree.glsl"

in vec3 v_from;
flat in vec3 v_ray;
in float v_start_m;
flat in vec4 v_form;
flat in vec4 v_lobes[TREE_LOBES];
#ifdef COVER_SPECIES
flat in int v_own;
#include "cover/own_species.glsl"
#endif
layout(location = 0) out float o_along;   // metres to the sun from the map's middle, of the highest leaf

uniform float u_texel_m, u_deep_m;
uniform float u_bare;   // share of broadleaves' leaves that have fallen

void main() {
    float height_m = v_form.w;
#ifdef COVER_SPECIES
    OwnSpecies own = own_species(v_own);
    float leaves = own.leaves;
    bool sheds = v_own > 0 ? own.sheds > 0.5 : v_form.y < 0.5;
#else
    const float leaves = 1.0;
    bool sheds = v_form.y < 0.5;
#endif
    TreeHit hit = tree_hit(v_form.y, v_from, v_ray, v_form.x, v_form.z, v_lobes, u_texel_m / height_m,
        min(TUFT_M, SMALL_TUFT * v_form.x * height_m) / height_m,
        v_form.y == TREE_DEAD ? 1.0 : sheds ? u_bare : 0.0, leaves);
    if (hit.t <= 0.0) discard;
    o_along = v_start_m - hit.t * height_m;
    // The nearest to the sun wins.
    gl_FragDepth = clamp(0.5 + 0.5 * o_along / u_deep_m, 0.0, 1.0);
}
