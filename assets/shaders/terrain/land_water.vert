// A rectangle for each tile of the picture that shows a river or a lake; the others have no area.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"
#include "generated/frame.glsl"

layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
uniform int u_across;

void main() {
    ivec2 tile = ivec2(gl_InstanceID % u_across, gl_InstanceID / u_across);
    ivec2 corner = tile + (gl_VertexID == 0 || gl_VertexID == 3 ? ivec2(0) : gl_VertexID == 1 ? ivec2(1, 0)
        : gl_VertexID == 2 || gl_VertexID == 4 ? ivec2(1) : ivec2(0, 1));
    bool shown = (flags[gl_InstanceID] & SURFACE_LAND_WATER) != 0u;
    vec2 ndc = vec2((shown ? corner : tile) * TILE_PX) * frame.texel_size * 2.0 - 1.0;
    gl_Position = vec4(ndc, 0.5, 1.0);
}
