// For the debug view of tiles: which lists each tile is in.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"

layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
layout(location = 0) uniform int u_across;
layout(location = 0) out vec4 o_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), tile = pixel / TILE_PX, inside = pixel % TILE_PX;
    uint found = flags[tile.y * u_across + tile.x];
    bool ground = (found & 1u << SURFACE_TERRAIN) != 0u, sea = (found & 1u << SURFACE_SEA) != 0u;
    vec3 color = ground && sea ? vec3(0.90, 0.45, 0.15) : ground ? vec3(0.20, 0.45, 0.20) : sea ? vec3(0.12, 0.30, 0.70)
        : vec3(0.06);
    // Near ground is shaded with details that far ground does without.
    if (ground && (found & SURFACE_NEAR) != 0u) color += vec3(0.25, 0.30, 0.10);
    if ((found & 1u << SURFACE_PROPS) != 0u) color = mix(color, vec3(0.85, 0.20, 0.60), 0.6);
    bool edge = inside.x == 0 || inside.y == 0;
    o_color = vec4(edge ? 0.6 * color : color, 1.0);
}
