// A thin ring in the plane of the equator: light scattered once in a slab (Chandrasekhar 1960, ch. III), behind the
// air. Define DENSITY: its opacity alone.
#include "common/camera.glsl"
#include "contract/air.glsl"
#include "contract/sun_visibility.glsl"

layout(binding = 0) uniform sampler2D u_depth;
uniform vec3 u_camera;  // in radii, from the planet's centre
uniform vec4 u_ring;    // inner and outer edge in radii, optical depth, radius in metres
uniform vec3 u_albedo;
layout(location = 0) out vec4 o_color;

float wave(float x) {
    return 0.5 + 0.5 * sin(x);
}

// Optical depth at a distance from the centre: ringlets, a wide gap, soft edges.
float depth_at(float radii) {
    float x = (radii - u_ring.x) / max(u_ring.y - u_ring.x, 1e-6);
    if (x <= 0.0 || x >= 1.0) return 0.0;
    float ringlets = 0.45 + 0.3 * wave(61.0 * x) * wave(17.0 * x + 1.0) + 0.25 * wave(190.0 * x + 4.0 * wave(9.0 * x));
    float gap = 1.0 - 0.97 * (smoothstep(0.63, 0.635, x) - smoothstep(0.685, 0.69, x));
    return u_ring.z * ringlets * gap * smoothstep(0.0, 0.03, x) * (1.0 - smoothstep(0.985, 1.0, x))
        * mix(0.35, 1.0, smoothstep(0.1, 0.4, x));
}

void main() {
    vec3 ray = view_ray(ndc_of_pixel(gl_FragCoord.xy));
    float distance = -u_camera.z / ray.z;  // along the ray, in radii; the ray is 1 long along forward
    float behind = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r;
    bool hidden = behind > 0.0 && forward_distance(behind) < distance * u_ring.w;
    float tau = distance > 0.0 && !hidden ? depth_at(length(u_camera.xy + distance * ray.xy)) : 0.0;
    float mu = max(abs(normalize(ray).z), 1e-3), mu0 = max(abs(frame.sun_direction.z), 1e-3);
    float opacity = 1.0 - exp(-tau / mu);
#ifdef DENSITY
    o_color = vec4(opacity);
#else
    // The lit side is seen where camera and sun are on one side of it.
    bool lit = u_camera.z * frame.sun_direction.z > 0.0;
    float away = mu0 - mu, near = abs(away) < 1e-3 ? tau / mu * exp(-tau / mu)
        : mu0 / away * (exp(-tau / mu0) - exp(-tau / mu));
    float share = lit ? mu0 / (mu + mu0) * (1.0 - exp(-tau * (1.0 / mu + 1.0 / mu0))) : near;
    vec3 point = ray * min(distance * u_ring.w, 1e12);
    vec3 light = u_albedo / (4.0 * 3.14159265) * frame.sun_irradiance * share * sun_visibility(point);
    Air air = air_from_camera(point);
    o_color = tau > 0.0 ? vec4((light * air.transmittance + opacity * air.in_scatter) * frame.hdr_per_radiance, opacity)
        : vec4(0.0);
#endif
}
