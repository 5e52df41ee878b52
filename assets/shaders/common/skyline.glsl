// The skyline of near ground around the camera, against which far cells are culled: for each of 256 directions, the
// tangent of the elevation below which everything farther is hidden. Only what must be true raises it: every line of
// sight in such a direction crosses a cell that is nowhere lower than its lowest vertex. One workgroup of 256.
//
// A point at height h above the sphere of radius R, whose distance across the camera's vertical is d, lies
// (h - hc) - d^2 / ((R + h)(1 + cos gamma)) above the camera's level, gamma being the central angle between them.
#include "common/constants.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"

const int SKYLINE_BINS = 256;
// a cell's far side is nearer than this fraction of a cell's near side that it may hide
const float SKYLINE_RATIO = 0.6;
const float SKYLINE_REACH = 0.3;     // of the planet's radius: beyond, the bounds below would be loose
const float SKYLINE_LIFT = 16.0;     // makes tangents positive, so that their bits order as integers

shared int s_skyline[SKYLINE_BINS];

void skyline_clear(uint lane) {
    s_skyline[lane] = 0;
}

// (azimuth in bins, distance across the vertical) of a camera-relative point.
vec2 skyline_place(vec3 point) {
    vec3 up = frame.camera_zenith;
    vec3 east = normalize(cross(abs(up.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), up));
    vec3 north = cross(up, east);
    vec2 across = vec2(dot(point, east), dot(point, north));
    return vec2((atan(across.y, across.x) / TWO_PI + 0.5) * float(SKYLINE_BINS), length(across));
}

// A cell lies between two circles around its middle, CELL_INNER and CELL_OUTER in units of this; corners of the cube
// included.
float skyline_cell_size(float spacing_m) {
    return spacing_m * float(CELL_QUADS) * (1.0 + max(frame.anchor_height_m, 0.0) / planet.radius_m);
}

void skyline_raise(vec3 middle, float spacing_m, float lowest_dh) {
    vec2 place = skyline_place(middle);
    float size = skyline_cell_size(spacing_m), inner = CELL_INNER * size, outer = CELL_OUTER * size;
    if (place.y < 2.0 * outer || place.y > SKYLINE_REACH * planet.radius_m) return;
    float radius = planet.radius_m + frame.anchor_height_m + lowest_dh;
    float sag = 8.0 * spacing_m * 8.0 * spacing_m / (8.0 * radius);   // chords of decimated triangles lie lower
    float rise = lowest_dh - sag - 0.05 - (frame.camera_altitude_m - frame.anchor_height_m);
    float near = place.y - outer, far = place.y + outer;
    float tangent = min(rise / near - near / (1.9 * radius), rise / far - far / (1.9 * radius));
    int bits = floatBitsToInt(clamp(tangent - 1e-4 + SKYLINE_LIFT, 0.0, 2.0 * SKYLINE_LIFT));
    float half_width = inner / place.y * float(SKYLINE_BINS) / TWO_PI - 0.01;
    int first = int(ceil(place.x - half_width)), last = int(floor(place.x + half_width)) - 1;
    for (int bin = first; bin <= last; ++bin) atomicMax(s_skyline[(bin + 4 * SKYLINE_BINS) % SKYLINE_BINS], bits);
}

bool skyline_hides(vec3 middle, float spacing_m, float highest_dh) {
    vec2 place = skyline_place(middle);
    float outer = CELL_OUTER * skyline_cell_size(spacing_m);
    if (place.y < 2.0 * outer || place.y > SKYLINE_REACH * planet.radius_m) return false;
    float radius = planet.radius_m + frame.anchor_height_m + highest_dh;
    float rise = highest_dh + 0.05 - (frame.camera_altitude_m - frame.anchor_height_m);
    float near = place.y - outer, far = place.y + outer;
    float steepest = rise >= 0.0 ? near : clamp(sqrt(-2.0 * radius * rise), near, far);
    float tangent = rise / steepest - steepest / (2.0 * radius) + 1e-4;
    int bits = floatBitsToInt(clamp(tangent + SKYLINE_LIFT, 0.0, 2.0 * SKYLINE_LIFT));
    float half_width = 1.06 * outer / place.y * float(SKYLINE_BINS) / TWO_PI + 0.01;
    int first = int(floor(place.x - half_width)), last = int(floor(place.x + half_width));
    bool hidden = true;
    for (int bin = first; bin <= last && hidden; ++bin)
        hidden = s_skyline[(bin + 4 * SKYLINE_BINS) % SKYLINE_BINS] > bits;
    return hidden;
}
