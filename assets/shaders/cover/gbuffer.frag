#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "cover/tree.glsl"

in vec3 v_point;
flat in vec4 v_foot;
flat in vec4 v_form;
flat in vec4 v_lobes[TREE_LOBES];
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;   // square root of the albedo, share of light from around
layout(location = 2) out uint o_surface;

uniform vec3 u_albedos[3];   // by species, and of bark

void main() {
    vec3 up = up_at(v_foot.xyz);
    mat3 axes = tree_axes(up, v_form.z);
    float per_m = 1.0 / v_foot.w;
    vec3 from = -v_foot.xyz * axes * per_m, ray = normalize(v_point) * axes;
    float pixel = length(v_point) * frame.pixel_rad * per_m;
    TreeHit hit = tree_hit(uint(v_form.y), from, ray, v_form.x, v_form.z, v_lobes, pixel, 0.13 * per_m);
    if (hit.t <= 0.0) discard;
    // Leaves of one tree differ little, trees from one another more.
    vec3 leaf = u_albedos[int(v_form.y)] * (1.0 + 0.5 * (v_form.w - 0.5) * vec3(1.2, 0.8, 0.7));
    o_normal = oct_encode(axes * hit.normal);
    o_attributes = vec4(sqrt(clamp(mix(leaf, u_albedos[2], hit.bark), 0.0, 1.0)), hit.bark > 0.5 ? 0.5 * hit.open
        : 0.5 + 0.5 * hit.open);
    o_surface = SURFACE_COVER;
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = frame.near_m * gl_FragCoord.w;
#endif
}
