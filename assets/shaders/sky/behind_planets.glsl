// The share of the light from behind all planets that they let through at a pixel. Unit 0 or 1, by what a pass binds.
#ifdef PLANETS
layout(binding = PLANETS) uniform sampler2D u_planets;  // engine/frame/backdrop.py; a black texel where there are none

float past_planets() {
    ivec2 last = textureSize(u_planets, 0) - 1;
    return 1.0 - texelFetch(u_planets, min(ivec2(gl_FragCoord.xy), last), 0).a;
}
#else
float past_planets() {
    return 1.0;
}
#endif
