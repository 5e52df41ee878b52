// Light of leaves that let through what others don't. Codes of 8 bits from 112 on, above those of bark and below those
// of other leaves, are how open they are, in 16 steps; what they let through, in 7 steps, are the lowest bits of the
// square root of their albedo.
const float THROUGH_STEP = 0.15, OWN_FIRST = 112.0, OWN_STEPS = 15.0;

// root: of the albedo, 0..1; translucency: 0..0.9; open: 0..1.
vec4 coded_leaf(vec3 root, float translucency, float open) {
    uint steps = uint(min(round(translucency / THROUGH_STEP), 6.0));
    vec3 lowest = vec3(uvec3(steps, steps >> 1, steps >> 2) & 1u);
    root = (2.0 * clamp(round(0.5 * (255.0 * root - lowest)), 0.0, 127.0) + lowest) / 255.0;
    return vec4(root, (OWN_FIRST + round(OWN_STEPS * clamp(open, 0.0, 1.0))) / 255.0);
}

bool is_coded_leaf(vec4 attributes) {
    float code = round(255.0 * attributes.a);
    return code >= OWN_FIRST && code <= OWN_FIRST + OWN_STEPS;
}

// (open, translucency).
vec2 decoded_leaf(vec4 attributes) {
    uvec3 lowest = uvec3(round(255.0 * attributes.rgb)) & 1u;
    return vec2((round(255.0 * attributes.a) - OWN_FIRST) / OWN_STEPS,
        THROUGH_STEP * float(lowest.r + 2u * lowest.g + 4u * lowest.b));
}
