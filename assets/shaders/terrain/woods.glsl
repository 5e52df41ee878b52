// Where a vector map lets woods stand, as a share of the pixel: systems/terrain/woods_map.py.
#include "generated/bindings.glsl"
#include "generated/terrain_table.glsl"
#include "terrain/real_lattice.glsl"

layout(binding = WOODS_UNIT) uniform sampler2D u_woods;

// D: the foot on the reference sphere minus the anchor's. 1 beyond the map's bounds.
float terrain_wooded(vec3 D, float footprint_m) {
    TerrainWoods woods = terrain_table.woods;
    float radius_m = terrain_table.radius_m;
    // Angles from the anchor, as sines of differences: none of the anchor's own is lost to rounding.
    vec3 c = terrain_table.up * radius_m, p = c + D;
    float flat_c = length(c.xy), flat_p = length(p.xy);
    float out_m = (2.0 * dot(c.xy, D.xy) + dot(D.xy, D.xy)) / max(flat_c + flat_p, 1e-20);
    // A pole's longitude is 0, as woods_map.py has it.
    vec2 meridian = flat_c > 0.0 ? c.xy : vec2(1.0, 0.0);
    float east = real_angle(meridian.x * D.y - meridian.y * D.x, dot(meridian, p.xy) + 1e-20);
    float north = real_angle(D.z * flat_c - c.z * out_m, c.z * p.z + flat_c * flat_p);
    vec2 at = woods.place + vec2(east, -north) / woods.texel_rad, size = vec2(woods.size);
    // Maps may go on around the world from where the anchor is.
    float turn = 2.0 * REAL_PI / woods.texel_rad.x;
    at.x += at.x < 0.0 ? turn : at.x > size.x ? -turn : 0.0;
    if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, size))) return 1.0;
    // By the narrower side: the wider one shows too little rather than the other flickers; but near the poles.
    vec2 texel_m = vec2(woods.texel_rad.x * flat_p, woods.texel_rad.y * radius_m);
    float narrow_m = max(min(texel_m.x, texel_m.y), 0.125 * max(texel_m.x, texel_m.y));
    return textureLod(u_woods, at / size, max(log2(footprint_m / narrow_m), 0.0)).r;
}
