// Contract "vertex_spacing", default: what the G-buffer keeps of it.
//
//   float vertex_spacing(vec3 D, float code)   distance of the vertices that drew a pixel, metres. D: its foot offset
//   from the
//                                              anchor; code: gbuffer.attributes.w
#include "common/spacing_code.glsl"

float vertex_spacing(vec3 D, float code) {
    return spacing_decode(code);
}
