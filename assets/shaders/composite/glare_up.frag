// One step up in size, added to the octave there.
#include "composite/tent.glsl"

layout(binding = 0) uniform sampler2D u_from;
layout(location = 0) uniform float u_share;  // of this octave and all blunter ones
in vec2 v_uv;
layout(location = 0) out vec4 o_light;

void main() {
    o_light = vec4(u_share * tent_at(u_from, v_uv), 0.0);
}
