// Clouds as the camera sees them, one ray for each block of STRIDE x STRIDE pixels: rgb what they add to the picture, a what they
// leave of it. PANORAMA: instead for a map of the sky. With air in front and between: out = a * picture (its own air included) + rgb.
#include "common/camera.glsl"
#include "clouds/shells.glsl"
#include "clouds/density.glsl"
#include "clouds/light.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#ifdef PANORAMA
#include "clouds/sky_map.glsl"
#endif

layout(local_size_x = 8, local_size_y = 4) in;
#ifndef PANORAMA
layout(binding = 4) uniform sampler2D u_depth;
layout(binding = 1, r32f) uniform writeonly image2D o_distance;
#endif
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
layout(location = 0) uniform vec4 u_march;   // short steps through a layer's thickness, growth of a step with distance, shift of the pattern, steps to the sun
layout(location = 2) uniform float u_width;  // of what a ray stands for, in pixels
layout(location = 1) uniform ivec2 u_place;  // of the ray's pixel in its block

float pixel_rad;   // angle that a ray stands for

const float OPAQUE = 0.004;    // no more than a step of an 8-bit picture is left
const float NEAREST_M = 4.0;   // a step around the eye
const float NOT_ALL = 1e9;

// Roberts 2018: neighbours differ as much as they can.
float pattern(ivec2 at) {
    return fract(dot(vec2(at), vec2(0.75487766, 0.56984029)) + u_march.z);
}

struct March {
    vec3 light;        // towards the camera
    float open;        // transmittance of the clouds so far
    vec3 air_behind;   // light of the air between camera and the last segment's end
    vec3 air_past;     // transmittance of that air
    float sum;         // of distance times what was taken, to find the clouds' mean distance
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

CloudWeather weather_along(vec3 ray, float t) {
    return cloud_weather(up_at(ray * t), t * pixel_rad);
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
    int segments = thin ? 1 : clamp(int(log2(way / thickness) * 1.3), 1, 6);
    float growth = log((to + thickness) / (from + thickness)) / float(segments);
    // The shape's noise rises from end to end over a tenth of its volume, seldom faster: metres for each unit of it.
    float slack = 0.1 / cloud_view.broad.w;
    float t = from, ease = longer, begin = from;
    Air here = air_from_camera(ray * from);
    CloudWeather weather_here = weather_along(ray, from);
    m.light += m.open * max(here.in_scatter - m.air_behind, 0.0);
    for (int segment = 0; segment < segments; ++segment) {
        float past = segment == segments - 1 ? to : (from + thickness) * exp(growth * float(segment + 1)) - thickness;
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

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(o_clouds)))) return;
#ifdef PANORAMA
    ivec2 pixel = at;
    vec3 ray = cloud_sky_direction((vec2(at) + 0.5) / vec2(imageSize(o_clouds)));
    float mu = clamp_cos(dot(ray, frame.camera_zenith.xyz)), end = mu > -0.05 ? NOT_ALL : 0.0;
    pixel_rad = 2.0 / float(imageSize(o_clouds).x);
#else
    ivec2 pixel = min(at * STRIDE + u_place, textureSize(u_depth, 0) - 1);
    vec2 ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    vec3 ray = view_ray(ndc);
    float stretch = length(ray), depth = texelFetch(u_depth, pixel, 0).r;
    float end = depth > 0.0 ? forward_distance(depth) * stretch : NOT_ALL;
    ray /= stretch;
    float mu = clamp_cos(dot(ray, frame.camera_zenith.xyz));
    // The planet itself, where nothing was drawn on it.
    vec2 floor_ = shell_crossings(mu, min(planet.radii.w, frame.camera_zenith.w));
    if (depth <= 0.0 && mu < 0.0 && floor_.x < floor_.y && frame.camera_zenith.w > planet.radii.w) end = min(end, floor_.x);

    pixel_rad = frame.clock.w * u_width;
#endif
    cloud_dither = pattern(pixel + ivec2(37, 91));
    March m = March(vec3(0.0), 1.0, vec3(0.0), vec3(1.0), 0.0);
    float nu = clamp_cos(dot(ray, frame.sun_direction.xyz)), shift = pattern(pixel);
    int layers = int(cloud_view.counts.x);
    // Layers are in the order of their heights: down through them from the highest, then up from the lowest.
    for (int turn = 0; turn < 2 * layers; ++turn) {
        bool down = turn < layers;
        int layer = down ? layers - 1 - turn : turn - layers;
        vec4 ways = shell_ways(mu, cloud_view.shell[layer].x, cloud_view.shell[layer].y, end);
        vec2 way = down ? ways.xy : ways.zw;
        if (way.y - way.x < 1e-3 || m.open < OPAQUE) continue;
        march_way(m, layer, ray, way.x, way.y, cloud_phases(nu, cloud_view.droplets[layer].y), shift);
    }
    // The picture behind brings the light of all its air: what lies before the last cloud is counted already.
    m.light = max(m.light - m.open * m.air_behind, 0.0);
    float taken = 1.0 - m.open;
    imageStore(o_clouds, at, vec4(m.light * frame.scale.x, m.open < OPAQUE ? 0.0 : m.open));
#ifndef PANORAMA
    imageStore(o_distance, at, vec4(taken > 1e-4 ? m.sum / taken : NOT_ALL));
#endif
}
