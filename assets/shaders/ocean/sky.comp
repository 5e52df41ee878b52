// Fills the map of the sky that the sea mirrors.
#include "common/camera.glsl"
#include "contract/cloud_sky.glsl"
#include "contract/sky.glsl"
#include "ocean/look/sky_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) writeonly uniform image2D u_sky_out;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    vec3 direction = sky_map_direction(texel);
    vec4 clouds = cloud_sky(direction);
    imageStore(u_sky_out, texel, vec4(clouds.a * sky(direction) + clouds.rgb, 1.0));
}
