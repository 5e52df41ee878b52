// Contract "cloud_sky", default: no clouds.
//
//   vec4 cloud_sky(vec3 direction)     rgb: radiance that clouds in a direction above the horizon (unit, planet axes)
//   add at the
//                                      camera; a: what they leave of the sky behind. With sky(): a * sky + rgb

vec4 cloud_sky(vec3 direction) {
    return vec4(0.0, 0.0, 0.0, 1.0);
}
