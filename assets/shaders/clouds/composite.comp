// Clouds over the picture, and the light that the air in their shadow doesn't scatter off it.
layout(local_size_x = 16, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 0, SCENE_FORMAT) uniform image2D u_radiance;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(u_clouds, 0)))) return;
    vec4 found = texelFetch(u_clouds, pixel, 0), seen = imageLoad(u_radiance, pixel);
    // Shafts are smooth and what lies behind is not: at an edge there may be less light than they take.
    imageStore(u_radiance, pixel, vec4(max(seen.rgb * found.a + found.rgb, 0.0), seen.a));
}
