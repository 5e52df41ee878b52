// Light in the water around the lens, once a frame for all pixels of ocean/under.comp: it is asked for at the camera
// alone.
#include "common/camera.glsl"
#include "contract/air.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "ocean/look/fresnel.glsl"
#include "ocean/look/murk.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = 7) writeonly buffer LensBuffer { vec4 lens[3]; };

const float STARLIGHT = 1.5e-8;   // as in ocean/shade.comp

void main() {
    vec3 zenith = frame.camera_zenith.xyz;
    vec3 sunlight = frame.sun_irradiance.rgb * sun_visibility(vec3(0.0))
        * air_to_space(vec3(0.0), frame.sun_direction.xyz);
    vec3 from_sky = skylight(vec3(0.0), zenith) + frame.sun_irradiance.rgb * STARLIGHT;
    float mirrored = fresnel_outside(max(dot(frame.sun_direction.xyz, zenith), 1e-3), ocean.liquid.x);
    WaterSun sun = water_sun(zenith, sunlight, from_sky, mirrored);
    lens[0] = vec4(sun.to_sun, sun.cosine);
    lens[1] = vec4(sun.direct, 0.0);
    lens[2] = vec4(sun.diffuse, 0.0);
}
