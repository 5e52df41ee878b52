// Anti-aliasing of a camera or a scene that moves: the last frame's picture, fetched from where this pixel's surface
// was then, tested for being the same surface, held within what this frame sees around the pixel, and mixed with this
// frame's sample.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "composite/exposure.glsl"
#include "common/surfaces.glsl"
#include "composite/resolved.glsl"

layout(binding = 0) uniform sampler2D u_scene;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform usampler2D u_surface;
layout(binding = 3) uniform sampler2D u_before;     // resolved picture of the last frame, linear
#ifdef MOTION
layout(binding = 4) uniform sampler2D u_motion;      // props.motion
#endif
layout(std430, binding = EXPOSURE_BUFFER) readonly buffer ExposureIn { Exposure exposure; };
layout(std430, binding = EXPOSURE_BEFORE_BUFFER) readonly buffer ExposureBefore { Exposure exposure_before; };
layout(location = 0) uniform mat3 u_turn;            // camera coordinates to those of the frame before
layout(location = 3) uniform mat3 u_sky_turn;        // the same for what is infinitely far
layout(location = 6) uniform vec3 u_shift;           // m
layout(location = 7) uniform vec4 u_projection;      // of the frame before: 1 / sx, 1 / sy, ox, oy
layout(location = 8) uniform vec2 u_jitter;          // of this frame in normalised device coordinates
layout(location = 9) uniform float u_weights[5];     // of the samples around, for a picture of this frame alone
layout(location = 14) uniform float u_water;         // (phase by which a wave of 1 m goes on in this frame)^2, rad^2 m
// share of the pixels around, where every second has light of its own: of ground, of sea
layout(location = 15) uniform vec2 u_checkered;
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
    vec2 size = vec2(textureSize(u_before, 0)), texel = 1.0 / size;
    vec2 place = uv * size, middle = floor(place - 0.5) + 0.5, f = place - middle, at = middle * texel;
    vec2 w0 = CUBIC * f * (f * (f - 2.0) + 1.0), w1 = f * f * ((CUBIC + 2.0) * f - (CUBIC + 3.0)) + 1.0;
    vec2 w2 = f * (f * (2.0 * CUBIC + 3.0 - (CUBIC + 2.0) * f) - CUBIC), w3 = CUBIC * f * f * (1.0 - f);
    vec4 a = textureLod(u_before, at, 0.0), b = textureLod(u_before, at + vec2(texel.x, 0.0), 0.0);
    vec4 c = textureLod(u_before, at + vec2(0.0, texel.y), 0.0), d = textureLod(u_before, at + texel, 0.0);
    vec3 upper = w0.x * textureLod(u_before, at - vec2(texel.x, 0.0), 0.0).rgb + w1.x * a.rgb + w2.x * b.rgb
        + w3.x * textureLod(u_before, at + vec2(2.0 * texel.x, 0.0), 0.0).rgb;
    vec3 lower = w0.x * textureLod(u_before, at + vec2(-texel.x, texel.y), 0.0).rgb + w1.x * c.rgb + w2.x * d.rgb
        + w3.x * textureLod(u_before, at + vec2(2.0, 1.0) * texel, 0.0).rgb;
    vec3 above = w1.x * textureLod(u_before, at - vec2(0.0, texel.y), 0.0).rgb
        + w2.x * textureLod(u_before, at + vec2(texel.x, -texel.y), 0.0).rgb;
    vec3 below = w1.x * textureLod(u_before, at + vec2(0.0, 2.0 * texel.y), 0.0).rgb
        + w2.x * textureLod(u_before, at + vec2(1.0, 2.0) * texel, 0.0).rgb;
    vec3 total = w1.y * upper + w2.y * lower + w0.y * above + w3.y * below;
    vec2 near = f.y < 0.5 ? vec2(a.a, b.a) : vec2(c.a, d.a);
    // Each axis' weights add up to 1.
    return vec4(clamp(total / (1.0 - (w0.x + w3.x) * (w0.y + w3.y)), 0.0, 1.0), f.x < 0.5 ? near.x : near.y);
}

