// Waves that are long on a tile of 16 x 8 pixels: their slopes at 4 x 4 nodes of a rectangle of the calm sea that holds
// what the tile shows. Between the nodes cubic polynomials hold them: the nodes are Chebyshev's, and at a wave number k
// and half a side h the error is at most (k h)^4 / 192 of a wave's slope.
struct SwellTile {
    vec2 centre_m;        // of the rectangle, as SeaPlace.at
    vec2 axis;            // its first one, unit
    vec2 per_half_side;   // 1/m, along the first and the second axis
    int feels;            // far waves that feel the bed,
    int held;             // and with them those that the nodes hold
    vec3 hidden;          // slope variance of the waves that the nodes hold
    // 16 x (slope of the height along east, north; of the sideways movement ee, nn, en), without gaps
    vec4 nodes[20];
};
const vec4 SWELL_NODES = vec4(-0.923879533, -0.382683432, 0.382683432, 0.923879533);
