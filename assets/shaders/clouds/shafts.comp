// Light that the air does not scatter because clouds keep the sun from it: taken from what each ray of the clouds adds to the
// picture, whose air is lit as if there were none. What is left of the air's light is between shafts.
//
// Only light that would be scattered once is in clouds' shadow; what has been scattered before comes from all sides.
#include "clouds/view_ray.glsl"
#include "clouds/sun_depth.glsl"
#include "clouds/shadowed_air.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba32f) uniform image2D u_rays;
layout(binding = 1, r32f) uniform image2D u_distance;
layout(location = 4) uniform vec3 u_shafts;   // steps; how much of the shadow counts; the first step is about this long in metres

const float CLEAR = 1e-3;

float cloud_sun_left(vec3 point, float altitude, float mu_s, float wide_m) {
    return cloud_sunlight(point, altitude, mu_s, wide_m).x;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(u_rays)))) return;
    ViewRay v = cloud_view_ray(at);
    vec4 clouds = imageLoad(u_rays, at);
    ShadowedAir air = shadowed_air(v.ray, v.mu, v.end, imageLoad(u_distance, at).r, clouds.a, int(u_shafts.x), u_shafts.z, v.shift);
    for (int once = air.any ? 0 : 1; once < 1; ++once) {
        imageStore(u_rays, at, vec4(clouds.rgb - air.light * (u_shafts.y * frame.scale.x), clouds.a));
        // Where there is nothing else to follow from frame to frame, the shafts are.
        if (1.0 - clouds.a < CLEAR) imageStore(u_distance, at, vec4(air.distance));
    }
}
