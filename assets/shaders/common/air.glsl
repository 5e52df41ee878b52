// Contract "air", default: none.
//
//   Air  air_from_camera(vec3 to)                  what the air between the camera and a point does to light on its way
//   Air  air(vec3 from, vec3 to)                   the same between two points of one ray from the camera, `from`
//   nearer vec3 air_to_space(vec3 from, vec3 direction)   transmittance of the whole ray. Below the horizon it is the
//   horizon's:
//                                                  what the planet hides is not the air's business (sun_visibility,
//                                                  depth)
//
// Points are camera-relative metres in planet axes (the camera is vec3(0)), directions unit and away from `from`.
// transmittance: per wavelength, 0..1. in_scatter: radiance, W m^-2 sr^-1 nm^-1, the sun's own light included.
// A surface seen by the camera: radiance = surface * air_from_camera(point).transmittance + its in_scatter.

struct Air {
    vec3 transmittance;
    vec3 in_scatter;
};

Air air_from_camera(vec3 to) {
    return Air(vec3(1.0), vec3(0.0));
}

Air air(vec3 from, vec3 to) {
    return Air(vec3(1.0), vec3(0.0));
}

vec3 air_to_space(vec3 from, vec3 direction) {
    return vec3(1.0);
}
