// Clouds for every pixel from one ray for each block of them: pixels that had their ray in this frame mix it in, the
// others show what the last frame showed at the same place of the clouds, held within what this frame sees around them; where there
// is no past, this frame's rays are spread. Those that ended where the pixel's own surface is count more: clouds in front of
// one thing are not those behind another; and what the last frame saw up to another surface is no past.
//
// An invocation has the pixels between four rays: what these four have seen is the same for all of them.
#include "common/camera.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_distance;
layout(binding = 3) uniform sampler2D u_before;      // last frame's result, linear
layout(binding = 4) uniform sampler2D u_surface;     // depth up to which that was seen
#ifdef VALIDITY
layout(binding = 0, rgba8) uniform writeonly image2D o_clouds;
#else
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
layout(binding = 1, r32f) uniform writeonly image2D o_surface;
#endif
layout(location = 0) uniform ivec2 u_place;          // of this frame's rays in their blocks
layout(location = 1) uniform int u_past;             // 0: none; 1: the camera moves; 2: it stands still
layout(location = 2) uniform mat3 u_turn;            // camera coordinates to those of the frame before
layout(location = 5) uniform vec3 u_shift;           // m
layout(location = 6) uniform vec4 u_projection;      // of the frame before: 1 / sx, 1 / sy, ox, oy
layout(location = 7) uniform float u_weight;         // of this frame's ray where there is a past

const float ALIKE = 0.7;   // ratio of distances to one surface from frame to frame, and across a pixel's step

void main() {
    ivec2 size = textureSize(u_depth, 0), most = textureSize(u_clouds, 0) - 1, place = max(u_place, 0);
    ivec2 corner = ivec2(gl_GlobalInvocationID.xy) - 1, first = corner * STRIDE + place;
    if (any(greaterThanEqual(first, size))) return;
    vec4 seen[4], away, ends;
    for (int i = 0; i < 4; ++i) {
        ivec2 from = clamp(corner + ivec2(i & 1, i >> 1), ivec2(0), most);
        seen[i] = texelFetch(u_clouds, from, 0);
        away[i] = min(texelFetch(u_distance, from, 0).r, 1e8);
        ends[i] = texelFetch(u_depth, min(from * STRIDE + place, size - 1), 0).r;
    }
    vec4 least = min(min(seen[0], seen[1]), min(seen[2], seen[3])), largest = max(max(seen[0], seen[1]), max(seen[2], seen[3]));
    vec4 slack = 0.25 * (largest - least), low = least - slack, high = largest + slack;
    float nearest = max(max(ends.x, ends.y), max(ends.z, ends.w)), farthest = min(min(ends.x, ends.y), min(ends.z, ends.w));
    int busy = STRIDE * STRIDE;
#ifndef VALIDITY
    // What a moving camera's past is held within may be nothing at all.
    busy = u_past != 2 && low == vec4(0.0, 0.0, 0.0, 1.0) && high == low ? 0 : busy;
    for (int k = busy; k < STRIDE * STRIDE; ++k) {
        ivec2 pixel = first + ivec2(k % STRIDE, k / STRIDE);
        imageStore(o_clouds, pixel, vec4(0.0, 0.0, 0.0, 1.0));
        imageStore(o_surface, pixel, texelFetch(u_depth, clamp(pixel, ivec2(0), size - 1), 0).rrrr);
    }
#endif
    for (int k = 0; k < busy; ++k) {
        ivec2 step_ = ivec2(k % STRIDE, k / STRIDE), pixel = first + step_;
        vec2 share = vec2(step_) / float(STRIDE), rest = 1.0 - share;
        bool fresh = k == 0 && u_place.x >= 0 && all(greaterThanEqual(corner, ivec2(0)));
        ivec2 within = clamp(pixel, ivec2(0), size - 1);
        float depth = texelFetch(u_depth, within, 0).r;
        // Depth is near / distance: its ratio is that of the distances.
        vec4 unlike = abs(depth - ends) / max(max(vec4(depth), ends), 1e-20);
        vec4 weight = (vec4(rest.x * rest.y, share.x * rest.y, rest.x * share.y, share.x * share.y) + 1e-3) / (1e-3 + unlike * unlike);
        float per = 1.0 / (weight.x + weight.y + weight.z + weight.w);
        // Held to what is seen around: where that is all alike, so is the spread, to the bit.
        vec4 spread = clamp((weight.x * seen[0] + weight.y * seen[1] + weight.z * seen[2] + weight.w * seen[3]) * per, least, largest);
        // Where it was in the last frame: x to the right, y up, z forward.
        vec2 slope = ndc_of_pixel(vec2(pixel) + 0.5) * frame.projection.xy + frame.projection.zw;
        vec3 then = u_turn * (vec3(slope, 1.0) * (per * dot(weight, away) * inversesqrt(1.0 + dot(slope, slope)))) + u_shift;
        vec2 ndc = (then.xy / max(then.z, 1e-6) - u_projection.zw) * u_projection.xy;
        vec2 uv = u_past == 2 ? (vec2(pixel) + 0.5) / vec2(size) : 0.5 + 0.5 * ndc;
        bool known = u_past == 2 || (u_past == 1 && then.z > 0.0 && all(lessThan(abs(ndc), vec2(1.0))));
        // Where another surface was, what was seen up to it says nothing. A moving camera finds outlines a little aside.
        float then_depth = texelFetch(u_surface, clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1), 0).r;
        vec2 alike = u_past == 2 ? vec2(depth) : vec2(min(depth, farthest), max(depth, nearest));
        known = known && then_depth >= ALIKE * alike.x && ALIKE * then_depth <= alike.y;
        vec4 past = textureLod(u_before, uv, 0.0);
        vec4 held = u_past == 2 ? past : clamp(past, low, high);
        // Writes beside the picture do nothing.
#ifdef VALIDITY
        // For the debug view: red without a past, green with one, towards yellow as far as it had to be held back; paler where this
        // frame's ray is.
        vec4 apart = abs(past - held) / max(largest - least + 1e-6, vec4(1e-6));
        float kept = clamp(max(max(apart.r, apart.g), max(apart.b, apart.a)), 0.0, 1.0);
        vec3 shade = known ? mix(vec3(0.10, 0.55, 0.20), vec3(0.95, 0.80, 0.10), kept) : vec3(0.80, 0.12, 0.10);
        imageStore(o_clouds, pixel, vec4(fresh ? mix(shade, vec3(1.0), 0.35) : shade, 1.0));
#else
        vec4 found = known ? fresh ? mix(held, seen[0], u_weight) : held : fresh ? seen[0] : spread;
        // Light may be less than none: what the air in shadow doesn't scatter is taken off.
        imageStore(o_clouds, pixel, vec4(found.rgb, max(found.a, 0.0)));
        imageStore(o_surface, pixel, vec4(depth));
#endif
    }
}
