// A box around where a prop takes light away: a long one away from the sun (even instances), one around it (odd ones).
#include "common/camera.glsl"
#include "props/instance.glsl"
#include "props/shadow.glsl"

layout(std430, binding = 0) readonly buffer OccluderBuffer { PropOccluder occluders[]; };

flat out int v_prop;
flat out int v_around;

void main() {
    v_prop = gl_InstanceID >> 1;
    v_around = gl_InstanceID & 1;
    PropOccluder prop = occluders[v_prop];
    float radius = prop_radius(prop), length_m = prop_shadow_m(prop);
    vec3 sun = frame.sun_direction.xyz;
    vec3 u = normalize(cross(sun, abs(sun.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0))), w = cross(sun, u);
    // Corners of a cube as triangles, from the vertex's number: 6 faces of 2 triangles.
    int face = gl_VertexID / 6, corner = gl_VertexID % 6;
    vec2 place = vec2[6](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1))[corner];
    int axis = face >> 1;
    float side = (face & 1) == 0 ? -1.0 : 1.0;
    vec3 cube = axis == 0 ? vec3(side, place.x * side, place.y) : axis == 1 ? vec3(place.y, side, place.x * side)
        : vec3(place.x * side, place.y, side);
    float wide = v_around == 1 ? radius * PROP_REACH : radius + length_m * frame.sun_direction.w;
    float low = v_around == 1 ? -wide : -length_m, high = v_around == 1 ? wide : radius;
    vec3 point = prop.place.xyz + (u * cube.x + w * cube.y) * wide + sun * mix(low, high, cube.z * 0.5 + 0.5);
    gl_Position = clip_position(point);
    if (v_around == 0 && length_m <= 0.0) gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
}
