// Contract "cloud_sky" (common/cloud_sky.glsl has the rules), from a small map that is marched now and then.
#include "generated/bindings.glsl"
#include "clouds/sky_map.glsl"
#include "generated/cloud_view.glsl"

layout(binding = CLOUD_SKY_UNIT) uniform sampler2D u_cloud_sky;

vec4 cloud_sky(vec3 direction) {
    vec4 found = textureLod(u_cloud_sky, cloud_sky_place(direction), 0.0);
    return cloud_view.layer_count > 0 && cloud_view.sea_clouds > 0.0 ? vec4(found.rgb * frame.radiance_per_hdr, found.a)
        : vec4(0.0, 0.0, 0.0, 1.0);
}
