// A mip level of the printed density texture from the one before. A texel lets through what its eight let through on
// average over the three axes, along a way as long as itself and at most the layer's thickness: densities themselves,
// averaged, would close the gaps between clouds. -1 stands only where all texels of the finer level within one texel
// are -1, so that next to cloud there is a border of zeros in every level.
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 0) uniform sampler3D u_tile;
layout(binding = 0, r16f) uniform writeonly image3D o_level;
layout(location = 0) uniform int u_finer;       // level to read
// of density 1 along the way, the finer level's and this one's
layout(location = 1) uniform float u_finer_depth;
layout(location = 2) uniform float u_depth;

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(o_level)))) return;
    ivec3 size = textureSize(u_tile, u_finer);
    float most = -1.0, own[8];
    for (int k = 0; k < 64; ++k) {
        ivec3 aside = ivec3(k & 3, (k >> 2) & 3, k >> 4) - 1;
        float density = texelFetch(u_tile, (2 * at + aside + size) % size, u_finer).r;
        most = max(most, density);
        if (all(greaterThanEqual(aside, ivec3(0))) && all(lessThan(aside, ivec3(2))))
            own[aside.x + 2 * aside.y + 4 * aside.z] = max(density, 0.0);
    }
    // The way goes through one of two texels and, as far as it is longer, through the other as well.
    float through = 0.0, further = u_depth - u_finer_depth;
    for (int k = 0; k < 24; ++k)
        through += exp(-u_finer_depth * own[k & 7] - further * own[(k & 7) ^ (1 << (k >> 3))]);
    float mean = -log(through / 24.0) / u_depth;
    imageStore(o_level, at, vec4(mean > 0.0 ? mean : min(most, 0.0)));
}
