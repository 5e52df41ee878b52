// Pixels of rivers and lakes into the G-buffer, as terrain/land_water.comp found them: the surface of their water, as
// the sea has it.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"

layout(binding = LAND_WATER_UNIT) uniform usampler2D u_land_water;
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;
layout(location = 2) out uint o_surface;

void main() {
    uvec4 found = texelFetch(u_land_water, ivec2(gl_FragCoord.xy), 0);
    if (found.x == 0u) discard;
    o_normal = unpackSnorm2x16(found.y);
    o_attributes = unpackUnorm4x8(found.z);
    o_surface = SURFACE_SEA;
    gl_FragDepth = uintBitsToFloat(found.x);
}
