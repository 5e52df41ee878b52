// Contract "skylight", default: the clear sky's light.
//
//   vec3 skylight(vec3 point, vec3 normal)     W m^-2 nm^-1 on a surface at a camera-relative point (planet axes), from
//   the
//                                              whole sky with its clouds, without the sun's own beam
//
// Goes with sun_visibility, which has the beam: what clouds scatter out of it comes from here.
#include "contract/sky.glsl"

vec3 skylight(vec3 point, vec3 normal) {
    return sky_irradiance(point, normal);
}
