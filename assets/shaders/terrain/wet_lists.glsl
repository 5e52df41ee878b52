// Tiles with ground, the distant and the near ones apart: dry ones and those with a pixel that water changes.
#include "generated/bindings.glsl"
layout(std430, binding = DRY_BUFFER) buffer DryBuffer { uint groups[4]; uint tiles[]; } dry_list;
layout(std430, binding = WET_BUFFER) buffer WetBuffer { uint groups[4]; uint tiles[]; } wet_list;
layout(std430, binding = NEAR_DRY_BUFFER) buffer NearDryBuffer { uint groups[4]; uint tiles[]; } near_dry_list;
layout(std430, binding = NEAR_WET_BUFFER) buffer NearWetBuffer { uint groups[4]; uint tiles[]; } near_wet_list;
