// The colour map around the planet, on the faces of a cube (systems/terrain/height_map.py): linear between samples and
// levels, by texelFetch, so that faces meet without a seam.
#include "generated/bindings.glsl"
#include "generated/terrain_table.glsl"
#include "common/cube_atlas.glsl"

#ifdef TERRAIN_PICTURED
layout(binding = COLOR_MAP_UNIT) uniform usampler2D u_terrain_colors;   // tiles, for terrain/real_colors.glsl
#else
layout(binding = COLOR_MAP_UNIT) uniform sampler2D u_terrain_color;  // square roots of albedos

vec3 terrain_color_level(vec3 d, int cells, int level) {
    int face, n = cells >> level;
    vec2 at = (cube_face(d, face).xy * 0.5 + 0.5) * float(n), cell = clamp(floor(at), 0.0, float(n - 1)), f = at - cell;
    ivec2 corner = cube_corner(face, cells, level) + ivec2(cell) + 1;
    vec3 c00 = texelFetch(u_terrain_color, corner, 0).rgb,
        c10 = texelFetch(u_terrain_color, corner + ivec2(1, 0), 0).rgb;
    vec3 c01 = texelFetch(u_terrain_color, corner + ivec2(0, 1), 0).rgb,
        c11 = texelFetch(u_terrain_color, corner + 1, 0).rgb;
    return mix(mix(c00 * c00, c10 * c10, f.x), mix(c01 * c01, c11 * c11, f.x), f.y);
}

// Albedo at the direction d as a footprint in radians shows it.
vec3 terrain_color(vec3 d, TerrainColorMap map, float footprint_rad) {
    float level = clamp(log2(max(0.5 * footprint_rad * float(map.cells), 1e-9)), 0.0, float(map.levels - 1));
    int low = int(level), high = min(low + 1, map.levels - 1);
    return mix(terrain_color_level(d, map.cells, low), terrain_color_level(d, map.cells, high), level - float(low));
}
#endif
