// How far each ray surely meets nothing, whatever place in its pixel it goes through: all its paths start from there.
//
// From ball to ball (as sphere tracing, Hart 1996) in which there is no cloud, by the bounds that paths trust; until a
// ball is hardly wider than the pixel is there.
#define CLOUD_NO_CIRRUS
#include "generated/bindings.glsl"
#include "generated/paths.glsl"
#include "clouds/probe/path_medium.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = PATH_RAY_BUFFER) buffer Rays { PathRay rays[]; };
layout(location = 3) uniform int u_rays;
layout(location = 6) uniform vec3 u_up;          // at the anchor, from which places count
layout(location = 10) uniform vec3 u_right;      // across a pixel, for rays 1 long along the camera's forward axis
layout(location = 11) uniform vec3 u_above;

const int TURNS = 1000;
const float LEAST_M = 20.0;    // of a step: paths find shorter ways themselves
const float SURE = 0.9;        // of a ball's radius: the planet is round

// Radius of a ball around a point without droplets of a layer.
float clear_of(CloudViewLayer shell, int layer, vec3 point, float altitude, vec3 up, CloudWeather w, vec2 steep) {
    float share = (altitude - shell.base_m) * shell.per_thickness, within = clamp(share, 0.0, 1.0);
    // Outside the layer: to it, and around the place below or above in it.
    float away = (share - within) / shell.per_thickness;
    CloudNoise n = cloud_noise(layer, point - up * away, within, w, 0.0);
    float clear_m = path_bounds(layer, shell, w, n, within, steep).x,
        inside = shell.kind == CLOUD_UNIFORM ? 0.0 : max(clear_m, 0.0);
    return sqrt(away * away + inside * inside);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_rays)) return;
    frame.camera_offset_m = vec3(0.0);
    frame.camera_zenith = frame.anchor_up = u_up;
    frame.camera_altitude_m = frame.anchor_height_m = 0.0;
    PathRay r = rays[i];
    float pixel = 0.5 * length(u_right + u_above) / length(r.way), t = 0.0;
    vec3 way = normalize(r.way);
    int turn = 0;
    bool on;
    do {
        vec3 point = r.start + way * t, up = up_at(point);
        float altitude = altitude_of(point), ball = PATH_ENDLESS, wide = pixel * (t + r.skipped_m);
        bool space = altitude > cloud_view.highest_m + wide && dot(up, way) > pixel;
        CloudWeather w = cloud_weather(up, 0.0);
        vec2 steep = path_weather_steep(up);
        int layer = 0;
        do ball = min(ball, clear_of(cloud_view.layers[layer], layer, point, altitude, up, w, steep));
        while (++layer < u_layers);
        float step_m = SURE * sqrt(max(ball * ball - wide * wide, 0.0)) - wide;
        on = step_m > LEAST_M && altitude > 0.0 && !space;
        t += space ? PATH_ENDLESS : on ? step_m : 0.0;
    } while (on && ++turn < TURNS);
    rays[i].clear_m = t;
}
