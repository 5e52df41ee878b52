// Contract "sky" (common/sky.glsl has the rules) for a probe's questions: what falls on surfaces and clouds.
#include "common/camera.glsl"
#include "atmosphere/irradiance.glsl"
#include "contract/air.glsl"

vec3 sky(vec3 direction) {
    return air_from_camera(direction * 1e9).in_scatter;
}

#include "atmosphere/on_surface.glsl"
