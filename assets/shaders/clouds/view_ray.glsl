// The ray of a block of STRIDE x STRIDE pixels of the clouds' picture, and how far it goes. Each of these pixels stands
// for PICTURE_PX x PICTURE_PX of the frame's.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "clouds/intervals.glsl"

layout(binding = CLOUD_DEPTH_UNIT) uniform sampler2D u_depth;
layout(location = 1) uniform ivec2 u_place;   // of the ray's pixel in its block
layout(location = 2) uniform float u_width;   // of what a ray stands for, in pixels of the frame
layout(location = 3) uniform vec2 u_pattern;   // x: its shift in this turn; y: how much of it is left to chance
// of the checkerboard of blocks whose rays are followed: 0 or 1; -1: all
layout(location = 4) uniform int u_checkerboard;
layout(location = 10) uniform vec2 u_inside;   // where the ray goes, from its pixel's middle, in pixels of the frame

struct ViewRay {
    vec3 ray;
    float mu, end, jitter;
};

// The block of a lane's ray: of two in a column the one on such a square.
ivec2 cloud_block_of(ivec2 lane) {
    return u_checkerboard < 0 ? lane : ivec2(lane.x, 2 * lane.y + ((lane.x + u_checkerboard) & 1));
}

// 0..1, of a place alone.
float cloud_hash(uvec2 at) {
    uint h = at.x * 0x9e3779b1u ^ at.y * 0x85ebca77u;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return float(h >> 8) * (1.0 / 16777216.0);
}

// Roberts 2018: neighbours differ as much as they can. What is left of the lattice in a mean over turns would be seen
// as one: by as much as turns lie apart it is left to chance.
float cloud_pattern(ivec2 at) {
    return fract(dot(vec2(at), vec2(0.75487766, 0.56984029)) + u_pattern.y * cloud_hash(uvec2(at)) + u_pattern.x);
}

// Depth beside the pixel's middle, of the surface that is seen there: on a plane it is linear in the picture. Across an
// outline the side that goes on more evenly says how, elsewhere both. offset: in pixels of the clouds' picture.
float depth_beside(ivec2 pixel, float depth, vec2 offset) {
    ivec2 at = clamp(pixel, ivec2(1), textureSize(u_depth, 0) - 2), x = ivec2(1, 0), y = ivec2(0, 1);
    float here = texelFetch(u_depth, at, 0).r;
    vec2 before = here - vec2(texelFetch(u_depth, at - x, 0).r, texelFetch(u_depth, at - y, 0).r);
    vec2 after = vec2(texelFetch(u_depth, at + x, 0).r, texelFetch(u_depth, at + y, 0).r) - here;
    vec2 even = mix(before, after, lessThan(abs(after), abs(before))), mean = 0.5 * (before + after);
    float change = dot(mix(even, mean, lessThan(abs(mean), 2.0 * abs(even))), offset);
    return clamp(depth + change, 0.5 * depth, 2.0 * depth);
}

// Sets pixel_rad and cloud_dither as well.
ViewRay cloud_view_ray(ivec2 at) {
    ivec2 pixel = min(at * STRIDE + u_place, textureSize(u_depth, 0) - 1);
    vec3 ray = view_ray(ndc_of_pixel((vec2(pixel) + 0.5) * float(PICTURE_PX) + u_inside));
    float ray_length = length(ray), depth = texelFetch(u_depth, pixel, 0).r;
    // From far away clouds lie nearer to the ground than that is deep within a pixel.
    if (u_inside != vec2(0.0) && depth > 0.0) depth = depth_beside(pixel, depth, u_inside * (1.0 / float(PICTURE_PX)));
    float end = depth > 0.0 ? forward_distance(depth) * ray_length : UNBOUNDED;
    ray /= ray_length;
    float mu = clamp_cos(dot(ray, frame.camera_zenith));
    vec3 aside = cross(ray, frame.camera_zenith);
    shell_sine2 = dot(aside, aside);
    // The planet itself, where nothing was drawn on it.
    vec2 floor_ = shell_crossings(mu, min(planet.lowest_drawn_m, frame.camera_altitude_m));
    if (depth <= 0.0 && mu < 0.0 && floor_.x < floor_.y && frame.camera_altitude_m > planet.lowest_drawn_m)
        end = min(end, floor_.x);
    pixel_rad = frame.pixel_rad * u_width;
    cloud_dither = cloud_pattern(pixel + ivec2(37, 91));
    return ViewRay(ray, mu, end, cloud_pattern(pixel));
}
