// Optical depth to space: one invocation a texel, composite Gauss rule along its path.
#include "atmosphere/medium.glsl"

layout(local_size_x = 16, local_size_y = 4) in;
layout(rgba32f, binding = 0) writeonly uniform image2D u_depth_image;

layout(location = 0) uniform ivec2 u_rows;   // the first, and the one after the last

const int SEGMENTS = DEPTH_SEGMENTS;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, u_rows.x), size = imageSize(u_depth_image);
    if (texel.x >= size.x || texel.y >= min(u_rows.y, size.y)) return;
    vec2 at = vec2(texel) / vec2(size - 1);
    float h = at.y * at.y * air_model.thickness_m;
    float horizon2 = air_horizon2(h), least = air_model.thickness_m - h;
    float path = least + (sqrt(horizon2) + air_model.longest_path_m - least) * air_path_share(at.x, 1.0);
    float r = air_model.radius_m + h;
    float c = least * (air_model.top_radius_m + r);
    float mu = clamp((c - path * path) / max(2.0 * r * path, 1e-20), -1.0, 1.0);
    // Dense where the air is: from the lowest point of the path outwards, by squares.
    float lowest = clamp(-r * mu, 0.0, path);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < SEGMENTS; ++i) {
        for (int k = 0; k < 3; ++k) {
            float node = 0.5 + float(k - 1) * 0.387298335;
            float weight = (k == 1 ? 4.0 / 9.0 : 5.0 / 18.0) / float(SEGMENTS);
            float y = (float(i) + node) / float(SEGMENTS);
            float far = lowest + (path - lowest) * y * y, near = lowest * (1.0 - y * y);
            vec3 above = air_extinction(air_density(air_height_along(h, mu, far)));
            vec3 below = air_extinction(air_density(air_height_along(h, mu, near)));
            sum += 2.0 * y * weight * ((path - lowest) * above + lowest * below);
        }
    }
    vec3 mean = path > 0.0 ? sum / path : air_extinction(air_density(h));
    imageStore(u_depth_image, texel, vec4(air_pack(mean), 0.0));
}
