// Contract "water" (common/water.glsl has the rules): light under the sea, and wet ground along it.
#include "ocean/look/caustics.glsl"
#include "ocean/look/column.glsl"
#include "ocean/look/foam.glsl"
#include "ocean/look/glitter.glsl"
#include "ocean/look/shore.glsl"
#include "contract/sky.glsl"

struct WaterLight {
    vec3 sun, sky;
    vec3 to_sun;
};

WaterLight water_light(vec3 D, vec3 zenith, float height_m, float footprint_m) {
    vec3 sun = frame.sun_direction;
    WaterLight light = WaterLight(vec3(1.0), vec3(1.0), sun);
    float depth = planet.sea_level_m - height_m;
    if (depth > 0.0) {
        float above = max(dot(sun, zenith), 1e-3), below = refracted_cosine(above);
        // On a surface across the beam, of what falls on one across it in air: less wide under water.
        light.sun = water_left(depth / below) * ((1.0 - fresnel_outside(above, ocean.refractive_index)) * above / below
            * water_caustics(D, depth, footprint_m));
        light.sky = water_left(depth / 0.86) * (1.0 - ocean.diffuse_mirrored);
        light.to_sun = normalize((sun - zenith * above) / ocean.refractive_index + zenith * below);
    }
    return light;
}

Shore shore(vec3 D, float height_m, float rise_m, float footprint_m) {
    Shore found = Shore(0.0, 0.0, 0.0, ocean.foam_albedo);
    float above = height_m - planet.sea_level_m;
    if (above >= 0.0 && above < shore_reach()) {
        found = shore_at(D, above, rise_m, footprint_m);
        found.foam = foam_pattern(D, footprint_m, found.foam);
    }
    return found;
}

float water_reach() {
    return planet.sea_level_m + shore_reach();
}

vec4 shore_sheen(Shore shore, vec3 point, vec3 view, vec3 zenith, vec3 normal, vec3 sunlight) {
    vec4 sheen = vec4(0.0);
    if (shore.damp > 0.01) {
        // A sheet lies level; wet sand is water between the grains of the ground.
        vec3 up = normalize(mix(normal, zenith, shore.film));
        mat3 level;
        level[0] = normalize(view - zenith * dot(view, zenith) + 1e-4 * zenith.yzx);
        level[1] = cross(zenith, level[0]);
        level[2] = zenith;
        vec3 n = up * level, v = view * level, l = frame.sun_direction * level;
        float variance = mix(0.03, 0.0012, shore.film);
        Slopes slopes = Slopes(-n.xy / max(n.z, 0.2), vec3(variance, variance, 0.0));
        SlopesSeen seen = slopes_seen(slopes, v);
        float facet, index = ocean.refractive_index;
        float fresnel = fresnel_mean(slopes, seen, v, index, facet);
        vec3 mirrored = reflect(-view, normalize(level * vec3(-facet, -slopes.mean.y, 1.0)));
        mirrored = normalize(mirrored + zenith * max(0.02 - dot(mirrored, zenith), 0.0));
        float share = mix(0.35 * shore.damp, 1.0, shore.film) * (1.0 - shore.foam);
        sheen.rgb = share * (fresnel * sky(mirrored)
            + sunlight * glitter(slopes, seen, v, l, frame.sun_radius_rad, index));
        sheen.a = share * fresnel;
    }
    return sheen;
}
