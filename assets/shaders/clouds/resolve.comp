// Clouds for every pixel from one ray for each block of them: pixels that had their ray in this frame mix it in, the
// others show what the last frame showed at the same place of the clouds, held within what this frame sees around them;
// where there is no past, this frame's rays are spread. Those that ended where the pixel's own surface is count more:
// clouds in front of one thing are not those behind another; and what the last frame saw up to another surface is no
// past.
//
// An invocation has the pixels between four rays: what these four have seen is the same for all of them. Pixels are
// those of the clouds' picture, PICTURE_PX of the frame's a side.
#include "common/camera.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0) uniform sampler2D u_clouds;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_distance;
layout(binding = 3) uniform sampler2D u_before;      // last frame's result, linear
layout(binding = 4) uniform sampler2D u_surface;     // depth up to which that was seen
layout(binding = 5) uniform sampler2D u_spread;      // of the rays, for where there is no past
#ifdef VALIDITY
layout(binding = 0, rgba8) uniform writeonly image2D o_clouds;
#else
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
#endif
layout(location = 0) uniform ivec2 u_place;          // of this frame's rays in their blocks
layout(location = 1) uniform int u_history;             // 0: none; 1: the camera moves; 2: it stands still
layout(location = 2) uniform mat3 u_turn;            // camera coordinates to those of the frame before
layout(location = 5) uniform vec3 u_shift;           // m
layout(location = 6) uniform vec4 u_projection;      // of the frame before: 1 / sx, 1 / sy, ox, oy
layout(location = 7) uniform float u_weight;         // of this frame's ray where there is a past
// of the checkerboard of blocks with a ray of this frame, as in view_ray.glsl
layout(location = 8) uniform int u_checkerboard;

const float ALIKE = 0.7;   // ratio of distances to one surface from frame to frame, and across a pixel's step
const float HURRY = 15.0;   // half of what is shown is new where the camera comes nearer by 1 / HURRY in a frame
const float FEWER = 0.2;     // of the range around: half of the rays span less of what there is than all

vec4 blend(vec4 of[4], vec4 weight) {
    return weight.x * of[0] + weight.y * of[1] + weight.z * of[2] + weight.w * of[3];
}

void main() {
    ivec2 size = textureSize(u_depth, 0), most = textureSize(u_clouds, 0) - 1, place = max(u_place, 0);
    ivec2 corner = ivec2(gl_GlobalInvocationID.xy) - 1, first = corner * STRIDE + place;
    if (any(greaterThanEqual(first, size))) return;
    // Each of the four, and what it and its neighbours have seen: least and largest.
    // Textures show their nearest texel, beyond the edge the last one: on software GPUs in less than half of the time
    // of texelFetch.
    vec2 per_ray = 1.0 / vec2(most + 1), per_pixel = 1.0 / vec2(size);
    vec4 seen[4], least[4], largest[4], away, ends;
    for (int i = 0; i < 4; ++i) {
        ivec2 from = clamp(corner + ivec2(i & 1, i >> 1), ivec2(0), most);
        vec2 at = (vec2(from) + 0.5) * per_ray;
        seen[i] = textureLod(u_spread, at, 0.0);
        least[i] = vec4(1e9);
        largest[i] = vec4(-1e9);
        away[i] = min(textureLod(u_distance, at, 0.0).r, 1e8);
        ends[i] = texelFetch(u_depth, min(from * STRIDE + place, size - 1), 0).r;
    }
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            vec4 ray = textureLod(u_clouds, (vec2(corner + ivec2(x, y)) - 0.5) * per_ray, 0.0);
            for (int i = 0; i < 4; ++i) {
                if (abs(x - 1 - (i & 1)) < 2 && abs(y - 1 - (i >> 1)) < 2) {
                    least[i] = min(least[i], ray);
                    largest[i] = max(largest[i], ray);
                }
            }
        }
    }
    vec4 ray = textureLod(u_clouds, (vec2(clamp(corner, ivec2(0), most)) + 0.5) * per_ray, 0.0);
    float nearest = max(max(ends.x, ends.y), max(ends.z, ends.w)),
        farthest = min(min(ends.x, ends.y), min(ends.z, ends.w));
    vec4 lowest = min(min(least[0], least[1]), min(least[2], least[3])),
        highest = max(max(largest[0], largest[1]), max(largest[2], largest[3]));
    float wider = u_checkerboard < 0 ? 0.0 : FEWER;
    float rush = HURRY * length(u_shift);
    // Of the clouds' picture, by the frame: an odd one leaves part of the last row and column beside it.
    vec2 fill = frame.viewport.xy / vec2(size * PICTURE_PX);
    int busy = STRIDE * STRIDE;
