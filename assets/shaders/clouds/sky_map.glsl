// A map of the sky's upper half around the camera: stereographic, the zenith in its middle, the horizon a circle.
#include "common/camera.glsl"
#include "common/safe.glsl"

const float CLOUD_SKY_EDGE = 1.03;   // of the map, beyond the horizon at 1

void cloud_sky_axes(out vec3 east, out vec3 north) {
    vec3 up = frame.camera_zenith;
    // At a pole there is no east, and any will do.
    east = safe_normalize(vec3(-up.y, up.x, 0.0), vec3(0.0, 1.0, 0.0));
    north = cross(up, east);
}

vec2 cloud_sky_place(vec3 direction) {
    vec3 east, north;
    cloud_sky_axes(east, north);
    vec2 at = vec2(dot(direction, east), dot(direction, north))
        / (1.0 + max(dot(direction, frame.camera_zenith), 0.0));
    return 0.5 + 0.5 * at / CLOUD_SKY_EDGE;
}

vec3 cloud_sky_direction(vec2 place) {
    vec3 east, north;
    cloud_sky_axes(east, north);
    vec2 at = (2.0 * place - 1.0) * CLOUD_SKY_EDGE;
    float square = dot(at, at);
    return (2.0 * (at.x * east + at.y * north) + (1.0 - square) * frame.camera_zenith) / (1.0 + square);
}
