// Optical depth of the clouds between a point and the sun, sampled step by step: where maps of the shadow are not to
// be trusted, or there are none.
#include "clouds/density.glsl"
#include "clouds/sun_ray.glsl"

// Of all layers but `except` (negative: of all), in so many steps through each. point: camera-relative, planet axes.
// Of a sun below the point's horizon: what the ray meets from its lowest point on.
float cloud_depth_marched(int except, vec3 point, float altitude, float mu, float steps, float footprint) {
    float r = planet.radius_m + altitude, sum = 0.0;
    vec3 sun = frame.sun_direction;
    int layer = 0;
    do {
        CloudViewLayer shell = cloud_view.layers[layer];
        float from = altitude < shell.base_m || mu < 0.0 ? distance_to_rise(r, mu, shell.base_m - altitude) : 0.0;
        float to = altitude < shell.top_m || mu < 0.0 ? distance_to_rise(r, mu, shell.top_m - altitude) : 0.0;
        from = max(from, 0.0);
        float lowest = mu < 0.0 ? 0.0 : clamp((altitude - shell.base_m) * shell.per_thickness, 0.0, 1.0);
        bool cirrus = CLOUD_IS_CIRRUS(layer);
        int count = layer == except || to <= from ? 0 : cirrus ? 1 : int(ceil(steps));
        float step_m = count > 0 ? (to - from) / (cirrus ? 1.0 : max(steps, 1.0)) : 0.0;
        int k = 0;
        do {
            float t = from + (float(k) + 0.5) * step_m, width_m = max(footprint, 0.35 * step_m);
            float rise = t * (2.0 * r * mu + t),
                share = (altitude + rise / (sqrt(max(r * r + rise, 0.0)) + r) - shell.base_m) * shell.per_thickness;
            vec3 at = point + sun * t, place = at + frame.camera_offset_m;
            CloudWeather w = cloud_weather(up_at(at), width_m);
            // A sheet of ice is met in its middle.
            float filled = cirrus_filled(shell, vec2(lowest, 1.0));
            sum += shell.extinction_per_m * step_m * (cirrus ? filled * cirrus_density(layer, place, w, footprint)
                : step(share, 1.0) * cloud_density(layer, place, clamp(share, 0.0, 1.0), w, width_m, 0));
        } while (++k < count);
    } while (++layer < cloud_view.layer_count);
    return sum;
}
