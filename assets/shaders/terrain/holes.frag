// Debug view: pixels that show the background although their ray meets the sphere below all ground, in magenta and made
// large enough to be found; all else dim.
#include "common/camera.glsl"
#include "common/surfaces.glsl"

layout(binding = 0) uniform usampler2D u_surface;
in vec2 v_ndc;
layout(location = 0) out vec4 o_color;

const int LARGE = 3;   // a hole of one pixel is drawn this far to all sides

bool is_hole(ivec2 pixel) {
    if (texelFetch(u_surface, pixel, 0).r != SURFACE_NONE) return false;
    vec3 ray = normalize(view_ray(ndc_of_pixel(vec2(pixel) + 0.5)));
    // A sphere is hit below its horizon; two pixels are left to rounding and to what a pixel covers.
    float inner = planet.radius_m + planet.lowest_m;
    float above = frame.camera_altitude_m - planet.lowest_m;
    if (above <= 0.0) return false;
    float horizon = -sqrt(above * (2.0 * inner + above)) / (inner + above);
    return dot(ray, frame.camera_zenith) < horizon - 2.0 * frame.pixel_rad;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(u_surface, 0) - 1;
    const vec3 SURFACES[4] = vec3[4](vec3(0.02), vec3(0.10, 0.16, 0.08), vec3(0.05, 0.10, 0.18), vec3(0.2, 0.08, 0.06));
    vec3 color = SURFACES[min(texelFetch(u_surface, pixel, 0).r, 3u)];
    bool hole = false;
    for (int y = -LARGE; y <= LARGE; ++y)
        for (int x = -LARGE; x <= LARGE; ++x) hole = hole || is_hole(clamp(pixel + ivec2(x, y), ivec2(0), last));
    o_color = vec4(hole ? vec3(1.0, 0.0, 1.0) : color, 1.0);
}
