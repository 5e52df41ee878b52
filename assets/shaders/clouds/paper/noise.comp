// Simplex-Worley noise that repeats after the volume's width (Michelic 2018, section 5): billows on a simplex noise
// that joins and parts them. How the two are mixed is not printed. Here simplex noise has the widest waves that fit the
// volume, so that from orbit there are fields of cloud and clear land and sea between them, and the billows the
// narrowest that its texels hold, so that a field seen from the ground is one of cumulus. Values are raw:
// clouds/paper/fill.comp cuts clouds out of them.
#include "clouds/tiled_noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image3D o_raw;
layout(location = 0) uniform int u_first;   // slice

// Where the noise begins, of the volume's width: of 400 places the one that leaves most named views the sun and some of
// the sky.
const vec3 PLACE = vec3(52.0, 23.0, 55.0) / 64.0;

// Vertices of the simplex lattice lie at (6 v - (v.x + v.y + v.z)) / 6: whole numbers of sixths, which repeat as they
// stand.
float tiled_corner(ivec3 vertex, vec3 d, int sixths, int seed) {
    ivec3 at = 6 * vertex - (vertex.x + vertex.y + vertex.z);
    float t = max(0.5 - dot(d, d), 0.0);
    t *= t;
    return t * t * dot(vec3(tiled_hash(at, sixths, seed)), d);
}

// Simplex noise (Perlin 2002), about -1..1, that repeats after 3 m units; place in units.
float tiled_simplex(vec3 place, int m, int seed) {
    vec3 skewed = place + (place.x + place.y + place.z) / 3.0;
    ivec3 cell = ivec3(floor(skewed));
    vec3 f = skewed - vec3(cell);
    bool xy = f.x >= f.y, xz = f.x >= f.z, yz = f.y >= f.z;
    ivec3 first = ivec3(xy && xz, !xy && yz, 0);
    first.z = 1 - first.x - first.y;
    ivec3 last = ivec3(!xy && !xz, xy && !yz, 0);
    last.z = 1 - last.x - last.y;
    ivec3 second = 1 - last;
    vec3 d = f - (f.x + f.y + f.z) / 6.0;
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec3 corner = i == 0 ? ivec3(0) : i == 1 ? first : i == 2 ? second : ivec3(1);
        sum += tiled_corner(cell + corner, d - vec3(corner) + float(i) / 6.0, 18 * m, seed);
    }
    return 60.0 * NOISE_GRADIENT_SCALE * sum;
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, u_first), size = imageSize(o_raw);
    if (any(greaterThanEqual(at, size))) return;
    vec3 p = (vec3(at) + 0.5) / vec3(size) + PLACE;
    float value = tiled_simplex(3.0 * p, 1, 32), weight = 0.5;
    for (int k = 0, cells = 18; k < 3; ++k, cells *= 2) {
        value += weight * tiled_worley(p * float(cells), cells, 40 + k);
        weight *= 0.8;
    }
    imageStore(o_raw, at, vec4(value));
}