#ifndef VALIDITY
    // What a moving camera's past is held within may be nothing at all.
    busy = u_history != 2 && lowest == vec4(0.0, 0.0, 0.0, 1.0) && highest == lowest ? 0 : busy;
    for (int k = busy; k < STRIDE * STRIDE; ++k) {
        imageStore(o_clouds, first + ivec2(k % STRIDE, k / STRIDE), vec4(0.0, 0.0, 0.0, 1.0));
    }
#endif
    for (int k = 0; k < busy; ++k) {
        ivec2 step_ = ivec2(k % STRIDE, k / STRIDE), pixel = first + step_;
        vec2 share = vec2(step_) / float(STRIDE), rest = 1.0 - share;
        bool fresh = k == 0 && u_place.x >= 0 && all(greaterThanEqual(corner, ivec2(0)))
            && (u_checkerboard < 0 || ((corner.x + corner.y + u_checkerboard) & 1) == 0);
        float depth = textureLod(u_depth, (vec2(pixel) + 0.5) * per_pixel, 0.0).r;
        // Depth is near / distance: its ratio is that of the distances.
        vec4 unlike = abs(depth - ends) / max(max(vec4(depth), ends), 1e-20);
        vec4 plain = vec4(rest.x * rest.y, share.x * rest.y, rest.x * share.y, share.x * share.y);
        vec4 weight = (plain + 1e-3) / (1e-3 + unlike * unlike);
        float per = 1.0 / (weight.x + weight.y + weight.z + weight.w);
        // Continuous over the picture. Where all that is seen around is alike, so are these and the spread, to the bit.
        vec4 low = blend(least, plain), high = blend(largest, plain), more = wider * (high - low);
        low = clamp(low - more, lowest, highest);
        high = clamp(high + more, lowest, highest);
        vec4 spread = clamp(blend(seen, weight * per), low, high);
        // Where it was in the last frame: x to the right, y up, z forward.
        vec2 slope = ndc_of_pixel((vec2(pixel) + 0.5) * float(PICTURE_PX)) * frame.projection.xy + frame.projection.zw;
        float distance_m = per * dot(weight, away);
        vec3 then = u_turn * (vec3(slope, 1.0) * (distance_m * inversesqrt(1.0 + dot(slope, slope)))) + u_shift;
        vec2 ndc = (then.xy / max(then.z, 1e-6) - u_projection.zw) * u_projection.xy;
        vec2 uv = u_history == 2 ? (vec2(pixel) + 0.5) * per_pixel : (0.5 + 0.5 * ndc) * fill;
        bool known = u_history == 2 || (u_history == 1 && then.z > 0.0 && all(lessThan(abs(ndc), vec2(1.0))));
        // Where another surface was, what was seen up to it says nothing. A moving camera finds outlines a little
        // aside.
        float then_depth = textureLod(u_surface, uv, 0.0).r;
        // But clouds over ground are never those over the sky: beyond the limb they would stand in space.
        vec2 alike = u_history == 2 || depth <= 0.0 ? vec2(depth) : vec2(min(depth, farthest), max(depth, nearest));
        known = known && then_depth >= ALIKE * alike.x && ALIKE * then_depth <= alike.y;
        vec4 past = textureLod(u_before, uv, 0.0);
        vec4 held = u_history == 2 ? past : clamp(past, low, high);
        // Writes beside the picture do nothing.
#ifdef VALIDITY
        // For the debug view: red without a past, green with one, towards yellow as far as it had to be held back;
        // paler where this frame's ray is.
        vec4 apart = abs(past - held) / max(high - low + 1e-6, vec4(1e-6));
        float kept = clamp(max(max(apart.r, apart.g), max(apart.b, apart.a)), 0.0, 1.0);
        vec3 shade = known ? mix(vec3(0.10, 0.55, 0.20), vec3(0.95, 0.80, 0.10), kept) : vec3(0.80, 0.12, 0.10);
        imageStore(o_clouds, pixel, vec4(fresh ? mix(shade, vec3(1.0), 0.35) : shade, 1.0));
#else
        // What a camera flies up to shows more of itself from frame to frame than one ray in a block tells.
        float hurry = u_history == 2 ? 0.0 : rush / (distance_m + rush);
        vec4 found = known ? mix(fresh ? mix(held, ray, u_weight) : held, spread, hurry) : fresh && u_checkerboard < 0
            ? ray
            : spread;
        // Light may be less than none: what the air in shadow doesn't scatter is taken off.
        imageStore(o_clouds, pixel, vec4(found.rgb, max(found.a, 0.0)));
#endif
    }
}
