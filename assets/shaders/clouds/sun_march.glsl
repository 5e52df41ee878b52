// Optical depth of the clouds between a point and the sun, looked up step by step: where maps of the shadow are not to
// be trusted, or there are none.
#include "clouds/density.glsl"
#include "clouds/sun_ray.glsl"

// Of all layers but one (`but` negative: of all), in so many steps through each. point: camera-relative, planet axes.
// Of a sun below the point's horizon: what the ray meets from its lowest point on.
float cloud_depth_marched(int but, vec3 point, float altitude, float mu, float steps, float footprint) {
    float r = planet.radii.x + altitude, sum = 0.0;
    vec3 sun = frame.sun_direction.xyz;
    int layer = 0;
    do {
        CloudViewLayer shell = cloud_view.layers[layer];
        float from = altitude < shell.base_m || mu < 0.0 ? cloud_way_to(r, mu, shell.base_m - altitude) : 0.0;
        float to = altitude < shell.top_m || mu < 0.0 ? cloud_way_to(r, mu, shell.top_m - altitude) : 0.0;
        from = max(from, 0.0);
        int count = layer != but && to > from ? int(ceil(steps)) : 0;
        float unit = count > 0 ? (to - from) / max(steps, 1.0) : 0.0;
        int k = 0;
        do {
            float t = from + (float(k) + 0.5) * unit, wide = max(footprint, 0.35 * unit);
            float rise = t * (2.0 * r * mu + t),
                share = (altitude + rise / (sqrt(max(r * r + rise, 0.0)) + r) - shell.base_m) * shell.per_thickness;
            vec3 at = point + sun * t;
            sum += shell.extinction_per_m * unit * step(share, 1.0)
                * cloud_density(layer, at + frame.camera_offset.xyz, clamp(share, 0.0, 1.0),
                    cloud_weather(up_at(at), wide), wide, 0);
        } while (++k < count);
    } while (++layer < cloud_view.layer_count);
    return sum;
}
