// Vertices of the visible patches in waves, as printed in 2018, equations 8 and 10: d_i is as long as the sine of the
// angle from its origin, Q_i alone fades at origin and antipode, all waves are in each vertex, and the normal is that
// of equation 10. Where a wave is, is known from our anchor: the printed arccos and arcsin agree then. With PAPER_ARC,
// the year of a source, its arc and phase stand as they are printed, in planet coordinates of single precision. A lane
// takes SEA_VERTICES vertices, so that a wave is fetched once for all.
#include "generated/bindings.glsl"
#include "ocean/paper/grid.glsl"
#include "common/octahedral.glsl"
#include "ocean/paper/vertex.glsl"
#include "ocean/waves.glsl"
#include "ocean/paper/record.glsl"

const int LANES = 32;
layout(local_size_x = 32) in;
layout(std430, binding = PATCH_BUFFER) readonly buffer PatchBuffer { uvec2 patches[]; };
layout(std430, binding = VERTEX_BUFFER) readonly buffer CalmBuffer { CalmVertex calm[]; };
layout(std430, binding = VISIBLE_BUFFER) readonly buffer VisibleBuffer { uint visible[]; };
layout(std430, binding = COUNT_BUFFER) readonly buffer CountBuffer { uint counts[]; };
layout(std430, binding = 5) writeonly buffer WavyBuffer { WavyVertex wavy[]; };
layout(std430, binding = 6) readonly buffer RecordBuffer { WaveRecord records[]; };
uniform int u_patches[PAPER_LEVELS];
#ifdef PAPER_ARC
uniform float u_time_s;
#endif

SeaPlace g_places[SEA_VERTICES];
vec3 g_moved[SEA_VERTICES], g_normal[SEA_VERTICES];

// The n-th vertex of what is visible, or a negative number.
int vertex_of(uint n) {
    uint first = 0u;
    int first_patch = 0, found = -1;
    for (int k = PAPER_LEVELS - 1; k >= 0; --k) {
        uint side = (1u << k) + 1u, size = side * side, end = first + counts[k] * size;
        if (n >= first && n < end) {
            uint within = n - first;
            found = int(patches[visible[uint(first_patch) + within / size]].y + within % size);
        }
        first = end;
        first_patch += u_patches[k];
    }
    return found;
}

#ifdef PAPER_ARC
void add_wave(WaveRecord at) {
    vec3 o = vec3(at.origin_x, at.origin_y, at.origin_z);
    vec2 fade = paper_fade(at.wave_number / TWO_PI);
    for (int k = 0; k < SEA_VERTICES; ++k) {
        vec3 v = g_places[k].zenith, d = cross(v, cross(v - o, v));
        float angle = at.wave_number * paper_arc(PAPER_ARC, v, o, sea_waves.radius_m) + at.turn * u_time_s;
        float steepness = at.steepness * smoothstep(fade.x, fade.y, 1.0 - abs(dot(v, o)));
        vec2 aside = vec2(dot(d, g_places[k].east), dot(d, g_places[k].north));
        vec2 circle = at.amplitude_m * vec2(sin(angle), cos(angle)), slopes = at.wave_number * circle;
        g_moved[k] += vec3(aside * (steepness * circle.y), circle.x);
        g_normal[k] -= vec3(aside * slopes.y, steepness * slopes.x);
    }
}
#else
void add_wave(Wave at, bool near) {
    for (int k = 0; k < SEA_VERTICES; ++k) {
        SeaWave wave = near ? sea_near_wave(g_places[k], at) : sea_far_wave(g_places[k], at);
        vec2 circle = sea_circle(wave.cycles), d = wave.direction * wave.sine;
        float sideways = wave.sideways * wave.weight;
        g_moved[k] += vec3(d * (sideways * circle.y), wave.amplitude * circle.x);
        g_normal[k] -= vec3(d * (wave.amplitude * wave.k * circle.y), sideways * wave.k * circle.x);
    }
}
#endif

void main() {
    int vertex[SEA_VERTICES];
    for (int k = 0; k < SEA_VERTICES; ++k) {
        vertex[k] = vertex_of(gl_WorkGroupID.x * uint(LANES * SEA_VERTICES) + gl_LocalInvocationID.x + uint(k * LANES));
        CalmVertex at = calm[max(vertex[k], 0)];
        g_places[k] = sea_place(vec3(at.x, at.y, at.z));
        g_moved[k] = vec3(0.0);
        g_normal[k] = vec3(0.0, 0.0, 1.0);
    }
    int far_count = sea_waves.far_count, count = sea_waves.count;
#ifdef PAPER_ARC
    for (int i = 0; i < count; ++i) add_wave(records[i]);
#else
    for (int i = 0; i < far_count; ++i) add_wave(paper_wave(records[i]), false);
    for (int i = far_count; i < count; ++i) add_wave(paper_wave(records[i]), true);
#endif
    for (int k = 0; k < SEA_VERTICES; ++k) {
        if (vertex[k] < 0) continue;
        CalmVertex at = calm[vertex[k]];
        vec3 position = paper_position(vec3(at.x, at.y, at.z), planet.sea_level_m - frame.anchor_height_m)
            + sea_vector(g_places[k], g_moved[k]);
        uint normal = packSnorm2x16(oct_encode(normalize(sea_vector(g_places[k], g_normal[k]))));
        wavy[vertex[k]] = WavyVertex(position.x, position.y, position.z, normal, at.shallow);
    }
}
