// Unit vectors in two numbers (octahedral map): rg16_snorm keeps a normal to about 0.004 degrees.
// Numpy twin: tests/engine/test_gpu_shader_common.py.

// Zero counts as positive, unlike in sign(), whose 0 would fold both axes onto the centre.
vec2 oct_sign(vec2 v) {
    return vec2(v.x < 0.0 ? -1.0 : 1.0, v.y < 0.0 ? -1.0 : 1.0);
}

// Unit vector -> (-1..1, -1..1). Poles of the map lie on +Z (centre) and -Z (corners).
vec2 oct_encode(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return n.z < 0.0 ? (1.0 - abs(p.yx)) * oct_sign(p) : p;
}

// The inverse; any input in the square gives a unit vector.
vec3 oct_decode(vec2 e) {
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float fold = max(-n.z, 0.0);
    n.xy -= oct_sign(n.xy) * fold;
    return normalize(n);
}

// The same in one 32-bit word (two 16-bit snorm numbers), for vertices and storage buffers.
uint oct_pack(vec3 n) {
    return packSnorm2x16(oct_encode(n));
}

vec3 oct_unpack(uint word) {
    return oct_decode(unpackSnorm2x16(word));
}
