// The march through a sheet of ice: no steps, but the places where a ray meets it.
#include "clouds/run_light.glsl"
#include "clouds/sun_optical_depth.glsl"

// From close by fibres lie before one another at all heights of the layer, and what is seen is their mean: up to so
// many thicknesses away, and this share of one wide.
const float NEAR_THICKNESSES = 8.0, NEAR_SPREAD = 0.3;

void march_cirrus(inout March m, LayerRay r) {
    float apart = cirrus_apart(r.shell, r.from, r.to);
    vec2 ends = vec2(altitude_of(r.ray * r.from), altitude_of(r.ray * r.to));
    int places = cirrus_places(apart), place = 0;
    float through_m = (r.to - r.from) / float(places)
        * cirrus_filled(r.shell, clamp((ends - r.shell.base_m) * r.shell.per_thickness, 0.0, 1.0));
    do {
        float t = cirrus_place(r.from, r.to, apart, place), pixel_m = (t + ray_skipped_m) * pixel_rad;
        vec3 point = r.ray * t;
        Air air = air_from_camera(point);
        CloudWeather w = weather_along(r.ray, t);
        // What is in front of it is seen as if there were none, what is behind it through all of it.
        m.radiance += m.transmittance * max(air.in_scatter - m.air_in_scatter, 0.0);
        m.air_in_scatter = air.in_scatter;
        m.air_transmittance = air.transmittance;
        Segment s = Segment(t, t, 0.0, w, w, air, air);
        SegmentLight light = segment_light(r, s);
        // A pixel that sees the sheet at a low angle stands for a long way along it.
        float footprint = max(pixel_m * inversesqrt(max(abs(light.mu), LEAST_MU)), 0.2 * apart * (r.to - r.from));
        footprint = max(footprint, NEAR_SPREAD * max(1.0 / r.shell.per_thickness - t / NEAR_THICKNESSES, 0.0));
        float density = cirrus_density(r.layer, point + frame.camera_offset_m, w, footprint),
              column = cloud_column(r.layer, w, density);
        m.samples += 1.0;
        // Of the sheet itself half is above its middle.
        float sun_depth = 0.5 * column / light.mu_s
            + sun_depth_above(r.layer, point, altitude_of(point), light.up, pixel_m);
        CloudRun run = CloudRun(r.shell.extinction_per_m * density * through_m, t, 0.0, through_m, through_m, 0.0);
        run.depth_before = 0.5 * run.depth;
        CloudAround around = CloudAround(sun_depth, 0.5 * column);
        if (density > LEAST_DENSITY && run.depth > 0.0) add_run(m, r, s, light, run, around);
    } while (++place < places && m.transmittance > OPAQUE);
}
