// Waves running up a beach, for the water's side and for the land's: surf that comes in over the shallows, breaks, runs
// up and drains away. One clock for both: at a place of the shore a wave arrives when its phase passes 0.
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "ocean/look/noise.glsl"

struct Shore {
    float foam;    // share of the surface that foam covers
    float film;    // 0..1: a sheet of water lies on the ground
    float damp;    // 0..1: the ground is wet
    vec3 foam_albedo;
};

const float SHORE_UP = 0.3;   // share of the period in which the water rises on the beach

// How high over the still sea the shore is wet.
float shore_reach() {
    return 2.0 * ocean.surf_m;
}

// above_m: height over the still sea, negative in the water; rise_m: how much of it a pixel covers.
Shore shore_at(vec3 D, float above_m, float rise_m, float footprint_m) {
    float surf = ocean.surf_m;
    Shore shore = Shore(0.0, 0.0, 0.0, ocean.foam_albedo);
    bool reached = surf > 0.0 && above_m < shore_reach() && above_m > -4.0 * surf;
    int turns = reached ? 2 : 0;
    float phase = frame.time_s * (512.0 / 4096.0), uneven = 0.0;   // 8 s, a divisor of the clock's period
    int i = 0;
    if (turns > 0) do {
        int k = i == 0 ? 10 : 7;
        float n = sea_noise(D, k);
        uneven += (i == 0 ? 0.8 : 0.35) * n * clamp(2.0 - footprint_m * 4.0 / (NESTED_BASE_M * exp2(float(k))), 0.0,
            1.0);
    } while (++i < turns);
    float depth = max(-above_m, 0.0) / surf;
    // Long waves' speed falls with the root of the depth, and so does the time left to the shore.
    float cycle = fract(phase + 0.45 * uneven + 1.1 * sqrt(depth));
    float reach = surf * (0.75 + 0.25 * clamp(uneven, -1.0, 1.0));
    float up = cycle < SHORE_UP ? sin(1.5707963 * cycle / SHORE_UP)
        : 0.5 + 0.5 * cos(PI * (cycle - SHORE_UP) / (1.0 - SHORE_UP));
    float line = reach * up, soft = max(0.5 * rise_m, 0.02 * surf);
    float seen = clamp(2.0 - 1.5 * rise_m / surf, 0.0, 1.0);   // else means over time and place

    // On land.
    float drained = max(cycle - SHORE_UP, 0.0) / (1.0 - SHORE_UP);
    float film = smoothstep(soft, -soft, above_m - line);
    float edge = exp(-abs(above_m - line) / (0.12 * surf + soft)) * (1.0 - 0.85 * drained);
    float left = film * (0.55 - 0.5 * drained)
        + 0.25 * smoothstep(soft, -soft, above_m - reach) * (1.0 - film) * (1.0 - drained);
    // In the water: a breaker's foam, which thins behind it; deeper than 3 times the surf's height nothing breaks.
    float breaks = smoothstep(3.2, 1.6, depth);
    float surfing = breaks * (exp(-5.0 * cycle) + 0.8 * exp(-60.0 * (1.0 - cycle)) + 0.18 * exp(-1.5 * depth));
    bool land = above_m > 0.0;
    shore.film = land ? mix(0.4 * smoothstep(surf, 0.0, above_m), film, seen) : 0.0;
    shore.damp = reached ? smoothstep(1.6 * surf + rise_m, 0.8 * surf - 0.5 * rise_m, above_m) : 0.0;
    shore.foam = land ? mix(0.15 * smoothstep(surf, 0.0, above_m), max(edge, left), seen)
        : mix(0.25 * breaks, surfing, seen);
    shore.foam = reached ? clamp(shore.foam, 0.0, 1.0) : 0.0;
    shore.film *= reached ? 1.0 : 0.0;
    return shore;
}
