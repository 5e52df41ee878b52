// A small map of the clouds in the sky around the camera, for what mirrors it; a few of its rows a frame.
#include "clouds/weather_march.glsl"
#include "clouds/sky_map.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
uniform int u_first_row;
uniform int u_row_step;   // from one to the next

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.x, u_first_row + u_row_step * int(gl_GlobalInvocationID.y));
    if (any(greaterThanEqual(at, imageSize(o_clouds)))) return;
    vec3 ray = cloud_sky_direction((vec2(at) + 0.5) / vec2(imageSize(o_clouds)));
    float mu = clamp_cos(dot(ray, frame.camera_zenith));
    pixel_rad = 2.0 / float(imageSize(o_clouds).x);
    March m = march_clouds(ray, mu, mu > -0.05 ? UNBOUNDED : 0.0, 0.5);
    imageStore(o_clouds, at, vec4(m.radiance * frame.hdr_per_radiance, m.transmittance));
}
