// Water of rivers and lakes around a place: the GPU's side of `waters` in systems/terrain/rivers/valleys.py, and how a
// pixel shows it. Part of terrain/height.glsl where TERRAIN_RIVERS is defined.
#include "terrain/height.glsl"

struct LandWater {
    float level;      // of the water, m over the anchor's height, by all lines around
    float beyond;     // m from its edge, negative in the water; large where there is none
    float depth;      // m of the bed below the level
    float coverage;   // share of the pixel that water covers
    bool wide;        // it is wide enough on screen to be a surface of its own
    float above;      // m of bank and floor over the level, at least 0
    vec3 slope;       // of the level
    float stirred, muddy;   // as common/land_water.glsl has them
    float half_width;       // of the nearest
};

const float WATER_NOWHERE_M = 3.0e38;
// Water that is narrower, in pixels, is a share of the ground's.
const float WATER_WIDE_PX = 1.5;
// Rivers that are narrower than a pixel count as so many times as wide at most: their wet banks and green floors show
// from afar as well.
const float WATER_WIDENED = 2.0;

// 0 a mirror .. 1 white water: by Froude's number of the mean speed, and by the slope.
float water_stirred(float speed_m_s, float depth_m, float fall) {
    return clamp(0.3 * speed_m_s * inversesqrt(9.81 * max(depth_m, 0.2)) + 12.0 * fall, 0.0, 1.0);
}

// Lowland rivers carry the more sediment the larger they are; where it is steep it does not stay, in lakes it sinks.
float water_muddy(float discharge_m3_s, float fall, float lake) {
    float carried = clamp(0.4 * log(max(discharge_m3_s, 1.0) / 15.0) / 2.302585, 0.0, 1.0)
        * (1.0 - smoothstep(5e-4, 8e-3, fall));
    return mix(carried, min(carried, 0.1), lake);
}

// The share of a pixel between d - reach and d + reach that lies within half_width of 0.
float water_coverage(float d, float half_width, float reach) {
    return clamp((min(d + reach, half_width) - max(d - reach, -half_width)) / (2.0 * reach), 0.0, 1.0);
}

// across, along: a pixel's sides on the ground, m.
LandWater land_water(RiverPlace p, vec3 across, vec3 along) {
    LandWater w = LandWater(0.0, WATER_NOWHERE_M, 0.0, 0.0, false, WATER_NOWHERE_M, vec3(0.0), 0.0, 0.0, 0.0);
    float total = 0.0, levels = 0.0, sections = 0.0, first = 0.0;
    int k = p.lines.x, end = p.lines.x + p.lines.y;
    if (k < end) do {
        RiverLine line = river_line(k, p);
        float half_width = line.section.y, deep = line.section.z, wet = half_width > 0.0 ? 1.0 : 0.0;
        float share = wet * terrain_river_share(line.d, half_width, line.reach,
            mix(RIVER_NEAR_M2, RIVER_LAKE_NEAR_M2, line.lake));
        float section = terrain_river_section(line.d, half_width, deep);
        first = k == p.lines.x ? line.section.x : first;
        total += share;
        levels += share * (line.section.x - first);
        sections += share * section;
        // Half a pixel's reach at right angles to the line, in the line's metres.
        vec3 apart = line.away * p.turned;
        float reach = 0.5 * max(abs(dot(across, apart)) + abs(dot(along, apart)), 1e-3);
        float counted = min(half_width * WATER_WIDENED, max(half_width, sqrt(half_width * 0.25 * reach)));
        w.coverage = max(w.coverage, wet * water_coverage(line.d, counted, reach));
        float beyond = wet > 0.0 ? line.d - half_width : WATER_NOWHERE_M;
        bool nearer = beyond < w.beyond;
        float fall = length(line.along) * max(-line.section_step.x, 0.0);
        float speed = min(line.discharge / max(1.333 * half_width * deep, 1e-3), 5.0) * (1.0 - line.lake);
        w.wide = nearer ? half_width > WATER_WIDE_PX * reach : w.wide;
        w.above = nearer ? max(section, 0.0) : w.above;
        w.slope = nearer ? line.section_step.x * line.along : w.slope;
        w.stirred = nearer ? water_stirred(speed, deep, fall) * (1.0 - line.lake) : w.stirred;
        w.muddy = nearer ? water_muddy(line.discharge, fall, line.lake) : w.muddy;
        w.half_width = nearer ? half_width : w.half_width;
        w.beyond = nearer ? beyond : w.beyond;
    } while (++k < end);
    float by_total = 1.0 / max(total, 1e-30);
    w.level = terrain_table.rivers.base_m - frame.anchor_height_m + first + levels * by_total;
    w.depth = max(-sections * by_total, 0.0);
    w.slope = w.slope * p.turned;
    return w;
}

// Whether a disc around a place may hold water: within so many metres of the place, with all that bends lines.
bool water_within(RiverPlace p, float radius) {
    bool found = false;
    int k = p.lines.x, end = p.lines.x + p.lines.y;
    if (k < end) do {
        RiverLine line = river_line(k, p);
        found = found || (line.section.y > 0.0 && line.d - line.section.y < radius);
    } while (++k < end);
    return found;
}
