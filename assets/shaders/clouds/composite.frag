// Clouds over the picture, and the light that the air in their shadow doesn't scatter off it. What is drawn into is read as well,
// each pixel by itself alone.
//
// Define PICTURE_PX: a pixel of the clouds' picture has so many of the frame's a side. Between those of a coarser picture clouds
// are interpolated; those that end at this pixel's own surface count most.
layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 1) uniform sampler2D u_radiance;
#if PICTURE_PX > 1
layout(binding = 2) uniform sampler2D u_depth;
layout(binding = 3) uniform sampler2D u_surface;   // depth up to which clouds were followed
#endif
layout(location = 0) out vec4 o_radiance;

const float LEFT = 0.2;   // of the light behind

vec4 clouds_of(ivec2 pixel) {
#if PICTURE_PX > 1
    vec2 at = (vec2(pixel) + 0.5) / float(PICTURE_PX) - 0.5, first = floor(at), share = at - first, rest = 1.0 - share;
    ivec2 most = textureSize(u_clouds, 0) - 1;
    vec4 weight = vec4(rest.x * rest.y, share.x * rest.y, rest.x * share.y, share.x * share.y), found[4];
    for (int i = 0; i < 4; ++i) found[i] = texelFetch(u_clouds, clamp(ivec2(first) + ivec2(i & 1, i >> 1), ivec2(0), most), 0);
    // In the order of the others; it clamps as they do.
    vec4 ends = textureGather(u_surface, (first + 1.0) / vec2(most + 1)).wzxy;
    // Depth is near / distance: its ratio is that of the distances.
    float depth = textureLod(u_depth, gl_FragCoord.xy / vec2(textureSize(u_depth, 0)), 0.0).r;
    vec4 unlike = abs(depth - ends) / max(max(vec4(depth), ends), 1e-20);
    weight = (weight + 1e-3) / (1e-3 + unlike * unlike);
    weight /= weight.x + weight.y + weight.z + weight.w;
    return weight.x * found[0] + weight.y * found[1] + weight.z * found[2] + weight.w * found[3];
#else
    return texelFetch(u_clouds, pixel, 0);
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 found = clouds_of(pixel), seen = textureLod(u_radiance, gl_FragCoord.xy / vec2(textureSize(u_radiance, 0)), 0.0);
    // Shafts are smooth and what lies behind is not: along an outline a ray to the sky may take more than a pixel of near ground
    // has of the air's light. So much less is taken of all colours that some of each is left.
    vec3 behind = max(seen.rgb * found.a, 0.0), taken = max(-found.rgb, 0.0), share = (1.0 - LEFT) * behind / max(taken, 1e-30);
    float most = min(min(share.r, min(share.g, share.b)), 1.0);
    o_radiance = vec4(behind + max(found.rgb, 0.0) - most * taken, seen.a);
}
