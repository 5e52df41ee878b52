// Contract "air" (common/air.glsl has the rules), from the camera's tables.
#include "atmosphere/camera_air.glsl"
#include "atmosphere/sunlight.glsl"

struct Air {
    vec3 transmittance;
    vec3 in_scatter;
};

Air air_from_camera(vec3 to) {
    float distance_m = length(to);
    AirRay ray = air_ray(to / max(distance_m, 1e-20));
    Air between;
    vec3 first, second;
    float path;
    air_between(air_view.camera, ray, distance_m, between.transmittance, first, second, path);
    between.in_scatter = air_radiance(ray, first, second, path);
    return between;
}

Air air(vec3 from, vec3 to) {
    Air near = air_from_camera(from), far = air_from_camera(to);
    vec3 to_near = max(near.transmittance, 1e-20);
    return Air(min(far.transmittance / to_near, 1.0), max((far.in_scatter - near.in_scatter) / to_near, 0.0));
}

#include "atmosphere/to_space.glsl"
