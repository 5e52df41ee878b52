// Map of the Milky Way's unresolved light over the whole sky, made once. Octahedral, galactic axes (x: centre, z:
// pole). o_light: radiance at the three wavelengths in units of the brightest clouds (see sky/galaxy.frag).
//
// A disc that widens and brightens towards the centre, a bulge, clouds of stars, and the dark clouds of the Great Rift
// that run along the plane. The look is modelled, the level measured: Leinert et al. 1998 (Astron. Astrophys. Suppl.
// 127, 1), integrated starlight of 25-30 S10 at the poles and some 200-300 in the plane.
#include "common/octahedral.glsl"
#include "generated/wavelengths.glsl"

layout(location = 0) uniform uint u_seed;
in vec2 v_ndc;
layout(location = 0) out vec4 o_light;

uvec3 hash3(uvec3 v) {  // PCG3D (Jarzynski and Olano 2020)
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    return v;
}

// Gradient noise, about 0..1 with mean 0.5, features about 1 across.
float noise(vec3 p) {
    ivec3 cell = ivec3(floor(p));
    vec3 f = p - vec3(cell);
    vec3 fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    float total = 0.0;
    for (int k = 0; k < 8; k++) {
        ivec3 o = ivec3(k & 1, (k >> 1) & 1, k >> 2);
        vec3 w = mix(1.0 - fade, fade, vec3(o));
        vec3 slope = vec3(hash3(uvec3(cell + o) + uvec3(u_seed * 7919u)) >> 8u) * (2.0 / 16777216.0) - 1.0;
        total += w.x * w.y * w.z * dot(slope, f - vec3(o));
    }
    return clamp(0.5 + 0.75 * total, 0.0, 1.0);
}

// Layers of noise, mean 0.5, each half as large and `keep` as strong.
float layers(vec3 p, int count, float keep) {
    float total = 0.0, strength = 1.0, sum = 0.0;
    for (int k = 0; k < count; k++) {
        total += strength * noise(p);
        sum += strength;
        strength *= keep;
        p = p * 2.03 + vec3(17.3, 5.1, 9.7);
    }
    return total / sum;
}

// Thin winding filaments, 0..1 with 1 on the filament.
float filaments(vec3 p, int count) {
    float total = 0.0, strength = 0.5;
    for (int k = 0; k < count; k++) {
        float n = 1.0 - abs(2.0 * noise(p) - 1.0);
        total += strength * n * n;
        strength *= 0.5;
        p = p * 2.07 + vec3(3.7, 11.9, 7.3);
    }
    return total;
}

void main() {
    vec3 d = oct_decode(v_ndc);
    float flat_length = max(length(d.xy), 1e-4);
    float toward = d.x / flat_length;                     // cosine of galactic longitude
    float inner = exp(2.2 * (toward - 1.0));              // 1 at the centre, small at the anticentre
    // The plane waves a little, as it does in the sky (the sun is not in it, arms stand out of it).
    vec3 warp = vec3(noise(d * 2.3), noise(d * 2.3 + 31.0), noise(d * 2.3 + 57.0)) - 0.5;
    vec3 fine = vec3(noise(d * 13.0), noise(d * 13.0 + 31.0), noise(d * 13.0 + 57.0)) - 0.5;
    float b = d.z + 0.06 * warp.x + 0.012;
    float width = 0.075 + 0.075 * inner;
    float disc = (0.26 + 0.60 * inner) / (1.0 + pow(abs(b) / width, 2.2));
    vec2 from_center = d.yz * vec2(4.2, 6.5);
    float bulge = 1.0 * exp(-dot(from_center, from_center)) * step(0.0, d.x);
    float clouds = 0.25 + 2.6 * pow(layers(d * 11.0 + warp * 2.0 + fine, 7, 0.68), 2.0);
    float stars = (disc + bulge) * clouds;
    // Dust lies flatter than stars. Great clouds of it hide whole stretches of the plane; filaments reach out of it.
    float lane = exp(-pow(abs(b + 0.03 * warp.y + 0.01 * fine.x) / (0.05 + 0.03 * inner), 2.0));
    float above = exp(-pow(abs(b) / 0.17, 2.0));
    float great = smoothstep(0.42, 0.66, layers(d * vec3(5.0, 5.0, 9.0) + warp * 2.0 + fine * 0.5, 6, 0.58));
    float rift = filaments(d * vec3(8.0, 8.0, 13.0) + warp * 2.5 + fine * 0.7, 7);
    float depth = lane * great * (2.2 + 1.6 * inner);
    depth += above * pow(smoothstep(0.45, 0.95, rift), 1.5) * 1.6;
    depth += 0.35 * lane;
    // Dust dims blue more than red (extinction about as 1 / wavelength).
    const vec3 PER_WAVELENGTH = 550.0 / WAVELENGTHS_NM;
    vec3 extinction = exp(-depth * pow(PER_WAVELENGTH, vec3(1.05)));
    // Red by powers of it that are 0.98 and 1.1 at 680 nm.
    const vec3 YOUNG = vec3(pow(PER_WAVELENGTH.r, 0.095), 1.0, 1.06);
    const vec3 OLD = vec3(pow(PER_WAVELENGTH.r, -0.45), 1.0, 0.86);
    vec3 color = mix(YOUNG, OLD, clamp(0.9 * bulge + 0.25 * inner, 0.0, 1.0));
    float haze = 0.03 + 0.025 / (1.0 + pow(abs(d.z) / 0.25, 2.0));  // the faint starlight between the stars
    const vec3 SUNLIKE = SUNLIGHT / SUNLIGHT.g;  // the shape of starlight is about that of sunlight
    o_light = vec4(SUNLIKE * (color * stars * extinction * 1.25 + vec3(haze)), 1.0);
}
