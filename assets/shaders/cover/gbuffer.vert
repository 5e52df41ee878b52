// Two quads around each tree, parallel to the picture: its crown, and below it its stem. The fragment shader finds the
// tree in them. In one quad, pixels that look between stems would have to find that they miss each tree.
#include "common/camera.glsl"
#include "generated/bindings.glsl"
#include "cover/axes.glsl"
#include "cover/lobes.glsl"
#include "cover/quad.glsl"
#include "generated/cover.glsl"
#include "generated/cover_map.glsl"
#include "cover/gust.glsl"

layout(std430, binding = TREE_BUFFER) readonly buffer TreeBuffer { CoverTree trees[]; };

uniform int u_first;

const float LOWEST_LEAF = 0.40, LOWER_WIDE = 0.42;   // over the height: less so much of the crown's radius
const float STEM_WIDE = 0.03;                        // half a stem's width below the crown, over the height
const float ROSETTE_MIDDLE = 0.9;                    // height of its fronds, over that of its space
const float CONIFER_TIP = 0.25;                      // its tip's quad, over its width
const float TREE_SWAY = 0.03;   // what the wind moves a tree's top by, over what it does to grass

// In the tree's own space, cover/tree.glsl.
out vec3 v_ray;           // from the camera to the quad
flat out vec3 v_camera;
flat out vec3 v_x, v_up;  // its axes, in the planet's
flat out vec4 v_form;     // radius, species, turn, tint
#ifdef COVER_SPECIES
flat out int v_own;       // which of the planet's own, from 1 on; 0: none of them
#endif
flat out float v_height_m;
flat out float v_hue;      // -1..1
flat out float v_snow;
flat out vec4 v_lobes[TREE_LOBES];

void main() {
    CoverTree tree = trees[u_first + gl_InstanceID];
#ifdef COVER_SPECIES
    v_own = int(tree.species) >> 3;
    tree.species = float(int(tree.species) & 7);
#endif
    vec2 corner = quad_corner(gl_VertexID % 6);
    vec3 up = up_at(tree.foot_m), middle = tree.foot_m + (0.5 * tree.height_m) * up;
    float away = length(middle), half_m = HALF_HIGH * tree.height_m, wide_m = HALF_WIDE * tree.radius_m;
    // The wind leans it, the more the higher: a shear.
    vec3 lean = (TREE_SWAY * gust_at(tree.foot_m)) * cover_map.sway;
    wide_m += length(lean) * tree.height_m;
    float around = length(vec2(half_m, wide_m));
    vec3 view = middle / max(away, 1e-3), side = cross(view, up);
    side = dot(side, side) > 1e-6 ? normalize(side) : frame.camera_right;
    vec3 over = cross(side, view);
    // Seen from near, what bulges towards the eye reaches beyond its own plane's outline.
    float grow = away > 1.2 * around ? inversesqrt(1.0 - min(around * around / (away * away), 0.6)) : 4.0;
    vec2 reach = grow * vec2(wide_m, half_m * abs(dot(over, up)) + wide_m * abs(dot(view, up)));
    // Where the crown ends below, in the picture; a conifer's is as high as it, and narrower towards its tip.
    bool conifer = tree.species == TREE_CONIFER, to_ground = conifer || tree.species == TREE_COLUMN;
    bool windowed = tree.window != vec4(0.0), stem = gl_VertexID >= 6;
    vec2 tilted = abs(vec2(dot(over, up), dot(view, up)));
    float lowest_m = (LOWEST_LEAF - 0.5) * tree.height_m - LOWER_WIDE * tree.radius_m;
    float low = to_ground ? -1.0 : clamp(grow * (lowest_m * tilted.x - wide_m * tilted.y) / reach.y, -1.0, 1.0);
    float tip = conifer ? CONIFER_TIP + (1.0 - CONIFER_TIP) * min(2.0 * tilted.y + 2.0 * (grow - 1.0), 1.0) : 1.0;
    vec2 part = vec2(stem ? min((STEM_WIDE * tree.height_m + 0.5 * length(lean) * tree.height_m) * grow / reach.x, 1.0)
        : corner.y > 0.0 ? tip : 1.0, mix(stem ? -1.0 : low, stem ? low : 1.0, 0.5 + 0.5 * corner.y));
    vec3 point = middle + corner.x * part.x * reach.x * side + part.y * reach.y * over;
    // All of a tree is equally far ahead: planes that cut one another would show as lines where crowns meet.
    vec3 ahead = frame.camera_forward;
    // What a rosette shows of its space is above the ground.
    vec3 shown = tree.species == TREE_ROSETTE ? tree.foot_m + (ROSETTE_MIDDLE * tree.height_m) * up : middle;
    float ahead_m = dot(shown, ahead);
    if (ahead_m - abs(dot(side, ahead)) * reach.x - abs(dot(over, ahead)) * reach.y > 0.05 * away)
        point *= ahead_m / dot(point, ahead);
    // From near it may be on all sides.
    if (windowed) {
        vec4 window = stem ? tree.stem : tree.window;
        vec2 ndc = window.x < window.z ? mix(window.xy, window.zw, 0.5 + 0.5 * corner) : vec2(2.0);
        vec3 near_m = tree.species == TREE_ROSETTE ? shown : tree.foot_m;
        float aside_m = length(near_m - dot(near_m, up) * up);
        point = view_ray(ndc) * max(max(dot(near_m, frame.camera_forward), 0.5 * aside_m), 0.3);
    }
    mat3 axes = tree_axes(up, tree.turn);
    vec2 sheared = (lean * axes).xy;
    v_ray = point * axes * (1.0 / tree.height_m);
    v_ray.xy -= sheared * v_ray.z;
    v_camera = -tree.foot_m * axes * (1.0 / tree.height_m);
    v_camera.xy -= sheared * v_camera.z;
    v_x = axes[0];
    v_up = up;
    v_height_m = tree.height_m;
    v_hue = tree.hue;
    v_snow = tree.snow;
    tree_lobes(tree.species, tree.radius_m / tree.height_m, tree.turn, v_lobes);
    v_form = vec4(tree.radius_m / tree.height_m, tree.species, tree.turn, tree.tint);
    gl_Position = clip_position(point);
}
