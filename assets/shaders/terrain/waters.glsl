// Water of rivers and lakes around a place: the GPU's side of `waters` in systems/terrain/rivers/valleys.py, and how a
// pixel shows it. Part of terrain/height.glsl where TERRAIN_RIVERS is defined.
#include "terrain/height.glsl"
#include "terrain/land_water.glsl"

struct LandWater {
    float level;      // of the water, m over the anchor's height, by all lines around
    float beyond;     // m from its edge, negative in the water; large where there is none
    float depth;      // m of the bed below the level, the deepest by any line
    float coverage;   // share of the pixel that water covers
    bool wide;        // it is wide enough on screen to be a surface of its own
    float above;      // m of bank and floor over the level, at least 0
    vec3 slope;       // of the level, by the nearest line
    vec3 tilt;        // the same, changing over from line to line
    float stirred, muddy;   // as terrain/land_water.glsl has them
    float falls;            // 0..1: it falls freely here, or has just come down
    vec3 fall_tilt;         // slope of the level there
    float half_width, deep; // of the nearest: half its width, depth in its middle
    float lake;             // 1: that is a lake
    float bar;              // m from the edge of gravel or mud along it, negative on that
};

const float WATER_NOWHERE_M = 3.0e38;
const float BAR_STRIP_M = 3.0, BAR_MOST_M = 40.0;   // widths of gravel along banks at most, and on bars
const float WATER_DAMP_M = 0.3;   // ground up to so high over the water is wet
// Water that is narrower, in pixels, is a share of the ground's.
const float WATER_WIDE_PX = 1.5;
// Rivers that are narrower than a pixel count as so many times as wide at most: their wet banks and green floors show
// from afar as well.
const float WATER_WIDENED = 2.0;
// Water narrower than so much of a pixel is not seen; it fades up to the second.
const float WATER_LEAST_PX = 0.08, WATER_FADES_PX = 0.2;

// Falls are as wide as their river along it, and spread over that: their mean slope by that of their line.
const float WATER_FALL_TILT = 0.5;
// Lines that are further away change levels by less than a millimetre, and tiles of the picture do not ask them.
const float WATER_AROUND_M = 200.0;
// From one line to the next water changes over so many metres, within those: or tiles would show.
const float WATER_MIXES_M = 300.0;

// 0 a mirror .. white water, and above LAND_WATER_FALLS falling freely: by Froude's number of the mean speed, and by
// the slope.
float water_stirred(float speed_m_s, float depth_m, float fall) {
    return min(0.35 * speed_m_s * inversesqrt(9.81 * max(depth_m, 0.2)) + 7.0 * fall, LAND_WATER_FALLS);
}

// Lowland rivers carry the more sediment the larger they are; where it is steep it does not stay, in lakes it sinks.
float water_muddy(float discharge_m3_s, float fall, float lake) {
    float carried = clamp(0.4 * log(max(discharge_m3_s, 1.0) / 15.0) / 2.302585, 0.0, 1.0)
        * (1.0 - smoothstep(5e-4, 8e-3, fall));
    return mix(carried, 1.0 / 15.0, lake);
}

// The share of a pixel between d - reach and d + reach that lies within half_width of 0.
float water_coverage(float d, float half_width, float reach) {
    return clamp((min(d + reach, half_width) - max(d - reach, -half_width)) / (2.0 * reach), 0.0, 1.0);
}

// Lines between these slopes are falls, wholly from the second on: others count nothing there, they nothing beyond.
const vec2 WATER_FALLS = vec2(0.15, 0.4);

// Sums over lines, and the first one's level, from which levels count.
struct WaterSums {
    float total, levels, first, mixed;
    bool some;
};

const LandWater NO_LAND_WATER = LandWater(0.0, WATER_NOWHERE_M, 0.0, 0.0, false, WATER_NOWHERE_M, vec3(0.0),
    vec3(0.0), 0.0, 0.0, 0.0, vec3(0.0), 0.0, 0.0, 0.0, WATER_NOWHERE_M);
const WaterSums NO_WATER_SUMS = WaterSums(0.0, 0.0, 0.0, 0.0, false);

// Half of what a pixel reaches at right angles to a line, in the line's metres. across, along: its sides on the ground,
// m.
float water_reach_of(RiverLine line, RiverPlace p, vec3 across, vec3 along) {
    vec3 apart = line.away * p.turned;
    return 0.5 * max(abs(dot(across, apart)) + abs(dot(along, apart)), 1e-3);
}

