// Places and noise as integers, with the same bits on every GPU: a place is whole units and 2^-32 of one.
#include "common/pair.glsl"

struct Fixed3 {
    ivec3 whole;
    uvec3 part;
};

// Units, to 2^-24 of one. a: below 2^23.
Fixed3 fixed_place(Pair3 a) {
    vec3 whole = floor(a.high);
    precise vec3 rest = ((a.high - whole) + a.low) * 16777216.0;
    ivec3 part = ivec3(floor(rest));
    return Fixed3(ivec3(whole) + (part >> 24), uvec3(part) << 8);
}

Pair3 fixed_pair(Fixed3 a) { return pair_add(vec3(a.whole), vec3(a.part >> 8) * (1.0 / 16777216.0)); }

// In units 2^shift times as large, 0..31.
Fixed3 fixed_coarser(Fixed3 a, int shift) {
    return Fixed3(a.whole >> shift, a.part >> shift | uvec3(a.whole) << 1 << (31 - shift));
}

Fixed3 fixed_add(Fixed3 a, Fixed3 b) {
    uvec3 carry, part = uaddCarry(a.part, b.part, carry);
    return Fixed3(a.whole + b.whole + ivec3(carry), part);
}

// a b 2^-shift, of which 2^-32 is the unit of `part`.
Fixed3 fixed_product(ivec3 a, int b, int shift) {
    ivec3 high, low;
    imulExtended(a, ivec3(b), high, low);
    return fixed_coarser(Fixed3(high, uvec3(low)), shift);
}

// The high words of products; `of_uint`: of a uint, given as the int of its bits.
#define FIXED_PRODUCTS(INT) \
    INT fixed_high(INT a, INT b) { \
        INT high, low; \
        imulExtended(a, b, high, low); \
        return high; \
    } \
    INT fixed_share(INT of_uint, INT b) { return fixed_high(of_uint, b) + (b & of_uint >> 31); }

FIXED_PRODUCTS(int)
FIXED_PRODUCTS(ivec3)

// Of integers in 2^-30. Floats hold 24 bits of them and what is left.
Pair fixed_number(int a) {
    float high = float(a);
    return pair_scaled(Pair(high, float(a - int(high))), 1.0 / 1073741824.0);
}

Pair3 fixed_number(ivec3 a) {
    vec3 high = vec3(a);
    return pair_scaled(Pair3(high, vec3(a - ivec3(high))), 1.0 / 1073741824.0);
}
