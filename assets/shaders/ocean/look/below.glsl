// The surface from below: Snell's window onto the sky, and around it the water mirrored in its own surface.
#include "common/constants.glsl"
#include "ocean/look/fresnel.glsl"
#include "ocean/look/pixel.glsl"
#include "ocean/look/murk.glsl"
#include "ocean/look/bed.glsl"
#include "ocean/look/mirror.glsl"

// The sun through facets (Walter et al. 2007, equation 21), its disc widening their slopes. Radiance per irradiance.
float sun_through(Slopes slopes, vec3 v, vec3 l, float sun_radius, float index) {
    vec3 h = -normalize(index * v + l);   // of facets that bend the sun's light to the eye
    float l_h = dot(l, h), v_h = -dot(v, h);
    float spread = sun_radius / max(index - 1.0, 0.05);
    slopes.variance.xy += 0.25 * spread * spread;
    float h2 = max(h.z * h.z, 1e-3);
    float through = 1.0 - fresnel_outside(max(l_h, 1e-3), index);
    float squeezed = l_h - index * v_h;
    float value = l_h * v_h * index * index * through * slopes_facets(slopes, -h.xy / h.z)
        / (h2 * h2 * max(-v.z, 0.05) * squeezed * squeezed);
    return l_h > 0.0 && v_h > 0.0 && h.z > 0.02 && l.z > 0.0 ? value : 0.0;
}

// sunlight: on a plane across it, above the surface.
vec3 surface_from_below(SeaPixel p, vec3 sunlight, vec3 skylight) {
    float index = ocean.refractive_index;
    vec3 v = p.view * p.level, l = frame.sun_direction * p.level;
    // Facets to either side of the mean: the window's edge is as soft as the slopes that are too small to see.
    vec2 aside = slopes_aside(v);
    float sigma = sqrt(slopes_variance_along(p.slopes, aside));
    vec3 through = vec3(0.0), light = vec3(0.0);
    WaterSun sun = water_sun(p.zenith, sunlight, skylight, fresnel_outside(max(l.z, 1e-3), index));
    float mirror = 0.0;
    for (int i = 0; i < 4; ++i) {
        vec3 up = sea_normal_of(p.slopes.mean + (float(i) - 1.5) * 0.894 * sigma * aside, p.level);
        float cosine = clamp(-dot(p.view, up), 1e-3, 1.0), back = fresnel_inside(cosine, index);
        vec3 out_of = refract(-p.view, -up, index);
        out_of = dot(out_of, out_of) > 0.0 ? out_of : p.zenith;
        out_of = normalize(out_of + p.zenith * max(0.01 - dot(out_of, p.zenith), 0.0));
        light += 0.25 * (1.0 - back) * index * index * textureLod(u_sky_map, sky_map_place(out_of), 0.0).rgb;
        mirror += 0.25 * back;
    }
    light += sunlight * sun_through(p.slopes, v, l, frame.sun_radius_rad, index);
    // Mirrored: water and bed below. A ray that the waves send level goes far.
    vec3 up = sea_normal_of(p.slopes.mean, p.level), down = reflect(-p.view, -up);
    float fall = max(-dot(down, p.zenith), 0.03), path = p.depth_m / fall;
    vec3 at = p.D + (down + p.zenith * fall) * min(path, 200.0);
    vec3 lit = sun.direct * sun.cosine * water_left(p.depth_m / sun.cosine)
        + sun.diffuse * water_left(p.depth_m / SKY_COSINE);
    vec3 bed = sea_bed(at, p.depth_m, p.footprint_m + 0.02 * path) * lit / PI * water_left(path);
    light += mirror * (bed + water_murk(sun, 0.0, -fall, path, dot(down, sun.to_sun)));
    return light;
}
