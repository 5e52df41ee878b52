// Fills a camera's tables: one invocation marches one ray and leaves the means up to each of its slices, and the light
// of all of it.
#include "atmosphere/source.glsl"
#include "atmosphere/view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) writeonly uniform image2DArray u_first;
layout(rgba32f, binding = 1) writeonly uniform image2DArray u_second;
layout(rgba32f, binding = 2) readonly uniform image2D u_extinction;

void air_light_at(AirView v, AirCell cell, int layer, out vec3 first, out vec3 second) { first = second = vec3(0.0); }
vec3 air_mean_extinction(ivec2 texel) { return vec3(0.0); }

void main() {
    AirView v = air_view.camera;
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    bool inside = texel.x < v.columns && texel.y < 2 * v.rows;
    float mu_s, nu;
    AirPath p = air_texel_path(v, texel.y, float(texel.x), mu_s, nu);
    AirColumn c = air_column(p.h, p.mu, mu_s, nu, p.length_m);
    int parts = air_slice_parts();
    vec3 first, second;
    air_start_means(c, first, second);
    for (int slice = 0; slice <= v.slices; ++slice) {
        if (inside) {
            imageStore(u_first, ivec3(texel, slice), vec4(air_pack(first), 0.0));
            imageStore(u_second, ivec3(texel, slice), vec4(air_pack(second), 0.0));
        }
        if (slice == v.slices) break;
        for (int part = 0; part < parts; ++part) air_column_slice(c, slice * parts + part, v.slices * parts);
        first = air_column_mean(c, c.first);
        second = air_column_mean(c, c.second);
    }
    if (!inside) return;
    vec3 extinction = air_unpack(imageLoad(u_extinction, ivec2(texel.y, AIR_FINE * v.slices)).rgb);
    ivec3 whole = ivec3(texel, air_whole_layer(v));
    imageStore(u_first, whole, vec4(air_whole_light(first, extinction, p.length_m), 0.0));
    imageStore(u_second, whole, vec4(air_whole_light(second, extinction, p.length_m), 0.0));
}
