// How many groups look for shafts: all, or none where no map around the camera has any shadow.
#include "generated/bindings.glsl"
layout(local_size_x = 1) in;
layout(std430, binding = CLOUD_SHADED_BUFFER) readonly buffer Shaded { uint shaded[]; };
layout(std430, binding = 1) writeonly buffer Groups { uint groups[]; };
layout(location = 0) uniform ivec2 u_groups;   // across, down
layout(location = 1) uniform int u_map;        // that all in view lies on

void main() {
    uint any_ = shaded[u_map];
    groups[0] = any_ * uint(u_groups.x);
    groups[1] = any_ * uint(u_groups.y);
    groups[2] = 1u;
}
