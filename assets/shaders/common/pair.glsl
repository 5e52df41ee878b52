// Numbers of 48 bits as the sum of two floats (Dekker 1971, "A floating-point technique for extending the available
// precision"): where float is too coarse and GLSL's double runs at a thirty-second of its speed. Errors are 2^-46 of
// the larger operand. `precise` keeps a compiler from simplifying them away; fma() is not counted on, which need not be
// fused.
//
//   Pair, Pair2, Pair3      high + low, of float, vec2, vec3
//   pair_add, pair_sub, pair_mul, pair_div      of pairs and floats, also mixed; pair_mul2, pair_mul3 by one number
//   pair_sqrt, pair_abs, pair_min, pair_max, pair_clamp, pair_scaled (by a power of two)

#define PAIR_OF(PAIR, KIND) \
    struct PAIR { KIND high, low; }; \
    PAIR pair(KIND a) { return PAIR(a, KIND(0.0)); } \
    PAIR pair_whole(KIND high, KIND low) { \
        precise KIND sum = high + low; \
        precise KIND rest = low - (sum - high); \
        return PAIR(sum, rest); \
    } \
    PAIR pair_add(KIND a, KIND b) { \
        precise KIND sum = a + b; \
        precise KIND of_b = sum - a; \
        precise KIND rest = (a - (sum - of_b)) + (b - of_b); \
        return PAIR(sum, rest); \
    } \
    PAIR pair_add(PAIR a, KIND b) { \
        PAIR sum = pair_add(a.high, b); \
        precise KIND low = sum.low + a.low; \
        return pair_whole(sum.high, low); \
    } \
    PAIR pair_add(PAIR a, PAIR b) { \
        PAIR sum = pair_add(a.high, b.high); \
        precise KIND low = sum.low + (a.low + b.low); \
        return pair_whole(sum.high, low); \
    } \
    PAIR pair_mul(KIND a, KIND b) { \
        precise KIND product = a * b, wide_a = a * 4097.0, wide_b = b * 4097.0; \
        precise KIND a1 = wide_a - (wide_a - a), b1 = wide_b - (wide_b - b), a2 = a - a1, b2 = b - b1; \
        precise KIND rest = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2; \
        return PAIR(product, rest); \
    } \
    PAIR pair_mul(PAIR a, KIND b) { \
        PAIR product = pair_mul(a.high, b); \
        precise KIND low = product.low + a.low * b; \
        return pair_whole(product.high, low); \
    } \
    PAIR pair_mul(PAIR a, PAIR b) { \
        PAIR product = pair_mul(a.high, b.high); \
        precise KIND low = product.low + (a.high * b.low + a.low * b.high); \
        return pair_whole(product.high, low); \
    } \
    PAIR pair_scaled(PAIR a, float power) { return PAIR(a.high * power, a.low * power); }

PAIR_OF(Pair, float)
PAIR_OF(Pair2, vec2)
PAIR_OF(Pair3, vec3)

Pair pair_add(float a, Pair b) { return pair_add(b, a); }
Pair pair_mul(float a, Pair b) { return pair_mul(b, a); }
Pair pair_neg(Pair a) { return Pair(-a.high, -a.low); }
Pair pair_sub(Pair a, Pair b) { return pair_add(a, pair_neg(b)); }
Pair pair_sub(Pair a, float b) { return pair_add(a, -b); }
Pair pair_sub(float a, Pair b) { return pair_add(pair_neg(b), a); }
Pair pair_sub(float a, float b) { return pair_add(a, -b); }
Pair2 pair_mul(vec2 a, Pair b) { return pair_mul(Pair2(vec2(b.high), vec2(b.low)), a); }
Pair3 pair_mul(Pair3 a, Pair b) { return pair_mul(a, Pair3(vec3(b.high), vec3(b.low))); }
Pair3 pair_sub(Pair3 a, Pair3 b) { return pair_add(a, Pair3(-b.high, -b.low)); }

#define PAIR_PART(a, part) Pair((a).high.part, (a).low.part)

// One step of Newton from the quotient of floats.
Pair pair_div(Pair a, Pair b) {
    precise float quotient = a.high / b.high;
    precise float rest = pair_sub(a, pair_mul(b, quotient)).high / b.high;
    return pair_whole(quotient, rest);
}
Pair pair_div(Pair a, float b) { return pair_div(a, pair(b)); }
Pair pair_div(float a, Pair b) { return pair_div(pair(a), b); }

// Of numbers above 0.
Pair pair_sqrt(Pair a) {
    precise float root = sqrt(a.high);
    precise float rest = pair_sub(a, pair_mul(root, root)).high / (2.0 * root);
    return pair_whole(root, rest);
}

bool pair_below(Pair a, float b) { return a.high < b || (a.high == b && a.low < 0.0); }

Pair pair_max(Pair a, float low) {
    bool below = pair_below(a, low);
    return Pair(below ? low : a.high, below ? 0.0 : a.low);
}

Pair pair_min(Pair a, float high) {
    bool below = pair_below(a, high);
    return Pair(below ? a.high : high, below ? a.low : 0.0);
}

Pair pair_clamp(Pair a, float low, float high) { return pair_min(pair_max(a, low), high); }
Pair pair_abs(Pair a) { return pair_scaled(a, a.high < 0.0 ? -1.0 : 1.0); }

Pair pair_dot(Pair3 a, Pair3 b) {
    Pair3 parts = pair_mul(a, b);
    return pair_add(pair_add(PAIR_PART(parts, x), PAIR_PART(parts, y)), PAIR_PART(parts, z));
}

// Unit vectors, to 2^-43: a step of Newton for 1 / length.
Pair3 pair_unit(Pair3 v) {
    Pair square = pair_dot(v, v);
    precise float over_root = 1.0 / sqrt(square.high);
    Pair left = pair_sub(1.0, pair_mul(pair_mul(square, over_root), over_root));
    precise float more = 0.5 * over_root * left.high;
    return pair_mul(v, pair_whole(over_root, more));
}
