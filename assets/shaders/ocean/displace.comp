// Vertices of the visible cells, moved by the waves: each frame in which time passes. The calm sea's vertices and the
// depth below them are those of the last snap. A lane takes SEA_VERTICES of them, so that a wave is fetched once for
// all.
//
// Cells that share a vertex get the same bits: what a vertex becomes depends on nothing but its own place and depth.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"
#include "common/sea_depth.glsl"
#include "common/spread.glsl"
#include "ocean/displaced.glsl"
#include "ocean/waves.glsl"

const int LANES = 32;
layout(local_size_x = 32) in;
layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = 3) writeonly buffer DisplacedBuffer { SeaVertex displaced[]; };
layout(std430, binding = MOVED_CELLS_BUFFER) readonly buffer ListBuffer { uint list[]; };

const float DEEP = 10.0;   // k times the depth from which sea_shoaling() is 1 to the last bit

SeaPlace g_places[SEA_VERTICES];
vec3 g_moved[SEA_VERTICES];
float g_depth[SEA_VERTICES], g_fineness[SEA_VERTICES];   // m; 1 / spacing

void add_wave(Wave at, bool near, bool shallow) {
    float wavelength = 1.0 / at.cycles_per_m, k_wave = at.cycles_per_m * TWO_PI;
    for (int k = 0; k < SEA_VERTICES; ++k) {
        SeaWave wave = near ? sea_near_wave(g_places[k], at) : sea_far_wave(g_places[k], at);
        float share = wave.weight * smoothstep(2.0, 4.0, wavelength * g_fineness[k]);
        if (shallow) share *= sea_shoaling(k_wave * g_depth[k]);
        vec2 circle = sea_circle(wave.cycles);
        g_moved[k] += share * vec3(wave.direction * (wave.sideways * circle.y), wave.amplitude * circle.x);
    }
}

void main() {
    uint cell = list[4u + spread_group()], first = cell * uint(CELL_VERTICES);
    // Only what the cell's index list uses.
    int skips = int(cells[cell].variant >> 1u);
    ivec2 skip = ivec2(skips / (CELL_MOST + 1), skips % (CELL_MOST + 1)), side = (ivec2(CELL_QUADS) >> skip) + 1;
    int count = side.x * side.y;
    float to_foot = 1.0 / sea_waves.per_foot;
    int base = 0;
    do {
        float finest = 0.0, shallowest = 3.0e38;
        for (int k = 0; k < SEA_VERTICES; ++k) {
            int n = min(base + int(gl_LocalInvocationID.x) + k * LANES, count - 1);
            ivec2 ab = ivec2(n % side.x, n / side.x) << skip;
            CellVertex calm = vertices[first + uint(ab.y * CELL_SIDE + ab.x)];
            vec3 position = vec3(calm.x, calm.y, calm.z);
            g_places[k] = sea_place((position - frame.anchor_up * calm.dh) * to_foot);
            g_moved[k] = vec3(0.0);
            g_depth[k] = sea_depth_m(unpackUnorm2x16(calm.attributes).x) * sea_open(g_places[k]);
            // The distance of vertices that was asked for here, whatever the cell's own is.
            float spacing_m = sea_waves.spacing_rad * length(position - sea_waves.proxy_m);
            g_fineness[k] = 1.0 / max(sea_waves.smallest_spacing_m, spacing_m);
            finest = max(finest, g_fineness[k]);
            shallowest = min(shallowest, g_depth[k]);
        }
        WaveBin bin = wave_bin(PI * finest);
        int feels = min(wave_bin(DEEP / max(shallowest, 1e-6)).far_count, bin.far_count);
        int i = 0;
        if (i < feels) do {
            add_wave(sea_waves_waves(i), false, true);
        } while (++i < feels);
        i = feels;
        if (i < bin.far_count) do {
            add_wave(sea_waves_waves(i), false, false);
        } while (++i < bin.far_count);
        i = sea_waves.far_count;
        int end_near = i + bin.near_count;
        if (i < end_near) do {
            add_wave(sea_waves_waves(i), true, true);
        } while (++i < end_near);
        for (int k = 0; k < SEA_VERTICES; ++k) {
            int n = base + int(gl_LocalInvocationID.x) + k * LANES;
            if (n >= count) continue;
            ivec2 ab = ivec2(n % side.x, n / side.x) << skip;
            uint index = first + uint(ab.y * CELL_SIDE + ab.x);
            vec3 position = vec3(vertices[index].x, vertices[index].y, vertices[index].z)
                + sea_vector(g_places[k], g_moved[k]);
            SeaVertex vertex;
            vertex.x = position.x;
            vertex.y = position.y;
            vertex.z = position.z;
            vertex.moved = packSnorm2x16(g_moved[k].xy / max(sea_waves.farthest_m, 1e-6));
            vertex.normal = vertices[index].normal;
            vertex.attributes = vertices[index].attributes;
            displaced[index] = vertex;
        }
        base += LANES * SEA_VERTICES;
    } while (base < count);
}
