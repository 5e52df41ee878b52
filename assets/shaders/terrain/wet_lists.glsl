// Tiles with ground in eight lists, each behind its indirect dispatch: number 1 for those with a pixel that water
// changes, plus 2 for near ones, plus 4 for those in which crowns of a forest may show.
#include "generated/bindings.glsl"
layout(std430, binding = SORTED_TILES_BUFFER) buffer SortedBuffer { uint sorted[]; };
uniform int u_stride;   // words of a list
