// How much snow trees carry, the twin of systems/cover/snow.py: share of what faces up on them that is white.
const vec2 SHEDS = vec2(0.391, 0.643);      // sines of latitudes between which seasons begin to count
const vec2 SNOW_COLD = vec2(0.16, 0.01);    // warmth between which trees come to carry it
const float SNOW_WINTER = 0.39;             // by how much midwinter is colder

// keeps: Cover.snow; winter: 0..1, of the northern and the southern half; sine: of the latitude.
float snow_share(float keeps, vec2 winter, float warmth, float sine) {
    float seasonal = clamp((abs(sine) - SHEDS.x) / (SHEDS.y - SHEDS.x), 0.0, 1.0);
    warmth -= SNOW_WINTER * seasonal * (sine < 0.0 ? winter.y : winter.x);
    return keeps * clamp((warmth - SNOW_COLD.x) / (SNOW_COLD.y - SNOW_COLD.x), 0.0, 1.0);
}
