// The camera of the frame: rays, positions from depth, altitudes. Everything is in planet axes, in metres and
// camera-relative unless named otherwise; a planet-centred position never appears in f32.
//
// The depth buffer holds near / z_forward (reversed, infinite far): 0 where nothing was drawn.
#include "generated/frame.glsl"
#include "generated/planet.glsl"

// Pixel coordinates (gl_FragCoord.xy) to normalised device coordinates.
vec2 ndc_of_pixel(vec2 pixel) {
    return pixel * frame.texel_size * 2.0 - 1.0;
}

// Ray through a point of the screen, 1 long along the camera's forward axis (not normalised).
vec3 view_ray(vec2 ndc) {
    vec2 slope = ndc * frame.projection_scale + frame.projection_offset;
    return frame.camera_forward + frame.camera_right * slope.x + frame.camera_up * slope.y;
}

// Distance along forward of a depth value > 0.
float forward_distance(float depth) {
    return frame.near_m / depth;
}

// Camera-relative position of what was drawn with this depth (> 0) here.
vec3 position_from_depth(vec2 ndc, float depth) {
    return view_ray(ndc) * forward_distance(depth);
}

// Clip position of a camera-relative point for the reversed infinite projection (depth = near / z).
vec4 clip_position(vec3 point) {
    float z = dot(point, frame.camera_forward);
    float x = (dot(point, frame.camera_right) - frame.projection_offset.x * z) / frame.projection_scale.x;
    float y = (dot(point, frame.camera_up) - frame.projection_offset.y * z) / frame.projection_scale.y;
    return vec4(x, y, frame.near_m, z);
}

// How much higher than a base point lies a point at `offset` from it. `up`: unit up of the base, `base_radius`: its
// distance from the planet's centre. No cancellation: the rise along up, plus what the sphere falls away below the
// sideways part. Good until the point is below the centre's level (then nothing of it can be seen).
float height_difference(vec3 offset, vec3 up, float base_radius) {
    float rise = dot(offset, up);
    vec3 sideways = offset - up * rise;
    float level = max(base_radius + rise, 0.0);
    float aside2 = dot(sideways, sideways);
    return rise + aside2 / max(sqrt(level * level + aside2) + level, 1e-6);
}

// Altitude above the reference sphere of a camera-relative point.
float altitude_of(vec3 point) {
    return frame.camera_altitude_m
        + height_difference(point, frame.camera_zenith, planet.radius_m + frame.camera_altitude_m);
}

// Unit up (away from the planet's centre) at a camera-relative point.
vec3 up_at(vec3 point) {
    return normalize(frame.camera_zenith * (planet.radius_m + frame.camera_altitude_m) + point);
}

// Foot offset D of a camera-relative point: where its foot on the reference sphere lies, relative to the foot of the
// anchor; with the height h above the sphere, point + camera_offset_m = D (1 + h / r) + anchor_up (h - anchor height).
vec3 foot_offset_of(vec3 point, out float height) {
    vec3 up = frame.anchor_up;
    float base_radius = planet.radius_m + frame.anchor_height_m;
    vec3 offset = point + frame.camera_offset_m;
    float rise = dot(offset, up);
    vec3 sideways = offset - up * rise;
    float level = max(base_radius + rise, 0.0);
    float aside2 = dot(sideways, sideways);
    float fall = aside2 / max(sqrt(level * level + aside2) + level, 1e-6);
    height = frame.anchor_height_m + rise + fall;
    return (sideways - up * fall) / (1.0 + height / planet.radius_m);
}
