// Clouds over the picture, and the light that the air in their shadow doesn't scatter off it. What is drawn into is read as well,
// each pixel by itself alone.
layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 1) uniform sampler2D u_radiance;
layout(location = 0) out vec4 o_radiance;

const float LEFT = 0.2;   // of the light behind

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 found = texelFetch(u_clouds, pixel, 0), seen = texelFetch(u_radiance, pixel, 0);
    // Shafts are smooth and what lies behind is not: along an outline a ray to the sky may take more than a pixel of near ground
    // has of the air's light. So much less is taken of all colours that some of each is left.
    vec3 behind = max(seen.rgb * found.a, 0.0), taken = max(-found.rgb, 0.0), share = (1.0 - LEFT) * behind / max(taken, 1e-30);
    float most = min(min(share.r, min(share.g, share.b)), 1.0);
    o_radiance = vec4(behind + max(found.rgb, 0.0) - most * taken, seen.a);
}
