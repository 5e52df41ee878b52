// Sun's rays through the clouds, as maps of the shadow know them: a ray by the place where it crosses the maps'
// reference height, a point on it by its height.
#include "common/camera.glsl"
#include "generated/cloud_view.glsl"

// Distance from a height along a ray of cosine mu to the zenith there, as far as it has risen by `rise` (negative: back
// along the ray). Where it never gets as low, the way to its lowest point. r: of the starting height.
float distance_to_rise(float r, float mu, float rise) {
    float b = r * mu, c = max(rise * (2.0 * r + rise), -b * b);
    float root = sqrt(max(b * b + c, 0.0));
    return b >= 0.0 ? c / max(root + b, 1.0) : root - b;
}

// Height in the maps: whole numbers are the bounds of intervals, 0 below all cloud, the number of intervals above it.
float cloud_node(float altitude) {
    float node = 0.0;
    for (int i = 0; i < 4; ++i) {
        CloudSpan span = cloud_view.spans[i];
        node += span.intervals * clamp((altitude - span.base_m) * span.per_thickness, 0.0, 1.0);
    }
    return node;
}

// Where the sun's ray through a point crosses the reference height on its way out; no less high than its lowest point.
vec3 cloud_sun_place(vec3 point, float altitude, float mu_s) {
    return point + frame.sun_direction * distance_to_rise(planet.radius_m + altitude, mu_s,
        cloud_view.shadow_height_m - altitude);
}
