// Light in the water around the lens, once a frame for all pixels of ocean/under.comp: it is asked for at the camera
// alone.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "contract/air.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "ocean/look/fresnel.glsl"
#include "ocean/look/murk.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = LENS_BUFFER) writeonly buffer LensBuffer { WaterSun lens; };

const float STARLIGHT = 1.5e-8;   // as in ocean/shade.comp

void main() {
    vec3 zenith = frame.camera_zenith;
    vec3 sunlight = frame.sun_irradiance * sun_visibility(vec3(0.0))
        * air_to_space(vec3(0.0), frame.sun_direction);
    vec3 from_sky = skylight(vec3(0.0), zenith) + frame.sun_irradiance * STARLIGHT;
    float mirrored = fresnel_outside(max(dot(frame.sun_direction, zenith), 1e-3), ocean.refractive_index);
    lens = water_sun(zenith, sunlight, from_sky, mirrored);
}
