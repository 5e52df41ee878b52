#include "cover/tree.glsl"

in vec3 v_point;
flat in vec4 v_foot;
flat in vec4 v_form;
flat in vec4 v_lobes[TREE_LOBES];
layout(location = 0) out float o_along;   // metres to the sun from the map's middle, of the highest leaf

uniform vec3 u_sun, u_up;
uniform float u_per_m, u_texel_m, u_deep_m;

void main() {
    mat3 axes = tree_axes(u_up, v_form.z);
    float per_m = 1.0 / v_foot.w, start_m = 2.0 * v_foot.w;
    vec3 from = (v_point + start_m * u_sun - v_foot.xyz) * axes * per_m, ray = -u_sun * axes;
    TreeHit hit = tree_hit(uint(v_form.y), from, ray, v_form.x, v_form.z, v_lobes, u_texel_m * per_m, 0.13 * per_m);
    if (hit.t <= 0.0) discard;
    o_along = dot(v_point, u_sun) + start_m - hit.t * v_foot.w;
    // The nearest to the sun wins.
    gl_FragDepth = clamp(0.5 + 0.5 * o_along / u_deep_m, 0.0, 1.0);
}
