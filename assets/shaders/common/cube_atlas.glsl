// Cube maps as engine/surface/cube_map.py lays them out in one picture: a level's six faces in two rows of three, (n +
// 3)^2 samples each, level below level. No hardware filter: it has 8 bits for its weights, and no faces.

// Where a direction meets the cube: the face, and (s, t, component along its normal).
vec3 cube_face(vec3 d, out int face) {
    vec3 a = abs(d);
    bool side = a.x >= a.y && a.x >= a.z, other = !side && a.y >= a.z;
    face = side ? (d.x > 0.0 ? 0 : 2) : other ? (d.y > 0.0 ? 1 : 3) : (d.z > 0.0 ? 4 : 5);
    vec3 p = side ? vec3(d.x > 0.0 ? d.y : -d.y, d.z, a.x)
        : other ? vec3(d.y > 0.0 ? -d.x : d.x, d.z, a.y) : vec3(d.y, d.z > 0.0 ? -d.x : d.x, a.z);
    return vec3(p.xy / p.z, p.z);
}

// A vector's components along a face's columns, its rows and its normal.
vec3 cube_axes(int face, vec3 v) {
    return face == 0 ? v.yzx : face == 1 ? vec3(-v.x, v.z, v.y) : face == 2 ? vec3(-v.y, v.z, -v.x)
        : face == 3 ? vec3(v.x, v.z, -v.y) : face == 4 ? vec3(v.y, -v.x, v.z) : vec3(v.y, v.x, -v.z);
}

// A gradient by (s, t), as a vector: of a field that depends on the direction of d only, by d.
vec3 cube_gradient(int face, vec3 place, vec2 by_place) {
    float along = -dot(by_place, place.xy);
    vec3 g = face == 0 ? vec3(along, by_place.x, by_place.y) : face == 1 ? vec3(-by_place.x, along, by_place.y)
        : face == 2 ? vec3(-along, -by_place.x, by_place.y) : face == 3 ? vec3(by_place.x, -along, by_place.y)
        : face == 4 ? vec3(-by_place.y, by_place.x, along) : vec3(by_place.y, by_place.x, -along);
    return g / place.z;
}

// Corner of a face's samples in the picture, its border included. n: of the finest level.
ivec2 cube_corner(int face, int n, int level) {
    int size = (n >> level) + 3;
    return ivec2((face % 3) * size, 4 * (n - (n >> level)) + 6 * level + (face / 3) * size);
}
