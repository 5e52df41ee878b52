// Contract "cloud_shadow" (common/cloud_shadow.glsl has the rules), from maps around the camera, each four times wider than the
// one before. A place on a map is where sunlight meets the clouds' reference height; held are the beam's share that comes
// through all layers, and the share with the light that seeps through.
#include "common/camera.glsl"
#include "generated/cloud_view.glsl"

layout(binding = 16) uniform sampler2DArray u_cloud_shadow;

// Where the sun's ray through a point crosses the height that maps are drawn at.
vec3 cloud_shadow_place(vec3 point, float altitude, vec3 up) {
    float rise = cloud_view.shadow.x - altitude, r = planet.radii.x + altitude;
    float b = r * dot(up, frame.sun_direction.xyz), c = rise * (2.0 * r + rise);
    float root = sqrt(max(b * b + c, 0.0));
    float way = b >= 0.0 ? c / max(root + b, 1.0) : root - b;
    return point + frame.sun_direction.xyz * way;
}

float cloud_shadow(vec3 point) {
    float altitude = altitude_of(point), unused;
    vec3 D = foot_offset_of(cloud_shadow_place(point, altitude, up_at(point)), unused);
    float below = clamp((cloud_view.counts.z - altitude) / max(cloud_view.counts.z - cloud_view.counts.y, 1.0), 0.0, 1.0);
    vec2 sum = vec2(0.0);
    float left = 1.0;
    int levels = int(cloud_view.shadow.y);
    for (int level = 0; level < levels && left > 0.0; ++level) {
        vec3 away = D + cloud_view.shadow_from[level].xyz;
        vec2 at = vec2(dot(away, cloud_view.shadow_u[level].xyz), dot(away, cloud_view.shadow_v[level].xyz))
            * cloud_view.shadow_from[level].w;
        // The next map comes in over the last fifth of this one.
        float edge = max(abs(at.x), abs(at.y));
        float known = left * clamp(5.0 - 5.0 * edge, 0.0, 1.0);
        sum += known * textureLod(u_cloud_shadow, vec3(0.5 + 0.5 * clamp(at, -1.0, 1.0), float(level)), 0.0).rg;
        left -= known;
    }
    vec2 through = sum + left;
    return mix(1.0, through.y, below);
}
