// Which cells can be seen: one workgroup walks over all of them and writes the indirect draw. No atomics outside shared memory,
// nothing to clear before.
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = 5) readonly buffer BoundsBuffer { CellBounds bounds[]; };
layout(std430, binding = 2) writeonly buffer VisibleBuffer { uint visible[]; };
layout(std430, binding = 3) writeonly buffer ArgumentsBuffer { uint arguments[]; };
uniform int u_cell_count;
uniform int u_index_count;
uniform vec2 u_keep_dh;   // cells that reach no dh between these are dropped (no bed under an opaque sea, no sea under land)

shared uint s_count;

bool box_outside(vec3 normal, vec3 low, vec3 high) {
    // The corner farthest along the inward normal is outside: all of the box is.
    vec3 corner = mix(low, high, greaterThan(normal, vec3(0.0)));
    return dot(normal, corner) < 0.0;
}

void main() {
    if (gl_LocalInvocationID.x == 0u) s_count = 0u;
    barrier();

    // Inward normals of the four side planes through the camera; slightly widened so that rounding never drops a pixel.
    vec3 right = frame.camera_right.xyz, up = frame.camera_up.xyz, forward = frame.camera_forward.xyz;
    vec2 low_tan = frame.projection.zw - frame.projection.xy * 1.001;
    vec2 high_tan = frame.projection.zw + frame.projection.xy * 1.001;
    vec3 left_normal = right - forward * low_tan.x, right_normal = forward * high_tan.x - right;
    vec3 bottom_normal = up - forward * low_tan.y, top_normal = forward * high_tan.y - up;

    // The straight line between two points above a sphere is free only if it is no longer than the sum of their tangents.
    float occluder = planet.radii.x + planet.radii.w;
    float camera_above = max(frame.camera_zenith.w - planet.radii.w, 0.0);
    float camera_tangent = sqrt(camera_above) * sqrt(2.0 * occluder + camera_above);

    for (int first = 0; first < u_cell_count; first += 256) {
        int index = first + int(gl_LocalInvocationID.x);
        bool seen = index < u_cell_count;
        CellBounds box = bounds[min(index, u_cell_count - 1)];
        vec3 low = box.low.xyz - frame.camera_offset.xyz, high = box.high.xyz - frame.camera_offset.xyz;
        vec3 pad = 1e-6 * (abs(low) + abs(high));
        low -= pad;
        high += pad;
        seen = seen && !(box_outside(left_normal, low, high) || box_outside(right_normal, low, high)
            || box_outside(bottom_normal, low, high) || box_outside(top_normal, low, high) || box_outside(forward, low, high));
        float cell_above = max(box.high.w + frame.anchor_up.w - planet.radii.w, 0.0);
        float cell_tangent = sqrt(cell_above) * sqrt(2.0 * occluder + cell_above);
        vec3 nearest = clamp(vec3(0.0), low, high);
        seen = seen && length(nearest) <= (camera_tangent + cell_tangent) * 1.0001 + 0.01;
        seen = seen && box.high.w >= u_keep_dh.x && box.low.w <= u_keep_dh.y;
        if (seen) visible[atomicAdd(s_count, 1u)] = uint(index);
    }
    barrier();
    if (gl_LocalInvocationID.x == 0u) {
        arguments[0] = uint(u_index_count);
        arguments[1] = s_count;
        arguments[2] = 0u;
        arguments[3] = 0u;
        arguments[4] = 0u;
    }
}
