// Which cells can be seen: one workgroup walks over all of them and writes an indirect draw for each index list. No
// atomics outside shared memory, nothing to clear before.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"
#include "common/skyline.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = BOUNDS_BUFFER) readonly buffer BoundsBuffer { CellBounds bounds[]; };
layout(std430, binding = VISIBLE_BUFFER) writeonly buffer VisibleBuffer { uint visible[]; };
layout(std430, binding = ARGUMENTS_BUFFER) writeonly buffer ArgumentsBuffer { DrawCommand draws[]; };
layout(std430, binding = RANGE_BUFFER) readonly buffer RangeBuffer { uvec2 ranges[]; };   // first, count
uniform int u_cell_count;
uniform int u_capacity;   // entries of the visible list for each variant
uniform int u_hides;       // 0: seen from behind (the sea from below), nothing of it hides anything
// cells that reach no dh between these are dropped (no bed under an opaque sea, no sea under land)
uniform vec2 u_keep_dh;

const uint VARIANTS = uint(CELL_LISTS);
const float LIFT = 1.0e6;   // makes heights positive, so that their bits order as integers; 1/16 m steps
shared uint s_count[VARIANTS];
shared uint s_ready, s_next;   // cells before s_ready have raised the skyline
shared int s_lowest;   // lowest dh so far, in an order-preserving integer form

bool box_outside(vec3 normal, vec3 low, vec3 high) {
    // The corner farthest along the inward normal is outside: all of the box is.
    vec3 corner = mix(low, high, greaterThan(normal, vec3(0.0)));
    return dot(normal, corner) < 0.0;
}

// Camera-relative position of a cell's middle vertex.
vec3 cell_middle(uint cell) {
    CellVertex vertex = vertices[CELL_PLACE(cells, cell) * uint(CELL_VERTICES) + uint(CELL_MIDDLE)];
    return vec3(vertex.x, vertex.y, vertex.z) - frame.camera_offset_m;
}

// Inward normals of the frustum's side planes through the camera; slightly widened so that rounding drops no pixel,
// and by a pixel and a half: the jitter of the frames that this list is drawn in is not the one of this frame.
struct SidePlanes {
    vec3 left, right, bottom, top;
};

SidePlanes side_planes() {
    vec3 right = frame.camera_right, up = frame.camera_up, forward = frame.camera_forward;
    vec2 half_tan = frame.projection_scale * (1.001 + 3.0 * frame.texel_size);
    vec2 low_tan = frame.projection_offset - half_tan, high_tan = frame.projection_offset + half_tan;
    return SidePlanes(right - forward * low_tan.x, forward * high_tan.x - right, up - forward * low_tan.y,
        forward * high_tan.y - up);
}

bool outside_frustum(SidePlanes planes, vec3 low, vec3 high) {
    return box_outside(planes.left, low, high) || box_outside(planes.right, low, high)
        || box_outside(planes.bottom, low, high) || box_outside(planes.top, low, high)
        || box_outside(frame.camera_forward, low, high);
}

// Metres to a sphere's horizon from `above` metres over it.
float horizon_distance(float radius_m, float above) {
    return sqrt(above) * sqrt(2.0 * radius_m + above);
}

// How far away a cell may be seen over the sphere of the lowest ground before it: the straight line between two points
// above a sphere is free only if it is no longer than the sum of their tangents. lowest: height of that sphere.
float longest_sight(CellBounds box, float spacing_m, float lowest) {
    float occluder = planet.radius_m + lowest;
    float camera_tangent = horizon_distance(occluder, max(frame.camera_altitude_m - lowest, 0.0));
    // Chords of the mesh hang below the sphere, so the outline that it shows lies a little farther out.
    float chord = 2.0 * spacing_m, cell_above = max(box.high_dh_m + frame.anchor_height_m - lowest, 0.0);
    cell_above += chord * chord / (8.0 * planet.radius_m);
    return camera_tangent + horizon_distance(occluder, cell_above);
}

// Cells before `first`, whose far side is nearer than the near side of this turn's, may hide these: they raise the
// skyline. All invocations together.
void raise_skyline(int first) {
    float turn_distance = cells[first].distance_m;
    uint ready = s_ready;
    barrier();
    for (uint k = ready + gl_LocalInvocationID.x; k < uint(first); k += 256u) {
        if (cells[k].distance_m > turn_distance * SKYLINE_RATIO) {
            atomicMin(s_next, k);
            break;
        }
        skyline_raise(cell_middle(k), cells[k].spacing_m, bounds[CELL_PLACE(cells, k)].low_dh_m);
    }
    barrier();
    if (gl_LocalInvocationID.x == 0u) {
        s_ready = min(s_next, uint(first));
        s_next = 0xffffffffu;
    }
    barrier();
}

void write_draws() {
    uint variant = gl_LocalInvocationID.x;
    if (variant >= VARIANTS) return;
    draws[variant] = DrawCommand(ranges[variant].y, s_count[variant], ranges[variant].x, 0,
        variant * uint(u_capacity));
}

void main() {
    if (gl_LocalInvocationID.x < VARIANTS) s_count[gl_LocalInvocationID.x] = 0u;
    if (gl_LocalInvocationID.x == 0u) {
        s_lowest = 0x7f000000;
        s_ready = 0u;
        s_next = 0xffffffffu;
    }
    skyline_clear(gl_LocalInvocationID.x);
    barrier();

    SidePlanes planes = side_planes();
    for (int first = 0; first < u_cell_count; first += 256) {
        int index = first + int(gl_LocalInvocationID.x), cell = min(index, u_cell_count - 1);
        CellBounds box = bounds[CELL_PLACE(cells, cell)];
        vec3 low = box.low_m - frame.camera_offset_m, high = box.high_m - frame.camera_offset_m;
        vec3 pad = 1e-6 * (abs(low) + abs(high));
        low -= pad;
        high += pad;
        bool in_view = index < u_cell_count && !outside_frustum(planes, low, high);
        // The lowest ground between here and the cell: cells come nearest first, and a line that dips below the lowest
        // ground nearer than its end has met ground. Never below the lowest drawn surface.
        if (index < u_cell_count) atomicMin(s_lowest, floatBitsToInt(max(box.low_dh_m + LIFT, 0.0)));
        memoryBarrierShared();
        barrier();
        float lowest = max(intBitsToFloat(s_lowest) - LIFT - 1.0 + frame.anchor_height_m, planet.lowest_drawn_m);
        raise_skyline(first);
        in_view = in_view && !(u_hides != 0 && skyline_hides(cell_middle(uint(cell)), cells[cell].spacing_m,
            box.high_dh_m));
        vec3 nearest = clamp(vec3(0.0), low, high);
        in_view = in_view && (u_hides == 0
            || length(nearest) <= longest_sight(box, cells[cell].spacing_m, lowest) * 1.0001 + 0.01);
        in_view = in_view && box.high_dh_m >= u_keep_dh.x && box.low_dh_m <= u_keep_dh.y;
        uint variant = cells[cell].variant;
        if (in_view) visible[variant * uint(u_capacity) + atomicAdd(s_count[variant], 1u)] =
            uint(CELL_PLACE(cells, index));
    }
    barrier();
    write_draws();
}
