// Contract "cloud_shadow", default: no clouds.
//
//   float cloud_shadow(vec3 point)     point: camera-relative metres, planet axes. Share of the sunlight there that
//   comes through
//                                      the clouds as a beam. What they scatter is skylight (contract "skylight")
//
// Part of sun_visibility: whoever provides that multiplies this in.

float cloud_shadow(vec3 point) {
    return 1.0;
}
