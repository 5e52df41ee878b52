// Contract "sky", default: black.
//
//   vec3 sky(vec3 direction)                        radiance that comes from a direction (unit, planet axes) at the
//   camera vec3 sky_irradiance(vec3 point, vec3 normal)    W m^-2 nm^-1 on a surface at a camera-relative point
//
// Scattered light only: neither the sun's disc, nor stars, nor the ground.

vec3 sky(vec3 direction) {
    return vec3(0.0);
}

vec3 sky_irradiance(vec3 point, vec3 normal) {
    return vec3(0.0);
}
