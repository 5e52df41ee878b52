#include "cover/tree.glsl"

in vec3 v_from;
flat in vec3 v_ray;
in float v_start_m;
flat in vec4 v_form;
flat in vec4 v_lobes[TREE_LOBES];
layout(location = 0) out float o_along;   // metres to the sun from the map's middle, of the highest leaf

uniform float u_texel_m, u_deep_m;
uniform float u_bare;   // share of broadleaves' leaves that have fallen

void main() {
    float height_m = v_form.w;
    TreeHit hit = tree_hit(v_form.y, v_from, v_ray, v_form.x, v_form.z, v_lobes, u_texel_m / height_m,
        min(TUFT_M, SMALL_TUFT * v_form.x * height_m) / height_m,
        v_form.y == TREE_DEAD ? 1.0 : v_form.y < 0.5 ? u_bare : 0.0);
    if (hit.t <= 0.0) discard;
    o_along = v_start_m - hit.t * height_m;
    // The nearest to the sun wins.
    gl_FragDepth = clamp(0.5 + 0.5 * o_along / u_deep_m, 0.0, 1.0);
}
