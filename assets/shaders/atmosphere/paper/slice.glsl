// A table is made in slices: boxes of texels, so that no dispatch takes long.
#include "common/safe.glsl"

layout(local_size_x = 32, local_size_y = 2) in;

uniform ivec3 u_first;
uniform ivec3 u_count;

bool paper_texel(out ivec3 texel) {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    texel = u_first + at;
    return all(lessThan(at, u_count));
}

// To the nearest half float: a driver may cut off instead, which darkens each order a little more.
#ifdef PAPER_HALF
vec3 paper_stored(vec3 value) {
    value = clamp(value, -65504.0, 65504.0);
    vec3 fine = round(value * 16777216.0) / 16777216.0;  // below 2^-14 half floats are spaced by 2^-24
    uvec3 bits = floatBitsToUint(value);
    vec3 coarse = uintBitsToFloat((bits + 0x0fffu + ((bits >> 13u) & 1u)) & 0xffffe000u);
    return mix(coarse, fine, lessThan(abs(value), vec3(6.103515625e-5)));
}
#else
vec3 paper_stored(vec3 value) {
    return value;
}
#endif
