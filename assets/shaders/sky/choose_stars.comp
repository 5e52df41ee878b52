// How many stars can show, and whether the Milky Way can, at the least exposure that this frame may come to: they are
// drawn before anybody knows it. Stars are sorted by brightness. One lane; writes both indirect draws.
#include "generated/bindings.glsl"
#include "composite/exposure.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = EXPOSURE_BEFORE_BUFFER) readonly buffer ExposureBefore { Exposure before; };
layout(std430, binding = 5) writeonly buffer DrawBuffer { uint galaxy[5]; uint stars[5]; };

uniform float u_lowest_ev100;   // that may come
uniform float u_share;          // of the way there that one frame may go
// exposed at EV100 0 over the least that shows
uniform float u_brightest_star;
uniform float u_brightest_cloud;   // of the Milky Way
uniform float u_fall;    // the star of rank k has at most k^-u_fall of the brightest one's light
uniform uint u_count;    // of stars there are

void main() {
    // What the scene asks for counts as well: a dark scene's exposure is metered with all of its stars.
    float ev = min(mix(before.ev100, min(u_lowest_ev100, before.ev100), u_share), before.target_ev100);
    float exposed = exp2(-ev);
    float count = clamp(pow(max(u_brightest_star * exposed, 1e-30), 1.0 / u_fall), 0.0, float(u_count));
    uint clouds = u_brightest_cloud * exposed >= 1.0 ? 3u : 0u;
    uint draws[10] = uint[10](clouds, 1u, 0u, 0u, 0u, uint(count), 1u, 0u, 0u, 0u);
    for (int k = 0; k < 5; ++k) {
        galaxy[k] = draws[k];
        stars[k] = draws[5 + k];
    }
}
