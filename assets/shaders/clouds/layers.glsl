// Straight rays through spherical shells, from any camera: on the ground, inside, above, far out.
//
// h: height above the reference sphere of radius R, t: distance along the ray. Distances and heights come from
// differences of squares that are formed as products, so that a shell 1 m thick keeps its metre on a planet of any
// size.
#include "common/safe.glsl"
#include "generated/cloud_model.glsl"

struct ShellRay {
    float h;         // of the start
    float b;         // (R + h) mu: how far the start lies past the nearest point to the planet's centre
    float perigee;   // height of that point, below -R never
};

float shell_radius() {
    return cloud_model.radius_m;
}

// mu, sine: cosine and sine of the ray's angle to the zenith at its start.
ShellRay shell_ray(float h, float mu, float sine) {
    float r = shell_radius() + h;
    // r sine - R without its cancellation for level rays.
    return ShellRay(h, r * mu, h - r * mu * mu / (1.0 + sine));
}

// a (2 R + a) - b (2 R + b): difference of two squared distances from the centre.
float shell_between(float a, float b) {
    return (a - b) * (2.0 * shell_radius() + a + b);
}

float shell_height(ShellRay ray, float t) {
    float r = shell_radius() + ray.h, q = t * (2.0 * ray.b + t);
    return ray.h + q / (safe_sqrt(r * r + q) + r);
}

// Where the ray is inside the ball up to a height, from x to y, both >= 0; y <= x: nowhere.
vec2 shell_ball(ShellRay ray, float height) {
    float inside2 = shell_between(height, ray.perigee), c = shell_between(ray.h, height);
    float q = abs(ray.b) + safe_sqrt(inside2);
    // Roots of t^2 + 2 b t + c: q and c / q; a ray that touches the ball where it starts has q = 0.
    float other = q > 0.0 ? c / q : 0.0;
    vec2 roots = ray.b < 0.0 ? vec2(other, q) : vec2(-q, -other);
    return inside2 > 0.0 ? max(roots, 0.0) : vec2(0.0);
}

// Where the ray is between two heights: from x to y, and again from z to w; y <= x, w <= z: not.
vec4 shell_intervals(ShellRay ray, float base, float top) {
    vec2 whole = shell_ball(ray, top), hollow = shell_ball(ray, base);
    if (hollow.y <= hollow.x) return vec4(whole, 0.0, 0.0);
    return vec4(whole.x, hollow.x, hollow.y, whole.y);
}

// Distance to the reference sphere; negative where the ray misses it. From below it (a camera in a valley) rays go out.
float shell_to_ground(ShellRay ray) {
    if (ray.perigee >= 0.0 || ray.b >= 0.0 || ray.h < 0.0) return -1.0;
    return shell_ball(ray, 0.0).x;
}

// The same ray from where it enters the ball up to `top`, and the distance there; a ray that misses starts where it
// did, with a negative distance. From 36 000 km a distance has 4 m in single precision, one from the top of the air a
// centimetre.
ShellRay shell_enter(ShellRay ray, float top, out float start) {
    start = 0.0;
    if (ray.h <= top) return ray;
    vec2 inside = shell_ball(ray, top);
    if (inside.y <= inside.x) {
        start = -1.0;
        return ray;
    }
    start = inside.x;
    return ShellRay(top, -safe_sqrt(shell_between(top, ray.perigee)), ray.perigee);
}

// The ray towards the sun from a point at height h; rise: the point's coordinate along the sun's direction from the
// centre.
ShellRay shell_sun_ray(float h, float rise) {
    float r = shell_radius() + h, mu = clamp_cos(rise / r);
    return shell_ray(h, mu, sin_from_cos(mu));
}

// Distances at which the ray towards the sun touches the sphere of a height: there, sun transmittance has a kink. rise,
// nu: coordinate of the ray's start along the sun's direction, and cosine between the ray and the sun.
vec2 shell_tangents(ShellRay ray, float rise, float nu, float height) {
    // (r^2 - rise^2)(t) = (R + height)^2 is (1 - nu^2) t^2 + 2 (b - nu rise) t + c = 0.
    ShellRay sun = shell_sun_ray(ray.h, rise);
    float a = (1.0 - nu) * (1.0 + nu), half_b = ray.b - nu * rise, c = shell_between(sun.perigee, height);
    float inside = half_b * half_b - a * c;
    float q = -half_b - sign_nonzero(half_b) * safe_sqrt(inside);
    if (inside < 0.0) return vec2(-1.0);
    return vec2(a > 0.0 ? q / a : -1.0, q != 0.0 ? c / q : -1.0);
}
