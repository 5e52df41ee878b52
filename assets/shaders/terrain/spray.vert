// A rectangle around each fall's spray; all of the picture for a camera that is inside.
#include "common/camera.glsl"
#include "terrain/spray.glsl"

in vec4 in_foot;   // xyz, density
in vec4 in_up;     // xyz, height
in vec4 in_way;    // xyz, half width
in float in_seed;

flat out vec4 v_foot;
flat out vec4 v_up;
flat out vec4 v_way;
flat out float v_seed;

void main() {
    v_foot = in_foot;
    v_up = in_up;
    v_way = in_way;
    v_seed = in_seed;
    float reach = spray_reach(Spray(in_foot.xyz, in_up.xyz, in_way.xyz, in_up.w, in_way.w, in_foot.w, in_seed));
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    float ahead = dot(in_foot.xyz, frame.camera_forward);
    if (length(in_foot.xyz) > 1.5 * reach && ahead > reach) {
        // Of a cube around it, whose near face is the widest.
        vec2 centre = vec2(dot(in_foot.xyz, frame.camera_right), dot(in_foot.xyz, frame.camera_up));
        vec2 low = vec2((centre.x - reach) / (centre.x > reach ? ahead + reach : ahead - reach),
            (centre.y - reach) / (centre.y > reach ? ahead + reach : ahead - reach));
        vec2 high = vec2((centre.x + reach) / (centre.x > -reach ? ahead - reach : ahead + reach),
            (centre.y + reach) / (centre.y > -reach ? ahead - reach : ahead + reach));
        corner = (mix(low, high, 0.5 + 0.5 * corner) - frame.projection_offset) / frame.projection_scale;
    } else if (ahead < -reach) {
        corner = vec2(-2.0);   // behind
    }
    gl_Position = vec4(clamp(corner, -2.0, 2.0), 0.5, 1.0);
}
