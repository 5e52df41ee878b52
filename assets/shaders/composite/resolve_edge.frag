// Anti-aliasing of a single frame: where light steps along an outline, pixels get the share of the other side that the
// outline's course says (the idea of morphological anti-aliasing, Reshetov 2009, as a search along the edge in the
// manner of Lottes 2009). Outlines are where surfaces meet and where depth, linear on screen along a plane, is not:
// detail within a surface would only get worse. Stars and the sun's disc are drawn smooth.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/texel.glsl"
#include "composite/exposure.glsl"
#include "composite/resolved.glsl"

layout(binding = 0) uniform sampler2D u_scene;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform usampler2D u_surface;
layout(std430, binding = EXPOSURE_BUFFER) readonly buffer ExposureIn { Exposure exposure; };
layout(location = 0) out vec4 o_resolved;

const int REACH = 12;            // pixels that an edge is followed each way
const float LEAST = 0.04;        // of display brightness: smaller steps are left alone
const float RIDGE = 0.15;        // of the depth, by which it may bend within a surface
const float RELATIVE = 0.12;     // and those smaller than this share of the brightest around

ivec2 last;

vec3 light_at(ivec2 pixel) {
    vec3 radiance = texelFetch(u_scene, clamp(pixel, ivec2(0), last), 0).rgb * frame.radiance_per_hdr;
    return press(exposed_light(radiance, exposure.saturated));
}

// About as an eye sees it.
float shade_of(vec3 light) {
    return sqrt(dot(light, vec3(0.3, 0.5, 0.2)));
}

float shade_at(ivec2 pixel) {
    return shade_of(light_at(pixel));
}

// Light of a pixel where the outline runs, with its share of the other side.
vec3 smoothed(ivec2 pixel) {
    float shade[9];
    float least = 1e9, most = 0.0;
    for (int k = 0; k < 9; k++) {
        shade[k] = shade_at(pixel + ivec2(k % 3, k / 3) - 1);
        least = min(least, shade[k]);
        most = max(most, shade[k]);
    }
    bool edge = most - least > max(LEAST, RELATIVE * most);
    // Second differences: which way the edge runs here.
    float across_y = abs(shade[0] - 2.0 * shade[3] + shade[6]) + 2.0 * abs(shade[1] - 2.0 * shade[4] + shade[7])
        + abs(shade[2] - 2.0 * shade[5] + shade[8]);
    float across_x = abs(shade[0] - 2.0 * shade[1] + shade[2]) + 2.0 * abs(shade[3] - 2.0 * shade[4] + shade[5])
        + abs(shade[6] - 2.0 * shade[7] + shade[8]);
    bool level = across_y >= across_x;
    float up = level ? shade[7] : shade[5], down = level ? shade[1] : shade[3];
    bool upwards = abs(up - shade[4]) >= abs(down - shade[4]);
    float other = upwards ? up : down;
    ivec2 side = (level ? ivec2(0, 1) : ivec2(1, 0)) * (upwards ? 1 : -1);
    ivec2 along = level ? ivec2(1, 0) : ivec2(0, 1);
    float middle = 0.5 * (shade[4] + other), step_here = abs(other - shade[4]);
    // Along both sides of the edge until their mean leaves the edge's own, that is, until the edge turns away.
    ivec2 reached = ivec2(1);
    vec2 end = vec2(0.0);
    bvec2 going = bvec2(edge);
    for (int k = 1; k <= REACH && any(going); k++) {
        ivec2 one = pixel + along * k, two = pixel - along * k;
        vec2 off = 0.5 * vec2(shade_at(one) + shade_at(one + side), shade_at(two) + shade_at(two + side)) - middle;
        reached = ivec2(going.x ? k : reached.x, going.y ? k : reached.y);
        end = vec2(going.x ? off.x : end.x, going.y ? off.y : end.y);
        going = bvec2(going.x && abs(off.x) < 0.25 * step_here, going.y && abs(off.y) < 0.25 * step_here);
    }
    bool first = reached.x <= reached.y;
    float span = float(reached.x + reached.y - 1), from_end = float(first ? reached.x : reached.y) - 0.5;
    bool turned = first ? !going.x : !going.y;
    // The outline passes through this pixel only if it turns to this pixel's side at the nearer end.
    bool mine = (shade[4] < middle) != ((first ? end.x : end.y) < 0.0) && turned;
    float share = edge && mine ? clamp(0.5 - from_end / max(span, 1.0), 0.0, 0.5) : 0.0;
    return mix(light_at(pixel), light_at(pixel + side), share);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    last = textureSize(u_scene, 0) - 1;
    vec3 light = light_at(pixel);
    float depth = texel_at(u_depth, pixel).r;
    uint kind = texel_at(u_surface, pixel).r;
    int outline = 0;
    for (int k = 0; k < 2; k++) {
        ivec2 to = k == 0 ? ivec2(1, 0) : ivec2(0, 1);
        ivec2 one = min(pixel + to, last), two = max(pixel - to, ivec2(0));
        float bend = texel_at(u_depth, one).r + texel_at(u_depth, two).r - 2.0 * depth;
        bool meets = texel_at(u_surface, one).r != kind || texel_at(u_surface, two).r != kind;
        if (meets || abs(bend) > RIDGE * depth) outline = 1;
    }
    // a loop, because an `if` skips nothing on some machines
    for (int k = 0; k < outline; k++) light = smoothed(pixel);
    o_resolved = vec4(light, place_code(place_distance(depth / frame.near_m), kind, 1));
}
