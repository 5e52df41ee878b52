// Contract "air", default: none.
//
//   Air  air(vec3 from, vec3 to)                   what the air between two points does to light on its way to `from`
//   vec3 air_to_space(vec3 from, vec3 direction)   transmittance of the whole ray; 0 where it ends on the planet
//
// Points are camera-relative metres in planet axes (the camera is vec3(0)), directions unit and away from `from`.
// transmittance: per wavelength, 0..1. in_scatter: radiance, W m^-2 sr^-1 nm^-1, the sun's own light included.
// A surface seen by the camera: radiance = surface * air(vec3(0), point).transmittance + air(vec3(0), point).in_scatter.

struct Air {
    vec3 transmittance;
    vec3 in_scatter;
};

Air air(vec3 from, vec3 to) {
    return Air(vec3(1.0), vec3(0.0));
}

vec3 air_to_space(vec3 from, vec3 direction) {
    return vec3(1.0);
}
