// Which patches of the projected grid are seen: those of which not all corners, at PAPER_LOWEST and at PAPER_HIGHEST
// (heights, defined by who includes this), lie outside one side of a slightly widened frustum. An invocation a patch;
// the list is kept by level.
#include "generated/bindings.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = PATCH_BUFFER) readonly buffer PatchBuffer { uvec2 patches[]; };
layout(std430, binding = VISIBLE_BUFFER) writeonly buffer VisibleBuffer { uint visible[]; };   // by level, finest first
layout(std430, binding = COUNT_BUFFER) buffer CountBuffer { uint counts[]; };   // by level
uniform int u_count;
uniform int u_patches[PAPER_LEVELS];

const float WIDENED = 1.02;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= u_count) return;
    uint word = patches[index].x;
    ivec2 place = paper_patch_place(word);
    vec3 right = frame.camera_right, up = frame.camera_up, forward = frame.camera_forward;
    vec2 low = frame.projection_offset - frame.projection_scale * WIDENED,
        high = frame.projection_offset + frame.projection_scale * WIDENED;
    vec3 a = paper_foot(place), b = paper_foot(place + ivec2(PAPER_FINEST, 0));
    vec3 c = paper_foot(place + ivec2(0, PAPER_FINEST)), d = paper_foot(place + PAPER_FINEST);
    // The sphere bulges above the corners: as much higher are they taken to be.
    float wide2 = max(dot(a - d, a - d), dot(b - c, b - c)), radius = planet.radius_m;
    float bulge = wide2 / (8.0 * radius) * (1.0 + wide2 / (4.0 * radius * radius));
    float lowest = PAPER_LOWEST - frame.anchor_height_m - 1.0,
        highest = PAPER_HIGHEST - frame.anchor_height_m + 1.0 + bulge;
    uint outside = 31u;   // a bit a plane
    for (int k = 0; k < 8; ++k) {
        int corner = k >> 1;
        vec3 foot = corner == 0 ? a : corner == 1 ? b : corner == 2 ? c : d;
        vec3 point = paper_position(foot, (k & 1) == 0 ? lowest : highest) - frame.camera_offset_m;
        float x = dot(point, right), y = dot(point, up), z = dot(point, forward);
        outside &= (x < low.x * z ? 1u : 0u) | (x > high.x * z ? 2u : 0u) | (y < low.y * z ? 4u : 0u)
            | (y > high.y * z ? 8u : 0u)
            | (z < 0.0 ? 16u : 0u);
    }
    if (outside != 0u) return;
    int level = paper_patch_level(word), first = 0;
    for (int k = PAPER_LEVELS - 1; k > level; --k) first += u_patches[k];
    visible[uint(first) + atomicAdd(counts[level], 1u)] = uint(index);
}
