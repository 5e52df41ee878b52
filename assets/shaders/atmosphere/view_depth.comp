// Mean extinction from the start of each row's ray to each of its fine slices: it does not depend on the azimuth.
#include "atmosphere/view.glsl"

layout(local_size_x = 8) in;
layout(rgba32f, binding = 0) writeonly uniform image2D u_extinction;

void air_light_at(AirView v, AirCell cell, int layer, out vec3 first, out vec3 second) { first = second = vec3(0.0); }
vec3 air_mean_extinction(ivec2 texel) { return vec3(0.0); }

void main() {
    AirView v = air_view.camera;
    int row = int(gl_GlobalInvocationID.x);
    if (row >= 2 * v.rows) return;
    float mu_s, nu;
    AirPath p = air_texel_path(v, row, 0.0, mu_s, nu);
    vec3 depth = vec3(0.0), mean = air_extinction(air_density(p.h));
    for (int slice = 0; slice <= AIR_FINE * v.slices; ++slice) {
        imageStore(u_extinction, ivec2(row, slice), vec4(air_pack(mean), 0.0));
        float t = 0.0;
        depth += air_slice_depth(p.h, p.mu, p.length_m, p.lowest, p.split, slice, AIR_FINE * v.slices, t);
        mean = t > 0.0 ? depth / t : mean;
    }
}
