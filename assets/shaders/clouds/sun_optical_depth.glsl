// Optical depth of the clouds from a sample of the march towards the sun: of the sample's layer in a few steps, then of
// all clouds from the maps of the shadow; and on the same line behind the sample, from the maps alone. Without
// CLOUD_MAPPED (many steps, which are as good as the maps) the layer has them all the way, to both sides, and others,
// which are farther, a quarter as many.
#include "clouds/intervals.glsl"
#include "clouds/sun_depth.glsl"
#include "clouds/sun_march.glsl"

// cosine to the zenith; of a sun below the horizon maps know the ray from its lowest point on alone
const float MAPPED_MU = 0.04;
// thicknesses of the layer: a mean over more has clouds and gaps in it
const vec2 BEHIND_WIDE = vec2(0.1, 0.4);

// Metres to the top of a curved layer along a ray of cosine mu to the zenith: a level one leaves it, too.
float distance_to_top(CloudViewLayer shell, float altitude, float mu) {
    float rise = max(shell.top_m - altitude, 0.0), r = planet.radius_m + altitude;
    float b = r * mu, root = sqrt(max(b * b + rise * (2.0 * r + rise), 0.0));
    return b >= 0.0 ? rise * (2.0 * r + rise) / max(root + b, 1.0) : root - b;
}

// Metres to its base along the same ray backwards; of a level one no farther than six thicknesses.
float distance_to_base(CloudViewLayer shell, float altitude, float mu) {
    float fall = max(altitude - shell.base_m, 0.0), r = planet.radius_m + altitude;
    float b = r * max(mu, 0.0), c = fall * (2.0 * r - fall);
    return min(c / max(b + sqrt(max(b * b - c, 0.0)), 1.0), 6.0 * (shell.top_m - shell.base_m));
}

// Optical depth of one layer up to `near` of the `far` metres in it; mu: of the sun to the zenith; side: 1 towards the
// sun, -1 away from it. Short steps first: what is near casts the sharpest shadows. So many of them lie in the part
// that is marched.
float near_sun_depth(
    int layer, vec3 point, float altitude, float mu, float side, CloudWeather w, float footprint, float near, float far
) {
    CloudViewLayer shell = cloud_view.layers[layer];
#ifdef CLOUD_FINEST
    float most = u_sun_steps;
#else
    // What is averaged over the way there needs no steps of its own.
    float most = u_sun_steps * min(2.0 * far / footprint, 1.0);
#endif
    // Not a whole number: the last step is cut, and grows from nothing. Else there is a line where one more begins.
    float steps = max(most * sqrt(near / max(far, 1e-3)), 1.0);
    float r = planet.radius_m + altitude, sum = 0.0, from = 0.0, per_step = 1.0 / steps;
    int i = 0;
    do {
        float part = min(float(++i) * per_step, 1.0), to = near * part * part, t = 0.5 * (from + to);
        vec3 at = point + side * frame.sun_direction * t;
        float height = altitude + side * t * mu + 0.5 * t * t * (1.0 - mu * mu) / r;
        float share = (height - shell.base_m) * shell.per_thickness;
        sum += (to - from) * cloud_density(layer, at + frame.camera_offset_m, clamp(share, 0.0, 1.0), w,
            max(footprint, 0.35 * (to - from)), 1) * step(share, 1.0);
        from = to;
    } while (float(i) < steps);
    return sum * shell.extinction_per_m;
}

// Of the layers above a place: as sun_optical_depth, without the place's own.
float sun_depth_above(int layer, vec3 point, float altitude, vec3 up, float footprint) {
    float mu = dot(up, frame.sun_direction);
#ifdef CLOUD_MAPPED
    float to = distance_to_top(cloud_view.layers[layer], altitude, mu);
    return cloud_sunlight_on(cloud_sun_ray(point, altitude, mu, footprint), cloud_view.layers[layer].top_m,
        mu + to / (planet.radius_m + altitude)).y;
#else
    return cloud_depth_marched(layer, point, altitude, mu, 0.25 * u_sun_steps, footprint);
#endif
}

// How well it is known what is behind a place: of a level sun nobody knows it, and a mean over clouds and gaps is the
// depth of neither. wide_m: of that mean.
float behind_known(CloudViewLayer shell, float mu, float wide_m) {
    float wide = wide_m * shell.per_thickness;
    return smoothstep(0.0, MAPPED_MU, mu) * (1.0 - smoothstep(BEHIND_WIDE.x, BEHIND_WIDE.y, wide));
}

// x: towards the sun; y: on the same line behind the place, as far as its layer goes; z: behind_known(). point:
// camera-relative, planet axes; up, w: the zenith and the weather there; footprint: in metres.
vec3 sun_optical_depth(int layer, vec3 point, float altitude, vec3 up, CloudWeather w, float footprint) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float mu = dot(up, frame.sun_direction), far = distance_to_top(shell, altitude, mu);
#ifdef CLOUD_MAPPED
    float thickness = shell.top_m - shell.base_m, r = planet.radius_m + altitude;
    far = min(far, 6.0 * thickness);
    CloudSunPlace ray = cloud_sun_ray(point, altitude, mu, footprint);
    float near = mix(far, min(far, max(0.08 * thickness, 1.5 * cloud_map_texel(ray.level))),
        smoothstep(0.0, MAPPED_MU, mu));
    float depth = near_sun_depth(layer, point, altitude, mu, 1.0, w, footprint, near, far);
    float further = altitude + near * mu + 0.5 * near * near * (1.0 - mu * mu) / r;
    vec3 nodes = vec3(cloud_node(further - cloud_sun_dip(further, mu + near / r)),
        cloud_node(altitude - cloud_sun_dip(altitude, mu)), cloud_node(shell.base_m));
    vec3 depths = cloud_depths_on(ray, nodes);
    depth += depths.x;
    float behind = depths.z - depths.y;
    return vec3(depth, max(behind, 0.0), behind_known(shell, mu, max(footprint, cloud_map_texel(ray.level))));
#else
    far = min(far, 1e9);
    float back = distance_to_base(shell, altitude, mu);
    float depth = near_sun_depth(layer, point, altitude, mu, 1.0, w, footprint, far, far),
        behind = near_sun_depth(layer, point, altitude, mu, -1.0, w, footprint, back, back);
    depth += cloud_depth_marched(layer, point, altitude, mu, 0.25 * u_sun_steps, footprint);
    return vec3(depth, behind, behind_known(shell, mu, footprint));
#endif
}
