// Temporal upsampling of the clouds, from one ray for each block of pixels: pixels that had their ray in this frame
// blend it with their history, others show the history, reprojected to the same place of the clouds and clamped to what
// this frame sees around them; where there is no valid history, this frame's rays are upsampled. Rays that ended on the
// pixel's own surface count more: clouds in front of one thing are not those behind another; and a history that was
// seen up to another surface is not valid.
//
// An invocation has the pixels between four rays: what these four have seen is the same for all of them. Pixels are
// those of the clouds' picture, PICTURE_PX of the frame's a side. Colours: rgb radiance, a transmittance.
#include "common/camera.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0) uniform sampler2D u_rays;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_distance;
layout(binding = 3) uniform sampler2D u_history;         // last frame's result, linear
layout(binding = 6) uniform sampler2D u_history_texels;  // the same, nearest
layout(binding = 4) uniform sampler2D u_history_depth;   // up to which that was seen
layout(binding = 5) uniform sampler2D u_filtered;        // of the rays, for where there is no history
#ifdef VALIDITY
layout(binding = 0, rgba8) uniform writeonly image2D o_clouds;
#else
layout(binding = 0, rgba32f) uniform writeonly image2D o_clouds;
#endif
layout(location = 0) uniform ivec2 u_place;                // of this frame's rays in their blocks
layout(location = 1) uniform int u_mode;                   // of History (systems/clouds/history.py): see below
layout(location = 2) uniform mat3 u_to_previous;           // camera coordinates to those of the frame before
layout(location = 5) uniform vec3 u_camera_shift_m;
// of the camera before: 1 / frame.projection_scale, and frame.projection_offset
layout(location = 6) uniform vec2 u_previous_per_scale;
layout(location = 9) uniform vec2 u_previous_offset;
layout(location = 10) uniform vec2 u_offset;               // frame.projection_offset without the frame's jitter
layout(location = 7) uniform float u_weight;               // of this frame's ray where there is a history
layout(location = 11) uniform float u_wider;               // history may be than what rays have seen, of their span
// of the checkerboard of blocks with a ray of this frame, as in view_ray.glsl
layout(location = 8) uniform int u_checkerboard;

const int MOVING = 1, STILL = 2;   // the camera; 0: no history

const float SAME_SURFACE = 0.7;     // ratio of distances from frame to frame, and across a pixel's step
// Half of what is shown is new where the camera comes nearer by 1 / 45 in a frame, and of slower ways as their squares
// say: between the rays of a pixel, sixteen frames or more, those change little of what it shows.
const float APPROACH = 45.0;
const float GROWN = 1.0 / 25.0;   // one by the number of frames after which a pixel in the picture counts as any other

// Four rays around some pixels, and what history may be by each and its neighbours: what they have seen, and u_wider.
struct FourRays {
    vec4 color[4], least[4], largest[4];
    vec4 distance_m, depth;   // a component for each: of the clouds; of the surface that it ended on
    vec4 lowest, highest;     // of all
    float nearest, farthest;  // depths
};

// What a pixel may be, by the rays around it.
struct Neighbours {
    vec4 low, high, upsampled;
    float distance_m;
};

struct History {
    bool valid;
    float young;   // how much of it the next mean of rays is, of what came into the picture lately
    vec4 color, clamped;
};

// The same for all pixels of an invocation.
vec2 g_size, g_per_pixel;   // of the clouds' picture, and 1 / that
vec2 g_fill;        // of that picture by the frame: an odd one leaves part of the last row and column beside it
float g_rush;       // m

vec4 blend(vec4 values[4], vec4 weight) {
    return weight.x * values[0] + weight.y * values[1] + weight.z * values[2] + weight.w * values[3];
}

