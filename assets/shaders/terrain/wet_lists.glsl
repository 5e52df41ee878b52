// Tiles with ground, the distant and the near ones apart: dry ones and those with a pixel that water changes.
layout(std430, binding = 2) buffer DryBuffer { uint groups[4]; uint tiles[]; } dry_list;
layout(std430, binding = 3) buffer WetBuffer { uint groups[4]; uint tiles[]; } wet_list;
layout(std430, binding = 5) buffer NearDryBuffer { uint groups[4]; uint tiles[]; } near_dry_list;
layout(std430, binding = 6) buffer NearWetBuffer { uint groups[4]; uint tiles[]; } near_wet_list;
