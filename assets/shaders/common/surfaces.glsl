// What a pixel shows: the values of gbuffer.surface and of the `surface` output; and tiles of the picture.
#include "generated/surfaces.glsl"
#include "generated/tiles.glsl"

// Flag of tiles with a pixel that spans less than NEAR_ACROSS_M at right angles to the view: detail of that size shows
// there.
const uint SURFACE_NEAR = 1u << 31;
const float NEAR_ACROSS_M = 1.6;
// Flag of tiles whose pixels' class is asked of the height function.
const uint SURFACE_ASKED = 1u << 30;
// Flags of tiles of which rivers and lakes have been asked, of those that show any, and of those that show ground that
// is wet from them or has some too narrow for a pixel.
const uint SURFACE_WATER_ASKED = 1u << 29, SURFACE_LAND_WATER = 1u << 28, SURFACE_WATER_ASHORE = 1u << 27;
