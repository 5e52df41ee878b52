// What a slot keeps of each vertex of a tile. Heights are integers, so that a difference from an anchor's is exact.
struct TileVertex {
    int height;        // above the reference sphere, in steps of u_step_m
    uint normal;       // octahedral, 2 x snorm16, planet axes
    uint attributes;   // terrain/attributes.glsl
};

struct TileFacts {
    int low, high;     // of the vertices, in steps
    float error_m;     // largest distance of the true ground, where it was looked at, from the tile's own triangles
    float pad;
};

// A tile to be made. name: as the scheme has it (root, level, i, j).
struct TileRequest {
    ivec4 name;
    uint slot;
    uint table;        // its first double in the table of numbers that the scheme wants from the CPU
    float spacing_m;
    uint pad;
};

// A tile to be drawn, in the order of the selection.
struct TileRow {
    ivec4 name;
    uint slot;
    uint edge_skip;    // a byte an edge: vertices along it are rounded down to multiples of 2^skip
    float morph;       // 0 as it is, 1 as its parent
    float spacing_m;
    vec4 edge_morph;
};
