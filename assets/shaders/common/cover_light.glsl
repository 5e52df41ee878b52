// Contract "cover_light", default: nothing stands on the ground.
//
//   float cover_light(vec3 point, float bias)     point: camera-relative metres, planet axes. Share of the sun that
//                                                 trees leave to it, 0 .. 1. bias: metres towards the sun, left out
//   vec3  cover_map.broadleaf, cover_map.conifer  albedos of their leaves
//   vec4  cover_map.north, cover_map.south        where they shed them: albedo, share of crowns that hides
//   float cover_map.crowns                        area of all crowns of a deep forest of broadleaves over its ground's
//
// and what else generated/cover_map.glsl has of the look of trees and grass: shaders that are made for trees have to
// compile while these are taken off.

struct CoverMap {
    vec3 broadleaf, conifer;
    vec4 north, south, snow;
    float crowns, tall_m, wide_m, octave, grass, grass_tall, flowers, savanna, variety, gusting,
        flutter;
    vec2 winter;
    vec3 sway;
    vec4 gusts[3];
};
const CoverMap cover_map = CoverMap(vec3(0.0), vec3(0.0), vec4(0.0), vec4(0.0), vec4(0.0), 0.0, 1.0, 1.0, 0.0, 0.0,
    1.0, 0.0, 0.0, 0.0, 0.0, 0.0, vec2(0.0), vec3(0.0), vec4[3](vec4(0.0), vec4(0.0), vec4(0.0)));

float cover_light(vec3 point, float bias) {
    return 1.0;
}
