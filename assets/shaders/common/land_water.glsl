// Contract "land_water", default: no rivers and no lakes, nothing to compile for them.
//
//   LAND_WATER                           is defined where there are any. Their pixels are the sea's in the G-buffer;
//                                        gbuffer.attributes.z says more of them, 0 for the sea itself:
//   bool land_water_at(float code)       whether a pixel shows any
//   vec2 land_water_decode(float code)   how stirred and how muddy its water is, 0..1
//   float land_water_white(float stirred)   share of white water in the mean
//   float land_water_silt(float muddy)      how much silt that is, as a share of the most
