// Contract "cloud_shadow" (common/cloud_shadow.glsl has the rules), from maps around the camera. A place on a map is
// where sunlight meets the clouds' reference height.
#include "generated/bindings.glsl"
#include "clouds/shadow_maps.glsl"

layout(binding = CLOUD_SHADOW_UNIT) uniform sampler2DArray u_cloud_shadow;

// As clouds/slab_transmittance.glsl has it, of all cloud above a point on its way to the sun. wide_m: the mean over so
// much.
vec4 slab_transmittance_at(vec3 point, float altitude, float wide_m) {
    float unused, mu_s = dot(up_at(point), frame.sun_direction);
    vec3 D = foot_offset_of(cloud_sun_place(point, altitude, mu_s), unused);
    vec4 sum = vec4(0.0);
    float left = 1.0;
    int levels = cloud_view.shadow_map_count, level = cloud_first_map_of(D, wide_m);
    do {
        vec2 at = cloud_map_place(D, level);
        float known = left * cloud_map_share(at, level);
        sum += known * textureLod(u_cloud_shadow, vec3(0.5 + 0.5 * clamp(at, -1.0, 1.0), float(level)), 0.0);
        left -= known;
    } while (++level < levels && left > 0.0);
    // Beyond all maps, and above all cloud, the sky is clear.
    float above = cloud_node(altitude) / max(float(cloud_view.shadow_intervals), 1.0);
    return mix(sum + left * vec4(1.0, 0.0, 1.0, 0.0), vec4(1.0, 0.0, 1.0, 0.0), levels > 0 ? above : 1.0);
}

float cloud_shadow(vec3 point) {
    return mix(1.0, slab_transmittance_at(point, altitude_of(point), 0.0).x, cloud_view.surface_shadows);
}
