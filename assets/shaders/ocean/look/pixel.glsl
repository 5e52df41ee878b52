// What is known of the sea at a pixel before any light falls on it.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "ocean/look/noise.glsl"
#include "ocean/look/slopes.glsl"
#include "ocean/waves.glsl"

struct SeaPixel {
    vec3 point;          // from the camera
    vec3 view;           // unit, to the eye
    float distance_m;
    float footprint_m;   // what a pixel covers, across the view
    vec3 zenith;
    mat3 level;          // columns: east and north of sea_place, the zenith: the frame of slopes
    Slopes slopes;
    float fold;          // 1: calm water, towards 0 where a wave's crest is squeezed
    float depth_m;       // of still water below
    float height_m;      // over the reference sphere
    vec3 D;              // foot offset of the undisturbed place
};

vec2 sea_slope_of(vec3 normal, mat3 level) {
    vec3 n = normal * level;
    return -n.xy / max(n.z, 0.05);
}

vec3 sea_normal_of(vec2 slope, mat3 level) {
    return normalize(level * vec3(-slope, 1.0));
}

// rough: variances along east and north, mixed, Jacobian.
SeaPixel sea_pixel(vec3 point, vec3 normal, float depth_m, vec4 rough) {
    SeaPixel p;
    p.point = point;
    p.distance_m = length(point);
    p.view = -point / p.distance_m;
    p.footprint_m = p.distance_m * frame.pixel_rad;
    p.D = foot_offset_of(point, p.height_m);
    SeaPlace place = sea_place(p.D);
    p.zenith = place.zenith;
    p.level = mat3(place.east, place.north, place.zenith);
    p.depth_m = depth_m;
    p.slopes.mean = sea_slope_of(normal, p.level);
    p.slopes.variance = rough.xyz + ocean.roughness * ocean.roughness * vec3(0.5, 0.5, 0.0);
    p.fold = rough.w;
    return p;
}
