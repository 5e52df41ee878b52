// Temporal anti-aliasing of a camera or a scene that moves: the history, reprojected to where this pixel's surface was
// in the last frame, tested for being the same surface, clipped to what this frame sees around the pixel (variance
// clipping, Salvi 2016), and blended with this frame's sample. docs/antialiasing.md has the reasons for the constants.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "composite/exposure.glsl"
#include "common/surfaces.glsl"
#include "composite/resolved.glsl"

layout(binding = 0) uniform sampler2D u_scene;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform usampler2D u_surface;
layout(binding = 3) uniform sampler2D u_history;    // resolved picture of the last frame, linear
#ifdef MOTION
layout(binding = 4) uniform sampler2D u_motion;      // props.motion
#endif
layout(std430, binding = EXPOSURE_BUFFER) readonly buffer ExposureIn { Exposure exposure; };
layout(std430, binding = EXPOSURE_BEFORE_BUFFER) readonly buffer ExposureBefore { Exposure exposure_before; };
layout(location = 0) uniform mat3 u_to_previous;       // camera coordinates to those of the frame before
layout(location = 3) uniform mat3 u_sky_to_previous;   // the same for what is infinitely far
layout(location = 6) uniform vec3 u_camera_shift_m;
// of the camera before: 1 / frame.projection_scale, and frame.projection_offset
layout(location = 7) uniform vec2 u_previous_per_scale;
layout(location = 16) uniform vec2 u_previous_offset;
layout(location = 8) uniform vec2 u_jitter;          // of this frame in normalised device coordinates
layout(location = 9) uniform float u_weights[5];     // of the samples around, for a picture of this frame alone
layout(location = 14) uniform float u_water;         // (phase by which a wave of 1 m goes on in this frame)^2, rad^2 m
// share of the pixels around, where every second pixel has light of its own
layout(location = 15) uniform float u_checkered_ground;
layout(location = 17) uniform float u_checkered_sea;
in vec2 v_uv;
layout(location = 0) out vec4 o_resolved;

const float LEAST_WEIGHT = 1.0 / 16.0;
// where the fetch falls between texels: a blur that adds up from frame to frame
const float MOVING_WEIGHT = 1.0 / 4.0;
const float TOLERANCE = 1.12;            // of distances; they are kept in steps of 2 %
const float DEVIATIONS = 1.75;
const float WAVE_PX = 4.0;          // waves half as long have gone, see ocean/waves.glsl
const float WATER_WEIGHT = 2.0;   // least errors over moving swell, from 5 m and from 1 km
const vec2 CROSS[5] = vec2[5](vec2(0.0, -1.0), vec2(-1.0, 0.0), vec2(0.0), vec2(1.0, 0.0), vec2(0.0, 1.0));

// Cubic convolution (Keys 1981) without the corners of the 4 x 4 texels, which weigh next to nothing (Jimenez 2016,
// "Filmic SMAA"). A little sharper than Catmull-Rom (-0.5), since it is done again in every frame: least errors along
// flights.
const float CUBIC = -0.65;

