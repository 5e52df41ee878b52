// Waves that are long on a tile: their slopes at 4 x 4 nodes of a rectangle of the calm sea that holds
// what the tile shows. Between the nodes cubic polynomials hold them: the nodes are Chebyshev's, and at a wave number k
// and half a side h the error is at most (k h)^4 / 192 of a wave's slope.
#include "generated/swell_tile.glsl"

const vec4 SWELL_NODES = vec4(-0.923879533, -0.382683432, 0.382683432, 0.923879533);
