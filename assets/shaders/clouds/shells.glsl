// A ray through the shells of cloud: where it is between two heights, on its way down to its lowest point and up from there.
#include "common/camera.glsl"
#include "common/safe.glsl"

// Distances at which a ray from the camera meets the sphere of a height. x: on the way down (0 from inside), y: on the way up;
// both are the distance to the lowest point where the ray stays above the sphere. Stable: no difference of two large numbers.
vec2 shell_crossings(float mu, float height) {
    float r = planet.radii.x + frame.camera_zenith.w;
    float b = r * mu;
    float c = (height - frame.camera_zenith.w) * (planet.radii.x + height + r);   // > 0: the camera is below the height
    float d = b * b + c;
    float root = safe_sqrt(d);
    float lowest = max(-b, 0.0);
    if (b >= 0.0) return vec2(0.0, c > 0.0 ? c / max(root + b, 1e-10) : 0.0);
    if (d <= 0.0) return vec2(lowest);
    return vec2(c < 0.0 ? -c / (root - b) : 0.0, root - b);
}

// x, y: where the ray is in the shell going down; z, w: going up. Cut at `end`; empty where x >= y or z >= w.
vec4 shell_ways(float mu, float base, float top, float end) {
    vec2 low = shell_crossings(mu, base), high = shell_crossings(mu, top);
    return min(vec4(high.x, low.x, low.y, high.y), vec4(end));
}
