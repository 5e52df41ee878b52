// A vertex of the moving sea.
struct SeaVertex {
    float x, y, z;     // metres from the anchor, planet axes
    uint moved;        // sideways movement along east and north over the largest, 2 x snorm16
    uint normal;       // of the calm sea: octahedral, 2 x snorm16, planet axes
    uint attributes;   // as CellVertex
};