float water_share_of(RiverLine line, float reach) {
    float half_width = line.bank;
    float counted = min(half_width * WATER_WIDENED, max(half_width, sqrt(half_width * 0.25 * reach)));
    return smoothstep(WATER_LEAST_PX, WATER_FADES_PX, half_width / reach)
        * water_coverage(line.d, counted, reach);
}

// Metres from the edge of what a river leaves along its banks: bars where they draw back from straight ones, a strip
// elsewhere.
float water_bar(RiverLine line) {
    float half_width = line.bank, uneven = terrain_table.rivers.uneven;
    float strip = uneven * min(0.3 + 0.06 * half_width, BAR_STRIP_M);
    float bars = min(max(line.section.y - half_width, 0.0), min(0.5 * half_width, BAR_MOST_M));
    return half_width > 0.0 ? line.d - half_width - strip - bars : WATER_NOWHERE_M;
}

// Adds a line.
void land_water_add(inout LandWater w, inout WaterSums sums, RiverLine line, RiverPlace p, vec3 across, vec3 along) {
    float half_width = line.bank, deep = line.section.z, wet = half_width > 0.0 ? 1.0 : 0.0;
    float share = wet * terrain_river_share(line.d, line.section.y, line.reach);
    float section = terrain_river_section(line.d, half_width, deep);
    sums.first = sums.some ? sums.first : line.section.x;
    sums.some = true;
    sums.total += share;
    sums.levels += share * (line.section.x - sums.first);
    w.depth = max(w.depth, wet * -section);
    float reach = water_reach_of(line, p, across, along);
    w.coverage = max(w.coverage, water_share_of(line, reach));
    float beyond = wet > 0.0 ? line.d - half_width : WATER_NOWHERE_M, apart_m = max(beyond, 0.0);
    float fall = length(line.along) * max(-line.section_step.x, 0.0);
    float speed = min(line.discharge / max(1.333 * half_width * deep, 1e-3), 5.0) * (1.0 - line.lake);
    vec3 slope = line.section_step.x * line.along;
    // A fall reaches as far beyond its lip and its foot as lines mix (systems/terrain/rivers/form.py: river_share).
    float steep = length(line.way) > 0.0 ? -line.section_step.x / length(line.way) : 0.0;
    float falling = wet * smoothstep(WATER_FALLS.x, WATER_FALLS.y, steep);
    float at_fall = falling * (1.0 - smoothstep(half_width, 1.3 * half_width + 6.0, line.d));
    w.fall_tilt = at_fall > w.falls ? -(steep / length(line.way)) * line.way : w.fall_tilt;
    w.falls = max(w.falls, at_fall);
    float says = wet * half_width * half_width / (apart_m * apart_m + WATER_MIXES_M * WATER_MIXES_M);
    float within = clamp(1.0 - apart_m * apart_m / (WATER_AROUND_M * WATER_AROUND_M), 0.0, 1.0);
    says *= (1.0 - 0.9999 * falling) * max(within * within, 1e-5);
    sums.mixed += says;
    w.stirred += says * water_stirred(speed, deep, fall) * (1.0 - line.lake);
    w.muddy += says * water_muddy(line.discharge, fall, line.lake);
    w.tilt += says * slope;
    bool nearer = beyond < w.beyond;
    w.wide = nearer ? half_width > WATER_WIDE_PX * reach : w.wide;
    w.above = nearer ? max(section, 0.0) : w.above;
    w.slope = nearer ? slope : w.slope;
    w.half_width = nearer ? half_width : w.half_width;
    w.deep = nearer ? deep : w.deep;
    w.lake = nearer ? line.lake : w.lake;
    w.bar = nearer ? water_bar(line) : w.bar;
    w.beyond = nearer ? beyond : w.beyond;
}

void land_water_end(inout LandWater w, WaterSums sums, RiverPlace p) {
    w.level = terrain_table.rivers.base_m - frame.anchor_height_m + sums.first + sums.levels / max(sums.total, 1e-30);
    w.stirred /= max(sums.mixed, 1e-30);
    w.muddy /= max(sums.mixed, 1e-30);
    w.tilt = (w.tilt * p.turned) / max(sums.mixed, 1e-30);
    w.slope = w.slope * p.turned;
    w.tilt = mix(w.tilt, WATER_FALL_TILT * (w.fall_tilt * p.turned), w.falls);
    w.stirred = mix(w.stirred, 1.0, w.falls);
}
