// The square lattices in whose cells things stand on the ground, as if it were level.

// The lattice's axes: the two of the planet that the ground follows best, and the third.
vec3 clutter_axes(vec3 v, vec3 zenith) {
    vec3 z = abs(zenith);
    return z.x >= max(z.y, z.z) ? v.yzx : z.y >= z.z ? v.zxy : v;
}

ivec3 clutter_axes(ivec3 v, vec3 zenith) {
    vec3 z = abs(zenith);
    return z.x >= max(z.y, z.z) ? v.yzx : z.y >= z.z ? v.zxy : v;
}

vec3 clutter_planet(vec3 v, vec3 zenith) {
    vec3 z = abs(zenith);
    return z.x >= max(z.y, z.z) ? v.zxy : z.y >= z.z ? v.yzx : v;
}

float clutter_wave(float x) {
    return abs(4.0 * fract(x) - 2.0) - 1.0;
}

// A direction, as seen from the ground at hand if that was level: what rises along the ground is taken away.
vec3 levelled(vec3 direction, vec3 normal, vec3 zenith) {
    float up = dot(direction, zenith), rises = max(dot(direction, normal), 0.06);
    return normalize(direction + (rises - up) * zenith);
}
