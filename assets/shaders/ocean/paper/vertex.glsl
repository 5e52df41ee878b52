// A vertex of the projected grid at sea level, and the same in waves.
struct CalmVertex {
    float x, y, z;     // foot offset from the anchor, m
    float shallow;     // depth / (depth + 16 m)
};
struct WavyVertex {
    float x, y, z;     // metres from the anchor, planet axes
    uint normal;       // octahedral, 2 x snorm16, planet axes
    float shallow;
};
