// Pixels whose height is to be asked, behind the indirect dispatch that asks. With COAST_SECOND also those that become
// land, and tiles that are added (terrain/coast_grow.comp).
#include "generated/bindings.glsl"
layout(std430, binding = COAST_LIST_BUFFER) buffer CoastList {
    uint groups[3];
    uint count;
    uint pixels[];   // x | y << 16
} coast_list;
#ifdef COAST_SECOND
layout(std430, binding = COAST_LAND_BUFFER) buffer CoastLand {
    uint groups[3];
    uint count;
    uint pixels[];
} coast_land;
layout(std430, binding = COAST_MORE_BUFFER) buffer CoastMore {
    uint groups[4];
    uint tiles[];
} coast_more;
#endif

const uint COAST_GROUP = 64u;
// Heights have all layers down to an eighth of this: what is shorter than 1.5 pixels would only make dots of them.
const float COAST_FINEST_PX = 12.0;

ivec2 coast_listed(uint place) {
    return ivec2(place & 0xffffu, place >> 16);
}