// Textures show their nearest texel, beyond the edge the last one: on software GPUs in less than half of the time of
// texelFetch.
FourRays rays_around(ivec2 corner, ivec2 place) {
    ivec2 size = textureSize(u_depth, 0), most = textureSize(u_rays, 0) - 1;
    vec2 per_ray = 1.0 / vec2(most + 1);
    FourRays r;
    for (int i = 0; i < 4; ++i) {
        ivec2 from = clamp(corner + ivec2(i & 1, i >> 1), ivec2(0), most);
        vec2 at = (vec2(from) + 0.5) * per_ray;
        r.color[i] = textureLod(u_filtered, at, 0.0);
        r.least[i] = vec4(1e9);
        r.largest[i] = vec4(-1e9);
        r.distance_m[i] = min(textureLod(u_distance, at, 0.0).r, 1e8);
        r.depth[i] = texelFetch(u_depth, min(from * STRIDE + place, size - 1), 0).r;
    }
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            vec4 ray = textureLod(u_rays, (vec2(corner + ivec2(x, y)) - 0.5) * per_ray, 0.0);
            for (int i = 0; i < 4; ++i) {
                if (abs(x - 1 - (i & 1)) < 2 && abs(y - 1 - (i >> 1)) < 2) {
                    r.least[i] = min(r.least[i], ray);
                    r.largest[i] = max(r.largest[i], ray);
                }
            }
        }
    }
    r.lowest = min(min(r.least[0], r.least[1]), min(r.least[2], r.least[3]));
    r.highest = max(max(r.largest[0], r.largest[1]), max(r.largest[2], r.largest[3]));
    for (int i = 0; i < 4; ++i) {
        vec4 more = u_wider * (r.largest[i] - r.least[i]);
        // Not beyond what there can be: no light, and all of what is behind.
        r.least[i] = max(r.least[i] - more, min(r.least[i], 0.0));
        r.largest[i] += more;
        r.largest[i].a = min(r.largest[i].a, 1.0);
    }
    r.nearest = max(max(r.depth.x, r.depth.y), max(r.depth.z, r.depth.w));
    r.farthest = min(min(r.depth.x, r.depth.y), min(r.depth.z, r.depth.w));
    return r;
}

// share: of the way from the first ray to the last, x and y; depth: of the pixel.
Neighbours neighbours_at(FourRays r, vec2 share, float depth) {
    vec2 rest = 1.0 - share;
    // Depth is near / distance: its ratio is that of the distances. Of depths that this pixel's is 1 in, or 0 for the
    // sky.
    float per_depth = 1.0 / max(depth, 1e-20);
    vec4 ends = min(r.depth * per_depth, 1e3), apart = ends - depth * per_depth, larger = max(ends, 1.0);
    apart *= apart;
    larger *= larger;
    // (bilinear + 1e-3) / (1e-3 + unlike^2) of each with unlike = apart / larger, over a common denominator: divisions
    // are slow.
    vec4 bilinear = vec4(rest.x * rest.y, share.x * rest.y, rest.x * share.y, share.x * share.y),
        under = 1e-3 * larger + apart,
        weight = (bilinear + 1e-3) * larger * vec4(under.yx * (under.z * under.w), under.wz * (under.x * under.y));
    float per = 1.0 / (weight.x + weight.y + weight.z + weight.w);
    // Continuous over the picture. Where all that is seen around is alike, so are these and the colour, to the bit.
    vec4 low = blend(r.least, bilinear), high = blend(r.largest, bilinear);
    return Neighbours(low, high, clamp(blend(r.color, weight * per), low, high), per * dot(weight, r.distance_m));
}

// By a cubic (Catmull and Rom 1974): what moves is looked up anew in each frame, and linear look-ups would leave half
// of its relief. One linear look-up has the four texels around; of the eight beside them, which have small weights, one
// of two is enough. The corners' weights count for the middle.
vec4 history_at(vec2 uv) {
    vec2 at = uv * g_size - 0.5, first = floor(at), f = at - first, less = 0.5 * f * (1.0 - f),
        middle = (first + 0.5 + f - less * (1.0 - less) * (1.0 - 2.0 * f)) * g_per_pixel,
        low = (first - 0.5) * g_per_pixel, high = (first + 2.5) * g_per_pixel, side = less * (1.0 + less.yx);
    vec4 along = mix(textureLod(u_history_texels, vec2(low.x, middle.y), 0.0),
        textureLod(u_history_texels, vec2(high.x, middle.y), 0.0), f.x);
    vec4 up = mix(textureLod(u_history_texels, vec2(middle.x, low.y), 0.0),
        textureLod(u_history_texels, vec2(middle.x, high.y), 0.0), f.y);
    return (1.0 + side.x + side.y) * textureLod(u_history, middle, 0.0) - side.x * along - side.y * up;
}

