#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "generated/cover_map.glsl"
#include "cover/tree.glsl"
#include "cover/snow.glsl"
#include "cover/hue.glsl"

in vec3 v_ray;
flat in vec3 v_camera;
flat in vec3 v_x, v_up;
flat in vec4 v_form;
flat in float v_height_m;
flat in float v_hue;
flat in float v_snow;
flat in vec4 v_lobes[TREE_LOBES];
#ifdef COVER_SPECIES
flat in int v_own;
#include "cover/own_species.glsl"
#endif
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;   // square root of the albedo, share of light from around
layout(location = 2) out uint o_surface;

uniform vec3 u_albedos[3];   // by species, and of bark
uniform vec3 u_autumn[4];    // of leaves that have turned
uniform vec2 u_season;       // shares of broadleaves' leaves that have turned, and fallen

// Each tree has its own day. from: 0..1, before all; chance: 0..1.
float on_its_day(float from, float chance) {
    return clamp(2.0 * from - chance, 0.0, 1.0);
}

void main() {
    float away = length(v_ray), day = fract(13.0 * v_form.w);
#ifdef COVER_SPECIES
    OwnSpecies own = own_species(v_own);
    float leaves = own.leaves;
    float sheds = v_own > 0 ? own.sheds : v_form.y < 0.5 ? 1.0 : 0.0;
#else
    const float leaves = 1.0;
    float sheds = v_form.y < 0.5 ? 1.0 : 0.0;
#endif
    float bare = v_form.y == TREE_DEAD ? 1.0 : sheds * on_its_day(u_season.y, day);
    TreeHit hit = tree_hit(v_form.y, v_camera, v_ray / away, v_form.x, v_form.z, v_lobes,
        away * frame.pixel_rad, min(TUFT_M, SMALL_TUFT * v_form.x * v_height_m) / v_height_m, bare, leaves);
    if (hit.t <= 0.0) discard;
    // Leaves of one tree differ little, trees from one another more.
    vec3 leaf = u_albedos[v_form.y == TREE_CONIFER ? 1 : 0], turned = u_autumn[int(4.0 * fract(7.0 * v_form.w))];
#ifdef COVER_SPECIES
    leaf = v_own > 0 ? own.albedo : leaf;
    turned = v_own > 0 ? own.autumn : turned;
#endif
    leaf = mix(leaf, turned, sheds * on_its_day(u_season.x, day));
    leaf = mix(leaf, u_albedos[2], 0.9 * bare)
        * (1.0 + 0.5 * (v_form.w - 0.5) * vec3(1.2, 0.8, 0.7) + v_hue * HUE_TINT);
    leaf = mix(leaf, u_albedos[2], hit.bark);
    float white = snow_on(hit, v_snow, bare);
    if (white > 0.0) {
        leaf = mix(leaf, cover_map.snow.rgb, white);
        hit.normal = normalize(hit.normal + vec3(0.0, 0.0, SNOW_SMOOTH * white));
    }
    o_normal = oct_encode(mat3(v_x, cross(v_up, v_x), v_up) * hit.normal);
    o_attributes = vec4(sqrt(clamp(leaf, 0.0, 1.0)), hit.bark > 0.5 ? 0.5 * hit.open : 0.5 + 0.5 * hit.open);
#ifdef COVER_SPECIES
    if (v_own > 0 && hit.bark < 0.5) o_attributes = coded_leaf(o_attributes.rgb, own.translucency, hit.open);
#endif
    o_surface = SURFACE_COVER;
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = frame.near_m * gl_FragCoord.w;
#endif
}
