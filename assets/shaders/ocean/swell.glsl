// Waves that are long on a tile of 16 x 8 pixels: their slopes at 4 x 4 nodes of a rectangle of the calm sea that holds
// what the tile shows. Between the nodes cubic polynomials hold them: the nodes are Chebyshev's, and at a wave number k
// and half a side h the error is at most (k h)^4 / 192 of a wave's slope.
struct SwellTile {
    vec4 place;        // centre of the rectangle in metres of SeaPlace.at; its first axis, unit
    // 1 / half its sides along the first and second axis; waves of the first list that feel the bed, and those that
    vec4 size;
                       // the nodes hold with them
    vec4 hidden;       // slope variance of the waves that the nodes hold
    vec4 nodes[20];    // 16 x (slope of the height along east, north; of the sideways movement ee, nn, en)
};
const vec4 SWELL_NODES = vec4(-0.923879533, -0.382683432, 0.382683432, 0.923879533);
