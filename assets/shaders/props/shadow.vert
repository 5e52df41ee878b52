// A box around where a prop takes light away: the sky's, around it (AROUND 1), or the sun's, a long one behind it.
#include "common/camera.glsl"
#include "props/instance.glsl"
#include "props/shadow.glsl"

layout(std430, binding = 0) readonly buffer OccluderBuffer { PropOccluder occluders[]; };

flat out int v_prop;

void main() {
    v_prop = gl_InstanceID;
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
#if AROUND
    float wide = radius * PROP_REACH, low = -wide, high = wide;
#else
    float wide = radius + length_m * frame.sun_direction.w, low = -length_m, high = radius;
#endif
    vec3 point = prop.place.xyz + (u * cube.x + w * cube.y) * wide + sun * mix(low, high, cube.z * 0.5 + 0.5);
    gl_Position = clip_position(point);
#if !AROUND
    if (length_m <= 0.0) gl_Position = vec4(2.0, 2.0, 0.0, 1.0);   // the sun has set for it
#endif
}
