// A texel's way towards the sun, in steps of one texel along the axis of the map that it follows more closely: so what
// is seen after whole steps lies on a row or a column of texels, and is interpolated along that only.
//
// A ray that passes altitude z at x and leaves it with elevation e passes, an angle t further on, radius
// (R + z) cos e / cos(e + t). So what hides the limb below altitude s there hides it here below s c + R (c - 1), with
// c = cos(e + t) / cos e = cos t - tan e sin t: exact for any distance, and again a straight line from there on.
#include "common/safe.glsl"
#include "shadows/clipmap.glsl"

layout(local_size_x = 16, local_size_y = 4) in;
uniform int u_level;
uniform int u_step;
uniform ivec2 u_corner;   // of the texels to make in the window
uniform ivec2 u_size;     // how many there are

struct ShadowMarch {
    vec3 up, side;      // projection's axes; side: level, towards the sun
    vec2 place;
    vec2 tangents;      // of the elevations of the upper and of the lower limb
    vec2 direction;     // of a step, texels; the larger component is 1 or -1
    float step_rad;     // angle of a step
    float to_texels;    // of the level, per length on the map
};

struct ShadowStep {
    vec2 offset;            // texels
    float sine, versine;    // of the angle; versine: 1 - cos
};

const float SHADOW_STEEPEST = 0.995;   // sine: higher suns (84 degrees) count as this
const float SHADOW_FARTHEST = 1.5;     // radians
const float SHADOW_NOTHING = -1.0e9;

ShadowMarch shadow_march(vec2 at) {
    ShadowFoot foot = shadow_foot(u_level, at);
    ShadowMarch march;
    vec3 sun = shadow_map.sun_direction;
    float sine = dot(sun, foot.up);
    vec3 side = sun - foot.up * sine;
    float length2 = dot(side, side);
    march.up = foot.up;
    march.place = foot.place;
    march.side = length2 > 1e-12 ? side * inversesqrt(length2) : normalize(vec3(foot.up.z, 0.0, -foot.up.x) + 1e-6);
    sine = clamp(sine, -SHADOW_STEEPEST, SHADOW_STEEPEST);
    float middle = sine * inversesqrt(1.0 - sine * sine);
    float radius = shadow_map.sun_radius_rad;   // its tangent, nearly
    march.tangents = vec2(middle + radius, middle - radius)
        / max(vec2(1.0 - middle * radius, 1.0 + middle * radius), 0.05);
    march.to_texels = shadow_frequency(u_level);
    vec2 per_rad = (march.side.xy - march.place * march.side.z) * march.to_texels / max(1.0 + march.up.z, 1e-6);
    march.step_rad = 1.0 / max(abs(per_rad.x), abs(per_rad.y));
    march.direction = per_rad * march.step_rad;
    return march;
}

ShadowStep shadow_step(ShadowMarch march, float steps) {
    float half_sine = pf_sin_small(0.5 * min(steps * march.step_rad, SHADOW_FARTHEST));
    ShadowStep advance;
    advance.versine = 2.0 * half_sine * half_sine;
    advance.sine = 2.0 * half_sine * sqrt(1.0 - half_sine * half_sine);
    vec3 d = march.side * advance.sine - march.up * advance.versine;
    advance.offset = (d.xy - march.place * d.z) / max(1.0 + march.up.z + d.z, 1e-6) * march.to_texels;
    return advance;
}

// Limbs hidden there, as they are hidden here.
vec2 shadow_carried(ShadowMarch march, ShadowStep advance, vec2 limbs) {
    return limbs - (limbs + shadow_map.radius_m) * (advance.versine + march.tangents * advance.sine);
}

vec2 limbs_at(ivec2 index);

// What is seen after whole steps; beyond the window, nothing.
vec2 shadow_seen(ShadowMarch march, ivec2 from, float steps) {
    ShadowStep advance = shadow_step(march, steps);
    bool along_x = abs(march.direction.x) >= abs(march.direction.y);
    // The row or column is met within a small part of a step (a few hundredths where the planet's curve shows).
    float along = along_x ? advance.offset.x : advance.offset.y;
    float whole = round(along), more = (whole - along) * (along_x ? sign(march.direction.x) : sign(march.direction.y));
    float across = (along_x ? advance.offset.y : advance.offset.x)
        + more * (along_x ? march.direction.y : march.direction.x);
    float angle = more * march.step_rad;
    advance.versine += angle * advance.sine;
    advance.sine += angle;
    float row = floor(across), part = across - row;
    ivec2 corner = from + (along_x ? ivec2(whole, row) : ivec2(row, whole));
    ivec2 next = corner + (along_x ? ivec2(0, 1) : ivec2(1, 0));
    bool inside = all(greaterThanEqual(corner, ivec2(0))) && all(lessThan(next, ivec2(shadow_map.window_texels)))
        && steps * march.step_rad < SHADOW_FARTHEST;
    ivec2 last = ivec2(shadow_map.window_texels - 1);
    vec2 limbs = mix(limbs_at(clamp(corner, ivec2(0), last)), limbs_at(clamp(next, ivec2(0), last)), part);
    return inside ? shadow_carried(march, advance, limbs) : vec2(SHADOW_NOTHING);
}
