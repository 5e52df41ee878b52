// Where the ground in a pixel lies: for passes over its tiles (common/surface_tiles.glsl). v_ndc is set first.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "contract/vertex_spacing.glsl"

#ifndef GROUND_BLUR
#define GROUND_BLUR 0.5
#endif

vec2 v_ndc;   // of the pixel at hand

// Chosen by eye.
const float DETAIL_PX = 0.85;      // pixels that detail is averaged over: less flickers, more blurs
const float FLATTEST_SINE = 0.03;  // of the view above the ground: what a pixel covers grows no longer below it
// Sagittas of the vertices' triangles between which the height goes over from what is drawn to what vertices carry.
const vec2 CODED_FROM_M = vec2(2.0, 20.0);
const vec3 WETTED = vec3(0.52, 0.5, 0.47);   // albedo of wet ground, as shares of the dry one

// The ground in a pixel. Lengths in metres, directions of unit length.
struct Spot {
    vec3 point;             // where it is drawn, from the camera
    vec3 place;             // where its light goes through the air
    vec3 D;                 // its foot offset
    vec3 zenith, view;      // up; to the camera
    vec3 coarse;            // the vertices' normal
    float distance_m, height_m;
    float to_sphere;        // slopes on the ground per slope on the sphere
    float across_m;         // a pixel at right angles to the view
    float footprint_m;      // what of the ground it covers
    float spacing_m;        // of the vertices
};

Spot spot_at(ivec2 pixel, vec4 attributes) {
    Spot s;
    s.point = position_from_depth(v_ndc, texel_at(u_depth, pixel).r);
    float drawn_m;
    s.D = foot_offset_of(s.point, drawn_m);
    s.zenith = up_at(s.point);
    s.distance_m = length(s.point);
    s.view = -s.point / s.distance_m;
    s.coarse = oct_decode(texel_at(u_normal, pixel).rg);
    // Wider along the view at flat angles. GROUND_BLUR 1/2 is the geometric mean; less keeps detail sharp across the
    // view and leaves it to the samples of anti-aliasing to average along it.
    s.across_m = s.distance_m * frame.pixel_rad * (SHADE_EVERY == 4 ? 2.0 : 1.0);
    s.footprint_m = DETAIL_PX * s.across_m * pow(clamp(dot(s.coarse, s.view), FLATTEST_SINE, 1.0), -GROUND_BLUR);
    s.spacing_m = vertex_spacing(s.D, attributes.w);
    s.to_sphere = planet.radius_m / (planet.radius_m + drawn_m);

    float sagitta_m = s.spacing_m * s.spacing_m / (8.0 * planet.radius_m);
    float coded_m = mix(planet.lowest_m, planet.highest_m, attributes.z);
    float coded = attributes.z > 0.0 ? smoothstep(CODED_FROM_M.x, CODED_FROM_M.y, sagitta_m) : 0.0;
    s.height_m = mix(drawn_m, coded_m, coded);
    // in the air: between their corners far triangles lie deep under the ground
    s.place = s.point + s.zenith * (s.height_m - drawn_m);
    return s;
}
