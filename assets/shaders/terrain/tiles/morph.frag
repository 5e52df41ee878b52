// Debug view: how far each tile has become its parent. Blue: as itself; yellow: as its parent.
layout(std430, binding = 6) readonly buffer MorphBuffer { float tile_morphs[]; };
flat in uint v_slot;
layout(location = 0) out vec4 o_color;

void main() {
    o_color = vec4(mix(vec3(0.08, 0.14, 0.38), vec3(1.0, 0.85, 0.2), tile_morphs[v_slot]), 1.0);
}
