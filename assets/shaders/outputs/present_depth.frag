// The picture with its depth as a host's depth buffer stores it. GL's depth test, which the host's objects pass as
// well, decides who is seen.
#include "generated/frame.glsl"

layout(binding = 0) uniform sampler2D u_picture;
layout(binding = 1) uniform sampler2D u_depth;
layout(location = 0) uniform vec2 u_host_depth;  // window depth = x + y / z
in vec2 v_uv;
layout(location = 0) out vec4 o_color;

void main() {
    o_color = vec4(texture(u_picture, v_uv).rgb, 1.0);
    // Ours is near / z: 0 for the sky, whose depth is then that of infinity, or of the host's far plane before it.
    float per_z = textureLod(u_depth, v_uv, 0.0).r / frame.near_m;
    gl_FragDepth = clamp(u_host_depth.x + u_host_depth.y * per_z, 0.0, 1.0);
}
