// What a pixel shows: the values of gbuffer.surface and of the `surface` output.
const uint SURFACE_NONE = 0u;
const uint SURFACE_TERRAIN = 1u;
const uint SURFACE_SEA = 2u;
const uint SURFACE_PROPS = 3u;
