// The march along one ray through the layers of cloud that follow the weather, with the air in front and between.
//
//   March march_clouds(vec3 ray, float mu, float end, float shift)
//
// ray: unit, from the camera; mu: its cosine to the zenith; end: how far it goes; shift: 0..1, of the steps. Whoever includes this
// sets pixel_rad and cloud_dither first. Without air in front: out = open * picture (its own air included) + light.
#include "common/camera.glsl"
#include "clouds/ways.glsl"
#include "clouds/light.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"

layout(location = 0) uniform vec4 u_march;   // short steps through a layer's thickness, growth of a step with distance, 0, steps to the sun

const float OPAQUE = 0.004;    // no more than a step of an 8-bit picture is left
const float NEAREST_M = 4.0;   // a step around the eye

struct March {
    vec3 light;        // towards the camera
    float open;        // transmittance of the clouds so far
    vec3 air_behind;   // light of the air between camera and the last segment's end
    vec3 air_past;     // transmittance of that air
    float sum;         // of distance times what was taken, to find the clouds' mean distance
    float steps;       // places that were looked at, those towards the sun not counted
};

vec3 sun_at(vec3 point, float altitude, vec3 up) {
    float h = max(altitude, 0.0) / planet.radii.x, sin_h = 1.0 / (1.0 + h), cos_h = -sqrt(h * (2.0 + h)) * sin_h;
    float soft = frame.sun_direction.w * sin_h;
    float seen = smoothstep(-soft, soft, dot(up, frame.sun_direction.xyz) - cos_h);
    return frame.sun_irradiance.rgb * seen * air_to_space(point, frame.sun_direction.xyz);
}

// Optical depth of one layer towards the sun.
float depth_to_sun(int layer, vec3 point, float altitude, vec3 up, CloudWeather w, float footprint) {
    vec4 shell = cloud_view.shell[layer];
    float mu = dot(up, frame.sun_direction.xyz);
    // To the top, over a curved layer: a level ray leaves it, too.
    float rise = max(shell.y - altitude, 0.0), r = planet.radii.x + altitude;
    float b = r * mu, root = sqrt(max(b * b + rise * (2.0 * r + rise), 0.0));
    float way = min(b >= 0.0 ? rise * (2.0 * r + rise) / max(root + b, 1.0) : root - b, 6.0 * (shell.y - shell.x));
    // Ice is thin; and what is averaged over the way there needs no steps of its own.
    int steps = cloud_view.droplets[layer].z == 1.0 ? 1 : max(int(u_march.w * min(2.0 * way / footprint, 1.0)), 1);
    float sum = 0.0, from = 0.0, per_step = 1.0 / float(steps);
    for (int i = 1; i <= steps; ++i) {
        // Short steps first: what is near casts the sharpest shadows.
        float part = float(i) * per_step, to = way * part * part, t = 0.5 * (from + to);
        vec3 at = point + frame.sun_direction.xyz * t;
        float height = altitude + t * mu + 0.5 * t * t * (1.0 - mu * mu) / r;
        float share = (height - shell.x) * shell.z;
        sum += (to - from) * cloud_density(layer, at + frame.camera_offset.xyz, clamp(share, 0.0, 1.0), w,
            max(footprint, 0.35 * (to - from)), 0) * step(share, 1.0);
        from = to;
    }
    return sum * shell.w;
}