// The light; w: what lies at the nearest texel. Twelve texels and not five bilinear look-ups: software GPUs take longer
// over those.
vec4 history(vec2 uv) {
    vec2 size = vec2(textureSize(u_history, 0)), texel = 1.0 / size;
    vec2 place = uv * size, middle = floor(place - 0.5) + 0.5, f = place - middle, at = middle * texel;
    vec2 w0 = CUBIC * f * (f * (f - 2.0) + 1.0), w1 = f * f * ((CUBIC + 2.0) * f - (CUBIC + 3.0)) + 1.0;
    vec2 w2 = f * (f * (2.0 * CUBIC + 3.0 - (CUBIC + 2.0) * f) - CUBIC), w3 = CUBIC * f * f * (1.0 - f);
    vec4 a = textureLod(u_history, at, 0.0), b = textureLod(u_history, at + vec2(texel.x, 0.0), 0.0);
    vec4 c = textureLod(u_history, at + vec2(0.0, texel.y), 0.0), d = textureLod(u_history, at + texel, 0.0);
    vec3 upper = w0.x * textureLod(u_history, at - vec2(texel.x, 0.0), 0.0).rgb + w1.x * a.rgb + w2.x * b.rgb
        + w3.x * textureLod(u_history, at + vec2(2.0 * texel.x, 0.0), 0.0).rgb;
    vec3 lower = w0.x * textureLod(u_history, at + vec2(-texel.x, texel.y), 0.0).rgb + w1.x * c.rgb + w2.x * d.rgb
        + w3.x * textureLod(u_history, at + vec2(2.0, 1.0) * texel, 0.0).rgb;
    vec3 above = w1.x * textureLod(u_history, at - vec2(0.0, texel.y), 0.0).rgb
        + w2.x * textureLod(u_history, at + vec2(texel.x, -texel.y), 0.0).rgb;
    vec3 below = w1.x * textureLod(u_history, at + vec2(0.0, 2.0 * texel.y), 0.0).rgb
        + w2.x * textureLod(u_history, at + vec2(1.0, 2.0) * texel, 0.0).rgb;
    vec3 total = w1.y * upper + w2.y * lower + w0.y * above + w3.y * below;
    vec2 near = f.y < 0.5 ? vec2(a.a, b.a) : vec2(c.a, d.a);
    // Each axis' weights add up to 1.
    return vec4(clamp(total / (1.0 - (w0.x + w3.x) * (w0.y + w3.y)), 0.0, 1.0), f.x < 0.5 ? near.x : near.y);
}

// Depths of this pixel and of the pixels around it, and where the nearest of them is.
struct DepthsAround {
    float own, nearest, farthest;
    vec2 front;
};

// Where this pixel's surface was in the last frame.
struct Reprojected {
    vec2 uv;
    bool inside;
    float near_per_m;   // 1 / distance of the nearest surface around, as the last frame saw it
};

// Colours around, pressed.
struct ColorsAround {
    vec3 own, sum, mean, spread, alone;   // spread: half the range of what is likely; alone: without any history
};

DepthsAround depths_around() {
    float own = textureLod(u_depth, v_uv, 0.0).r;
    DepthsAround found = DepthsAround(own, own, own, v_uv);
    for (int k = 0; k < 4; k++) {
        vec2 at = v_uv + (vec2(k & 1, k >> 1) * 2.0 - 1.0) * frame.texel_size;
        float depth = textureLod(u_depth, at, 0.0).r;
        found.front = depth > found.nearest ? at : found.front;
        found.nearest = max(found.nearest, depth);
        found.farthest = min(found.farthest, depth);
    }
    return found;
}

