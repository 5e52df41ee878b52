// Which lines of rivers a tile of the picture has to look at (terrain/list_water.comp).
#include "generated/bindings.glsl"

const int WATER_LINES = 31;           // of a tile at most
const int WATER_RECORD = 32;          // their number, and these
layout(std430, binding = WATER_LINE_BUFFER) buffer WaterLineBuffer { int water_lines[]; };
