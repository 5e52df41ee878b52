// How much snow trees carry, the twin of systems/cover/snow.py: share of what faces up on them that is white.
#include "common/season.glsl"

const vec2 SNOW_COLD = vec2(0.16, 0.01);    // warmth between which trees come to carry it
const float SNOW_WINTER = 0.39;             // by how much midwinter is colder

// keeps: Cover.snow; winter: 0..1, of the northern and the southern half; sine: of the latitude.
float snow_share(float keeps, vec2 winter, float warmth, float sine) {
    warmth -= SNOW_WINTER * winter_here(winter, sine);
    return keeps * clamp((warmth - SNOW_COLD.x) / (SNOW_COLD.y - SNOW_COLD.x), 0.0, 1.0);
}