void main() {
    ivec2 last = textureSize(u_scene, 0) - 1;
    // Textures show their nearest texel, beyond the edge the last one: on software GPUs in less than half of the time
    // of texelFetch.
    vec2 texel = frame.viewport.zw;
    float scale = frame.scale.y;
    vec3 now = press(exposed_light(textureLod(u_scene, v_uv, 0.0).rgb * scale, exposure.saturated));
    uint kind = textureLod(u_surface, v_uv, 0.0).r;
    float own = textureLod(u_depth, v_uv, 0.0).r, nearest = own, farthest = own;
    vec2 front = v_uv;
    for (int k = 0; k < 4; k++) {
        vec2 at = v_uv + (vec2(k & 1, k >> 1) * 2.0 - 1.0) * texel;
        float depth = textureLod(u_depth, at, 0.0).r;
        front = depth > nearest ? at : front;
        nearest = max(nearest, depth);
        farthest = min(farthest, depth);
    }
    // Motion of the nearest surface around: along an outline the outline's, on both sides of it.
    vec2 ndc = ndc_of_pixel(gl_FragCoord.xy);
    vec3 ray = vec3(ndc * frame.projection.xy + frame.projection.zw, 1.0);
    float per_near = 1.0 / frame.camera_offset.w, per_m = nearest * per_near;
    vec3 ground = u_turn * ray + u_shift * per_m;
    bool known = true;
#ifdef MOTION
    // A body that moves by itself came from elsewhere, or from nowhere.
    vec4 motion = textureLod(u_surface, front, 0.0).r == SURFACE_PROPS ? textureLod(u_motion, front, 0.0)
        : vec4(0.0, 0.0, 0.0, 1.0);
    known = motion.w > 0.5;
    ground += u_turn * (per_m * vec3(dot(frame.camera_right.xyz, motion.xyz), dot(frame.camera_up.xyz, motion.xyz),
        dot(frame.camera_forward.xyz, motion.xyz)));
#endif
    vec3 then = nearest > 0.0 ? ground : u_sky_turn * ray;
    float per_z = 1.0 / then.z;
    vec2 before = (then.xy * per_z - u_projection.zw) * u_projection.xy;
    vec2 uv = v_uv + 0.5 * (before - ndc - u_jitter);
    bool seen = known && then.z > 0.0 && all(greaterThan(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
    uv = clamp(uv, 0.0, 1.0);

    vec4 past = history(uv);
    int code = int(past.a);
    int was = code >> 9, frames = code & PLACE_FRAMES;
    uint was_kind = uint(code >> 6) & 7u;
    // Where this pixel's surfaces would have been seen from there; anything else is another surface.
    float was_per_m = place_per_m(was), near_then = per_m * per_z,
        far_then = near_then * farthest / max(nearest, 1e-30);
    seen = seen && was_per_m <= near_then * TOLERANCE && was_per_m * TOLERANCE >= far_then;
    // Land and sea change places along a coast with every jitter; a body that was here and is not has gone.
    seen = seen && (was_kind == kind || max(was_kind, kind) <= SURFACE_SEA || farthest < 0.9 * nearest);
    frames = seen ? frames : 0;

    vec3 light = press_again(past.rgb, exposure_before.saturated / exposure.saturated);
    vec3 sum = vec3(0.0), squares = vec3(0.0), spot = vec3(0.0), most = vec3(0.0);
    for (int k = 0; k < 5; k++) {
        vec3 around = press(exposed_light(textureLod(u_scene, v_uv + CROSS[k] * texel, 0.0).rgb * scale,
            exposure.saturated));
        sum += around;
        squares += around * around;
        spot += around * u_weights[k];
        most = max(most, around);
    }
    vec3 mean = sum * 0.2, spread = DEVIATIONS * sqrt(max(squares * 0.2 - mean * mean, 0.0)) + 1e-6;
    // Stars stand out of their surroundings by more than that, and what is infinitely far uncovers nothing.
    if (nearest == 0.0) spread = max(spread, most - mean);
    vec3 off = abs(light - mean) / spread;
    float out_by = max(max(off.r, max(off.g, off.b)), 1.0);
    light = mean + (light - mean) * (1.0 / out_by);
    vec2 between = fract((uv - v_uv) * vec2(last + 1));
    between *= 4.0 * (1.0 - between);
    float weight = max(out_by / float(frames + 1), mix(LEAST_WEIGHT, MOVING_WEIGHT, max(between.x, between.y)));
    weight = max(weight, clamp(0.25 * out_by - 0.5, 0.0, 1.0));   // what is that far off was something else
    // Water moves on by itself, and not as one: the shortest waves that a pixel shows, WAVE_PX long, go on by this
    // phase, and what was seen of them then is worth as little.
    if (kind == SURFACE_SEA) weight = max(weight,
        WATER_WEIGHT * sqrt(u_water * own * per_near / (frame.clock.w * WAVE_PX)));
    // The more a frame counts, the more of a checkerboard of pixels with light of their own and without would be seen.
    float checkered = kind == SURFACE_TERRAIN ? u_checkered.x : kind == SURFACE_SEA ? u_checkered.y : 0.0;
    float counts = clamp((weight - LEAST_WEIGHT) / (MOVING_WEIGHT - LEAST_WEIGHT), 0.0, 1.0);
    now = mix(now, 0.25 * (sum - now), checkered * counts);
    light = frames > 0 ? mix(light, now, min(weight, 1.0)) : spot;
    o_resolved = vec4(light, place_code(place_distance(own * per_near), kind, frames + 1));
}