// By the motion of the nearest surface around: along an outline the outline's, on both sides of it.
Reprojected reprojected(DepthsAround d) {
    vec2 ndc = ndc_of_pixel(gl_FragCoord.xy);
    vec3 ray = vec3(ndc * frame.projection_scale + frame.projection_offset, 1.0);
    float per_m = d.nearest * (1.0 / frame.near_m);
    vec3 ground = u_to_previous * ray + u_camera_shift_m * per_m;
    bool known = true;
#ifdef MOTION
    // A body that moves by itself came from elsewhere, or from nowhere.
    vec4 motion = textureLod(u_surface, d.front, 0.0).r == SURFACE_PROPS ? textureLod(u_motion, d.front, 0.0)
        : vec4(0.0, 0.0, 0.0, 1.0);
    known = motion.w > 0.5;
    ground += u_to_previous * (per_m * vec3(dot(frame.camera_right, motion.xyz), dot(frame.camera_up, motion.xyz),
        dot(frame.camera_forward, motion.xyz)));
#endif
    vec3 then = d.nearest > 0.0 ? ground : u_sky_to_previous * ray;
    float per_z = 1.0 / then.z;
    vec2 before = (then.xy * per_z - u_previous_offset) * u_previous_per_scale;
    vec2 uv = v_uv + 0.5 * (before - ndc - u_jitter);
    bool inside = known && then.z > 0.0 && all(greaterThan(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
    return Reprojected(clamp(uv, 0.0, 1.0), inside, per_m * per_z);
}

// Whether the history of that code shows this pixel's surface: where its surfaces would have been seen from there;
// anything else is another one.
bool same_surface(int code, uint kind, DepthsAround d, Reprojected then) {
    uint was_kind = uint(code >> 6) & 7u;
    float was_per_m = place_per_m(code >> 9), far_then = then.near_per_m * d.farthest / max(d.nearest, 1e-30);
    bool near = was_per_m <= then.near_per_m * TOLERANCE && was_per_m * TOLERANCE >= far_then;
    // Land and sea change places along a coast with every jitter; a body that was here and is not has gone.
    return near && (was_kind == kind || max(was_kind, kind) <= SURFACE_SEA || d.farthest < 0.9 * d.nearest);
}

// Mean and variance of this pixel and its four neighbours.
ColorsAround colors_around(bool sky) {
    ColorsAround c;
    float scale = frame.radiance_per_hdr;
    vec3 squares = vec3(0.0), most = vec3(0.0);
    c.sum = c.alone = vec3(0.0);
    for (int k = 0; k < 5; k++) {
        vec3 around = press(exposed_light(textureLod(u_scene, v_uv + CROSS[k] * frame.texel_size, 0.0).rgb * scale,
            exposure.saturated));
        if (k == 2) c.own = around;
        c.sum += around;
        squares += around * around;
        c.alone += around * u_weights[k];
        most = max(most, around);
    }
    c.mean = c.sum * 0.2;
    c.spread = DEVIATIONS * sqrt(max(squares * 0.2 - c.mean * c.mean, 0.0)) + 1e-6;
    // Stars stand out of their surroundings by more than that, and what is infinitely far uncovers nothing.
    if (sky) c.spread = max(c.spread, most - c.mean);
    return c;
}

// Of this frame's sample against `frames` of history that lies `out_by` times beyond the likely range.
float sample_weight(int frames, float out_by, vec2 uv, uint kind, float depth) {
    vec2 between = fract((uv - v_uv) * vec2(textureSize(u_scene, 0)));
    between *= 4.0 * (1.0 - between);
    float weight = max(out_by / float(frames + 1), mix(LEAST_WEIGHT, MOVING_WEIGHT, max(between.x, between.y)));
    weight = max(weight, clamp(0.25 * out_by - 0.5, 0.0, 1.0));   // what is that far off was something else
    // Water moves on by itself, and not as one: the shortest waves that a pixel shows, WAVE_PX long, go on by this
    // phase, and what was seen of them then is worth as little.
    if (kind == SURFACE_SEA) weight = max(weight,
        WATER_WEIGHT * sqrt(u_water * depth * (1.0 / frame.near_m) / (frame.pixel_rad * WAVE_PX)));
    return weight;
}

// Textures show their nearest texel, beyond the edge the last one: on software GPUs in less than half of the time of
// texelFetch.
void main() {
    uint kind = textureLod(u_surface, v_uv, 0.0).r;
    DepthsAround d = depths_around();
    Reprojected then = reprojected(d);
    vec4 previous = history(then.uv);
    int code = int(previous.a), frames = then.inside && same_surface(code, kind, d, then) ? code & PLACE_FRAMES : 0;

    ColorsAround c = colors_around(d.nearest == 0.0);
    vec3 light = press_again(previous.rgb, exposure_before.saturated / exposure.saturated);
    vec3 off = abs(light - c.mean) / c.spread;
    float out_by = max(max(off.r, max(off.g, off.b)), 1.0);
    light = c.mean + (light - c.mean) * (1.0 / out_by);
    float weight = sample_weight(frames, out_by, then.uv, kind, d.own);
    // The more a frame counts, the more of a checkerboard of pixels with light of their own and without would be seen.
    float checkered = kind == SURFACE_TERRAIN ? u_checkered_ground : kind == SURFACE_SEA ? u_checkered_sea : 0.0;
    float counts = clamp((weight - LEAST_WEIGHT) / (MOVING_WEIGHT - LEAST_WEIGHT), 0.0, 1.0);
    vec3 now = mix(c.own, 0.25 * (c.sum - c.own), checkered * counts);
    light = frames > 0 ? mix(light, now, min(weight, 1.0)) : c.alone;
    o_resolved = vec4(light, place_code(place_distance(d.own * (1.0 / frame.near_m)), kind, frames + 1));
}
