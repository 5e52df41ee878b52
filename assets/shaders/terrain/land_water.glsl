// Contract "land_water" (common/land_water.glsl has the rules): rivers and lakes. stirred: 0 a lake's mirror .. 1 white
// water; muddy: 0 clear .. 1 as much sediment as large lowland rivers carry.
#define LAND_WATER

// What lakes and rivers hold beside pure water, at 680, 550 and 440 nm, by the metre: a little that is dissolved and
// afloat in clear ones (2 to 10 m to see through), and silt where they are muddiest (less than 1 m). Chosen so that
// deep water throws back 1 to 2 % and 3 to 7 % of the light, as in Kirk's tables (Light and Photosynthesis in Aquatic
// Ecosystems, 2011).
const vec3 FRESH_LOSS = vec3(0.06, 0.07, 0.16), FRESH_THROWN = vec3(0.004, 0.007, 0.005);
const vec3 SILT_LOSS = vec3(1.25, 1.45, 2.2), SILT_THROWN = vec3(0.25, 0.22, 0.1);
const vec3 STONES = vec3(0.72, 0.78, 0.85);   // the bed's albedo, as shares of the sea's sand

const float LAND_WATER_FALLS = 12.0 / 14.0;   // stirred: the most of rapids; above them water falls

// Share of white water in the mean.
float land_water_white(float stirred) {
    return 0.38 * smoothstep(0.3, 1.1, stirred) + 0.58 * smoothstep(LAND_WATER_FALLS, 1.0, stirred);
}

// Silt in the water, as a share of the most.
float land_water_silt(float muddy) {
    return muddy * sqrt(muddy);
}

// dither: 0 .. 1, of the pixel: there are few steps.
float land_water_encode(float stirred, float muddy, float dither) {
    float up = clamp(dither, 0.01, 0.99);
    return (1.0 + 15.0 * floor(15.0 * clamp(muddy, 0.0, 1.0) + up) + floor(14.0 * clamp(stirred, 0.0, 1.0) + up))
        / 255.0;
}

bool land_water_at(float code) {
    return code > 0.5 / 255.0;
}

// (stirred, muddy)
vec2 land_water_decode(float code) {
    float whole = max(floor(code * 255.0 + 0.5) - 1.0, 0.0), muddy = floor((whole + 0.5) / 15.0);
    return vec2((whole - 15.0 * muddy) / 14.0, muddy / 15.0);
}
