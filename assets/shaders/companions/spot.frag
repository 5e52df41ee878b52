// A companion of few pixels or less: every texel of its picture is seen as a Gaussian spot whose light over all pixels
// is that of the texel, as stars are (sky/stars.frag), so that nothing twinkles when it moves.
#include "common/constants.glsl"
layout(binding = 0) uniform sampler2D u_picture;
uniform vec2 u_corner_px;    // lower left
uniform float u_texel_px;    // width of a texel
uniform float u_spot_px;     // standard deviation of the spot
uniform vec2 u_jitter;   // where in its pixel this frame samples
layout(location = 0) out vec4 o_light;

void main() {
    ivec2 size = textureSize(u_picture, 0) / 2;
    float width = 2.0 * u_texel_px;   // four texels make one spot: they are far closer than it is wide
    vec2 here = gl_FragCoord.xy + u_jitter - u_corner_px;
    float narrow = -0.5 / (u_spot_px * u_spot_px);
    vec4 total = vec4(0.0);
    for (int k = 0; k < size.x * size.y; ++k) {
        ivec2 texel = ivec2(k % size.x, k / size.x);
        vec2 away = here - (vec2(texel) + 0.5) * width;
        vec4 four = texelFetch(u_picture, 2 * texel, 0) + texelFetch(u_picture, 2 * texel + ivec2(1, 0), 0);
        four += texelFetch(u_picture, 2 * texel + ivec2(0, 1), 0) + texelFetch(u_picture, 2 * texel + 1, 0);
        total += four * exp(dot(away, away) * narrow);
    }
    o_light = total * (u_texel_px * u_texel_px / (TWO_PI * u_spot_px * u_spot_px));
    o_light.a = min(o_light.a, 1.0);
}
