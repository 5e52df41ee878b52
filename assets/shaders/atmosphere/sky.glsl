// Contract "sky" (common/sky.glsl has the rules), from the camera's tables and the table of irradiance.
#include "atmosphere/camera_air.glsl"
#include "atmosphere/irradiance.glsl"

vec3 sky(vec3 direction) {
    AirRay ray = air_ray(direction);
    vec3 first, second;
    float path;
    air_open(air_view.camera, ray, first, second, path);
    return air_radiance(ray, first, second, path);
}

#include "atmosphere/on_surface.glsl"
