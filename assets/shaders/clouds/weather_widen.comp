// A coarse map of the weather on the texels of a fine one.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D u_coarse;
layout(binding = 0, rgba8) uniform writeonly image2D o_weather;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(o_weather);
    if (any(greaterThanEqual(at, size))) return;
    imageStore(o_weather, at, textureLod(u_coarse, (vec2(at) + 0.5) / vec2(size), 0.0));
}
