// Contract "water", default: none.
//
//   WaterLight water_light(vec3 D, vec3 zenith, float height_m, float footprint_m)
//       what the water above a point of the ground leaves of its light
//   Shore shore(vec3 D, float height_m, float rise_m, float footprint_m)
//       how wet the ground is. rise_m: how much of its height a pixel covers
//   vec4 shore_sheen(Shore shore, vec3 point, vec3 view, vec3 zenith, vec3 normal, vec3 sunlight)
//       rgb: radiance that the sheet of water and wet ground mirror; w: share of light that does not reach the ground
//
//   float water_reach()
//       height from which on neither of them changes anything
//
// D: foot offset; height_m: above the reference sphere.

struct WaterLight {
    vec3 sun, sky;   // shares that arrive
    vec3 to_sun;     // where the sun's light comes from, refracted
};

struct Shore {
    float foam;    // share of the surface that foam covers, its pattern included
    float film;    // 0..1: a sheet of water lies on the ground
    float damp;    // 0..1: the ground is wet
    vec3 foam_albedo;
};

WaterLight water_light(vec3 D, vec3 zenith, float height_m, float footprint_m) {
    return WaterLight(vec3(1.0), vec3(1.0), frame.sun_direction);
}

Shore shore(vec3 D, float height_m, float rise_m, float footprint_m) {
    return Shore(0.0, 0.0, 0.0, vec3(0.0));
}

vec4 shore_sheen(Shore shore, vec3 point, vec3 view, vec3 zenith, vec3 normal, vec3 sunlight) {
    return vec4(0.0);
}

float water_reach() {
    return -3.0e38;
}
