// A vertex of the projected grid: the layout of CellVertex in common/cells.glsl.
struct PaperVertex {
    float x, y, z;     // metres from the anchor, planet axes
    float dh;          // height above the anchor's, metres
    uint normal;       // octahedral, 2 x snorm16, planet axes
    uint attributes;   // 4 x unorm8: 0, 0, height between the lowest and highest ground, code of the spacing
};
