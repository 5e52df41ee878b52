// A ray through the shells of cloud: where it is between two heights, on its way down to its lowest point and up from
// there.
#include "common/camera.glsl"
#include "common/safe.glsl"

// Squared sine of the angle between the ray and the zenith, from their cross product; below 0 where nobody has said it.
// Seen from far away the planet is so small that 1 - mu * mu has no digits left.
float shell_sine2 = -1.0;
const float FAR_RADII = 10.0;

// Distances at which a ray from the camera meets the sphere of a height. x: on the way down (0 from inside), y: on the
// way up; both are the distance to the lowest point where the ray stays above the sphere. Stable: no difference of two
// large numbers.
vec2 shell_crossings(float mu, float height) {
    float r = planet.radius_m + frame.camera_altitude_m;
    float b = r * mu;
    float c = (height - frame.camera_altitude_m) * (planet.radius_m + height + r);   // > 0: the camera is below it
    float d = b * b + c, sphere = planet.radius_m + height;
    if (shell_sine2 >= 0.0 && frame.camera_altitude_m > FAR_RADII * planet.radius_m)
        d = sphere * sphere - r * r * shell_sine2;
    float root = safe_sqrt(d);
    float lowest = max(-b, 0.0);
    if (b >= 0.0) return vec2(0.0, c > 0.0 ? c / max(root + b, 1e-10) : 0.0);
    if (d <= 0.0) return vec2(lowest);
    return vec2(c < 0.0 ? -c / (root - b) : 0.0, root - b);
}

// x, y: where the ray is in the shell going down; z, w: going up. Cut at `end`; empty where x >= y or z >= w.
vec4 shell_intervals(float mu, float base, float top, float end) {
    vec2 low = shell_crossings(mu, base), high = shell_crossings(mu, top);
    return min(vec4(high.x, low.x, low.y, high.y), vec4(end));
}
