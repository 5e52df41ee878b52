// A rectangle around each fall's spray, all of the picture for a camera that is close.
#include "common/camera.glsl"
#include "terrain/spray.glsl"

in vec4 in_foot;   // xyz, density
in vec4 in_up;     // xyz, height
in vec4 in_way;    // xyz, half width
in float in_seed;
in vec4 in_risen;  // whole cells of both octaves of puffs, and the rest
in vec4 in_beam, in_diffuse, in_dense, in_loss, in_air;   // terrain/spray_light.comp

flat out vec4 v_foot;
flat out vec4 v_up;
flat out vec4 v_way;
flat out float v_seed;
flat out vec4 v_risen;
flat out vec4 v_beam, v_diffuse, v_dense, v_loss, v_air;

// Around all of it, low (xy) and high (zw); of the whole picture if some is beside the camera or behind.
vec4 spray_bounds(Spray s) {
    vec3 low = vec3(3e38), high = vec3(-3e38), across = cross(s.up, s.way);
    for (int k = 0; k < SPRAY_CLOUDS; ++k) {
        vec4 middle;
        vec3 deviation;
        spray_cloud(s, k, middle, deviation);
        low = min(low, middle.xyz - SPRAY_DEVIATIONS * deviation);
        high = max(high, middle.xyz + SPRAY_DEVIATIONS * deviation);
    }
    vec4 bounds = vec4(1e9, 1e9, -1e9, -1e9);
    int ahead = 0;
    for (int k = 0; k < 8; ++k) {
        vec3 at = mix(low, high, vec3(k & 1, (k >> 1) & 1, k >> 2));
        vec4 clip = clip_position(s.foot + s.way * at.x + across * at.y + s.up * at.z);
        ahead += clip.w > 0.1 ? 1 : 0;
        vec2 ndc = clip.xy / max(clip.w, 0.1);
        bounds = vec4(min(bounds.xy, ndc), max(bounds.zw, ndc));
    }
    return ahead == 8 ? bounds : ahead == 0 ? vec4(-2.0) : vec4(-1.0, -1.0, 1.0, 1.0);
}

void main() {
    v_foot = in_foot;
    v_up = in_up;
    v_way = in_way;
    v_seed = in_seed;
    v_risen = in_risen;
    v_beam = in_beam;
    v_diffuse = in_diffuse;
    v_dense = in_dense;
    v_loss = in_loss;
    v_air = in_air;
    Spray s = Spray(in_foot.xyz, in_up.xyz, in_way.xyz, in_up.w, in_way.w, in_foot.w, in_seed);
    vec4 bounds = clamp(spray_bounds(s), -2.0, 2.0);
    gl_Position = vec4(mix(bounds.xy, bounds.zw, vec2(gl_VertexID & 1, gl_VertexID >> 1)), 0.5, 1.0);
}
