// A companion of few pixels or less: every texel of its picture is seen as a Gaussian spot whose light over all pixels
// is that of the texel, as stars are (sky/stars.frag), so that nothing twinkles when it moves.
layout(binding = 0) uniform sampler2D u_picture;
// lower left corner in pixels (x, y), width of a texel in pixels, standard deviation of the spot
uniform vec4 u_place;
uniform vec2 u_jitter;   // where in its pixel this frame samples
layout(location = 0) out vec4 o_light;

void main() {
    ivec2 size = textureSize(u_picture, 0) / 2;
    float width = 2.0 * u_place.z;   // four texels make one spot: they are far closer than it is wide
    vec2 here = gl_FragCoord.xy + u_jitter - u_place.xy;
    float narrow = -0.5 / (u_place.w * u_place.w);
    vec4 total = vec4(0.0);
    for (int k = 0; k < size.x * size.y; ++k) {
        ivec2 texel = ivec2(k % size.x, k / size.x);
        vec2 away = here - (vec2(texel) + 0.5) * width;
        vec4 four = texelFetch(u_picture, 2 * texel, 0) + texelFetch(u_picture, 2 * texel + ivec2(1, 0), 0);
        four += texelFetch(u_picture, 2 * texel + ivec2(0, 1), 0) + texelFetch(u_picture, 2 * texel + 1, 0);
        total += four * exp(dot(away, away) * narrow);
    }
    o_light = total * (u_place.z * u_place.z / (6.28318530718 * u_place.w * u_place.w));
    o_light.a = min(o_light.a, 1.0);
}
