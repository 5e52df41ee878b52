// Contract "cover_light", default: nothing stands on the ground.
//
//   struct CoverMap {
    vec3 leaves;
};
const CoverMap cover_map = CoverMap(vec3(0.0));

float cover_light(vec3 point, float bias)     point: camera-relative metres, planet axes. Share of the sun that trees
//                                                 leave to it, 0 .. 1. bias: metres towards the sun that are left out
//   vec3  cover_map.leaves                        mean albedo of their leaves

struct CoverMap {
    vec3 leaves;
};
const CoverMap cover_map = CoverMap(vec3(0.0));

float cover_light(vec3 point, float bias) {
    return 1.0;
}
