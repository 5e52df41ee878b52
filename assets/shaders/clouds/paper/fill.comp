// The printed density texture from raw noise (Michelic 2018, section 5): cloud where noise is above a threshold, 0 as
// far around it as a large step is long, -1 elsewhere. Distances are exact, one axis after the other: of each texel,
// the least of its neighbours' squared distance plus the square of the way there. AXIS 0 and 1 write those, AXIS 2 the
// texture.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler3D u_raw;
layout(binding = 1) uniform sampler3D u_before;   // of the axes before
layout(binding = 0, r16f) uniform writeonly image3D o_filled;
layout(location = 0) uniform int u_first;         // slice
layout(location = 1) uniform int u_border;        // texels, at most 32
layout(location = 2) uniform float u_threshold;   // of the noise
layout(location = 3) uniform float u_per_ramp;    // 1 / how far above it cloud is densest

const float FAR = 2047.0;   // half floats have whole numbers up to here

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, u_first), size = imageSize(o_filled);
    if (any(greaterThanEqual(at, size))) return;
    float nearest = FAR;
    for (int k = -u_border; k <= u_border; ++k) {
        ivec3 other = at;
        other[AXIS] = (at[AXIS] + k + size[AXIS]) % size[AXIS];
#if AXIS == 0
        float beyond = texelFetch(u_raw, other, 0).r > u_threshold ? 0.0 : FAR;
#else
        float beyond = texelFetch(u_before, other, 0).r;
#endif
        nearest = min(nearest, beyond + float(k * k));
    }
#if AXIS == 2
    float above = texelFetch(u_raw, at, 0).r - u_threshold;
    float border = nearest <= float(u_border * u_border) ? 0.0 : -1.0;
    imageStore(o_filled, at, vec4(above > 0.0 ? clamp(above * u_per_ramp, 1e-3, 1.0) : border));
#else
    imageStore(o_filled, at, vec4(nearest));
#endif
}