// The pixel's clouds, at their mean distance, in the frame before: x to the right, y up, z forward.
History reprojected(FourRays r, Neighbours n, ivec2 pixel, float depth) {
    vec2 here = ndc_of_pixel((vec2(pixel) + 0.5) * float(PICTURE_PX));
    // A pixel's history is the mean of rays anywhere in it. Were it looked up where this frame's jitter goes, it would
    // be interpolated anew in each frame, and lose all detail before the pixel's next ray.
    vec2 slope = here * frame.projection_scale + u_offset;
    vec3 then = u_to_previous * (vec3(slope, 1.0) * (n.distance_m * inversesqrt(1.0 + dot(slope, slope))))
        + u_camera_shift_m;
    vec2 ndc = (then.xy / max(then.z, 1e-6) - u_previous_offset) * u_previous_per_scale;
    vec2 uv = u_mode == STILL ? (vec2(pixel) + 0.5) * g_per_pixel : (0.5 + 0.5 * ndc) * g_fill;
    bool inside = u_mode == STILL || (u_mode == MOVING && then.z > 0.0 && all(lessThan(abs(ndc), vec2(1.0))));
    // Where another surface was, what was seen up to it says nothing. A moving camera finds outlines a little aside.
    // But clouds over ground are never those over the sky: beyond the limb they would stand in space.
    float then_depth = textureLod(u_history_depth, uv, 0.0).r;
    vec2 alike = u_mode == STILL || depth <= 0.0 ? vec2(depth) : vec2(min(depth, r.farthest), max(depth, r.nearest));
    bool valid = inside && then_depth >= SAME_SURFACE * alike.x && SAME_SURFACE * then_depth <= alike.y;
    // A pixel that has been in the picture for a few frames only has had no ray of its own. What it shows is the mean
    // of what the rays around it have told in all of these: of one frame alone, columns that came in one after the
    // other would be seen as stripes. At this pace it came in so many frames ago:
    vec2 motion = ndc - here, per_frames = abs(motion) / max(1.0 - here * sign(motion), 1e-4);
    float per = max(per_frames.x, per_frames.y), young = max(per / (1.0 + per) - GROWN, 0.0);
    vec4 color = history_at(uv);
    return History(valid, u_mode == STILL ? 0.0 : young, color, u_mode == STILL ? color : clamp(color, n.low, n.high));
}

// fresh: the pixel has had its own ray in this frame.
vec4 resolved(Neighbours n, History history, vec4 ray, bool fresh) {
#ifdef VALIDITY
    // For the debug view: red without a history, green with one, towards yellow as far as it had to be clamped; paler
    // where this frame's ray is.
    vec4 apart = abs(history.color - history.clamped) / max(n.high - n.low + 1e-6, vec4(1e-6));
    float changed = clamp(max(max(apart.r, apart.g), max(apart.b, apart.a)), 0.0, 1.0);
    vec3 shade = history.valid
        ? mix(vec3(0.10, 0.55, 0.20), vec3(0.95, 0.80, 0.10), changed)
        : vec3(0.80, 0.12, 0.10);
    return vec4(fresh ? mix(shade, vec3(1.0), 0.35) : shade, 1.0);
#else
    // What a camera flies up to shows more of itself from frame to frame than one ray in a block tells.
    float rush = g_rush / n.distance_m,
        new = u_mode == STILL ? 0.0 : max(rush * rush / (1.0 + rush * rush), history.young);
    vec4 color = history.valid
        ? mix(fresh ? mix(history.clamped, ray, u_weight) : history.clamped, n.upsampled, new)
        : fresh && u_checkerboard < 0 ? ray : n.upsampled;
    // Light may be less than none: what the air in shadow doesn't scatter is taken off.
    return vec4(color.rgb, max(color.a, 0.0));
#endif
}

void main() {
    ivec2 size = textureSize(u_depth, 0), most = textureSize(u_rays, 0) - 1, place = max(u_place, 0);
    ivec2 corner = ivec2(gl_GlobalInvocationID.xy) - 1, first = corner * STRIDE + place;
    if (any(greaterThanEqual(first, size))) return;
    FourRays r = rays_around(corner, place);
    vec4 ray = textureLod(u_rays, (vec2(clamp(corner, ivec2(0), most)) + 0.5) * (1.0 / vec2(most + 1)), 0.0);
    int busy = STRIDE * STRIDE;
#ifndef VALIDITY
    // What a moving camera's history is clamped to may be nothing at all.
    busy = u_mode != STILL && r.lowest == vec4(0.0, 0.0, 0.0, 1.0) && r.highest == r.lowest ? 0 : busy;
    for (int k = busy; k < STRIDE * STRIDE; ++k) {
        imageStore(o_clouds, first + ivec2(k % STRIDE, k / STRIDE), vec4(0.0, 0.0, 0.0, 1.0));
    }
#endif
    g_size = vec2(size);
    g_per_pixel = 1.0 / g_size;
    g_fill = frame.viewport_px / vec2(size * PICTURE_PX);
    g_rush = APPROACH * length(u_camera_shift_m);
    bool followed = u_place.x >= 0 && all(greaterThanEqual(corner, ivec2(0)))
        && (u_checkerboard < 0 || ((corner.x + corner.y + u_checkerboard) & 1) == 0);
    // Writes beside the picture do nothing.
    for (int k = 0; k < busy; ++k) {
        ivec2 step_ = ivec2(k % STRIDE, k / STRIDE), pixel = first + step_;
        float depth = textureLod(u_depth, (vec2(pixel) + 0.5) * g_per_pixel, 0.0).r;
        Neighbours n = neighbours_at(r, vec2(step_) / float(STRIDE), depth);
        imageStore(o_clouds, pixel, resolved(n, reprojected(r, n, pixel, depth), ray, k == 0 && followed));
    }
}