// One way through one layer. Long steps through the clear; where there is cloud, back to the last clear place and on in short
// steps, which the cloud's own extinction and a pixel's width at that distance measure out.
void march_way(inout March m, int layer, vec3 ray, float from, float to, vec2 phases, float shift) {
    vec4 shell = cloud_view.shell[layer], drops = cloud_view.droplets[layer];
    float thickness = shell.y - shell.x, way = to - from;
    bool thin = drops.z > 0.5;
    float least = thickness / u_march.x, grow = max(u_march.y, way / (600.0 * max(to, 1.0)));
    float longer = thin ? 1.0 : 4.0, most = max(way / (0.3 * u_march.x), least);
    if (thin) least = most = way / ceil(0.04 * u_march.x * log2(2.0 * way / thickness + 2.0));
    int segments = way_segments(shell, thin, from, to);
    // The shape's noise rises from end to end over a tenth of its volume, seldom faster: metres for each unit of it.
    float slack = 0.1 / cloud_view.broad.w;
    float t = from, ease = longer, begin = from;
    Air here = air_from_camera(ray * from);
    CloudWeather weather_here = weather_along(ray, from);
    m.light += m.open * max(here.in_scatter - m.air_behind, 0.0);
    for (int segment = 0; segment < segments; ++segment) {
        float past = way_end(shell, from, to, segment, segments);
        vec3 middle = ray * (0.5 * (begin + past));
        vec3 up_middle = up_at(middle);
        vec3 sun = sun_at(middle, altitude_of(middle), up_middle);
        float height_of_sun = max(dot(up_middle, frame.sun_direction.xyz), 0.15);
        vec3 sky = sky_irradiance(middle, up_middle) / PF_PI;
        vec3 ground = 0.12 / PF_PI * (sun * max(dot(up_middle, frame.sun_direction.xyz), 0.0)) + 0.12 * sky;
        Air there = air_from_camera(ray * past);
        // Weather changes over tens of kilometres: in between it is taken as even.
        CloudWeather weather_there = weather_along(ray, past);
        float seen = 0.0, per_metre = 1.0 / max(past - begin, 1e-3);
        while (t < past && m.open > OPAQUE) {
            // To the next step in cloud. Apart from what that one needs, so that rays in the clear don't pay for it.
            bool met = false;
            float length_m = 0.0, at = t, altitude = 0.0, share = 0.0, footprint = 0.0, density = 0.0, part = 0.0;
            vec3 point = ray * t;
            CloudWeather w = weather_here;
            while (t < past) {
                float near, unit = min(max(min(least, thin ? least : NEAREST_M + 0.02 * t), t * grow), most);
                // Clouds that a pixel is too wide to show have smooth means.
                unit = min(max(unit, 0.3 * t * pixel_rad), max(way * 0.125, unit));
                length_m = min(unit * ease, past - t + 1e-3);
                at = t + shift * length_m;
                point = ray * at;
                altitude = altitude_of(point);
                share = clamp((altitude - shell.x) * shell.z, 0.0, 1.0);
                footprint = max(at * pixel_rad, 0.2 * unit);
                part = (at - begin) * per_metre;
                w = cloud_weather_between(weather_here, weather_there, part);
                m.steps += 1.0;
                density = cloud_density_near(layer, point + frame.camera_offset.xyz, share, w, footprint, 2, near);
                bool found = density > 1e-4;
                met = found && (ease <= 1.0 || thin);
                if (met) break;
                // The same stretch again, in short steps; or on.
                float on = found ? 0.0 : length_m;
                t += on;
                seen += m.open * on;
                ease = found ? 1.0 : max(min(ease * 1.4, longer), min(near * slack / unit, 16.0));
            }
            if (!met) break;
            float depth = shell.w * density * length_m;
            float to_sun = depth_to_sun(layer, point, altitude, up_middle, w, footprint);
            float below = shell.w * density * share * 0.5 * thickness;
            vec3 source = sun * cloud_sun_source(phases, drops.y, to_sun)
                + sky * cloud_sky_source(drops.y, to_sun * height_of_sun) + ground * (0.5 / (1.0 + 0.1 * below));
            float taken = m.open * (1.0 - exp(-depth));
            vec3 air_past = mix(here.transmittance, there.transmittance, part);
            m.light += drops.x * taken * air_past * source;
            m.sum += taken * at;
            seen += (m.open - 0.5 * taken) * length_m;
            m.open -= taken;
            t += length_m;
            ease = 1.0;
        }
        m.light += max(there.in_scatter - here.in_scatter, 0.0) * (seen * per_metre);
        here = there;
        weather_here = weather_there;
        begin = past;
    }
    m.air_behind = here.in_scatter;
    m.air_past = here.transmittance;
}

March march_clouds(vec3 ray, float mu, float end, float shift) {
    March m = March(vec3(0.0), 1.0, vec3(0.0), vec3(1.0), 0.0, 0.0);
    float nu = clamp_cos(dot(ray, frame.sun_direction.xyz));
    vec2 spans[2 * CLOUD_VIEW_LAYERS];
    int layers[2 * CLOUD_VIEW_LAYERS];
    // Only those that there are: software GPUs go once through all of a loop's turn, whoever has nothing to do in it.
    int count = cloud_ways(mu, end, spans, layers);
    for (int k = 0; k < count && m.open > OPAQUE; ++k) {
        int layer = layers[k];
        march_way(m, layer, ray, spans[k].x, spans[k].y, cloud_phases(nu, cloud_view.droplets[layer].y), shift);
    }
    // The picture behind brings the light of all its air: what lies before the last cloud is counted already.
    m.light = max(m.light - m.open * m.air_behind, 0.0);
    m.open = m.open < OPAQUE ? 0.0 : m.open;
    return m;
}
