// One map of the clouds' shadow: for each place at the reference height, what of the sunlight comes through all layers.
#include "common/camera.glsl"
#include "clouds/density.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rg16f) uniform writeonly image2DArray o_shadow;
layout(location = 0) uniform int u_level;
layout(location = 1) uniform int u_steps;
layout(location = 2) uniform vec4 u_middle;   // of the map, from the anchor in planet axes, at the reference height; half width
layout(location = 3) uniform vec4 u_up;       // there

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(o_shadow).xy;
    if (any(greaterThanEqual(at, size))) return;
    vec2 aside = ((vec2(at) + 0.5) / vec2(size) * 2.0 - 1.0) * u_middle.w;
    // On the sphere of the reference height, below the tangent plane by the sagitta; far out it ends.
    float r = planet.radii.x + cloud_view.shadow.x, grow = r / planet.radii.x;
    aside *= grow;
    float aside2 = min(dot(aside, aside), 0.98 * r * r);
    float drop = aside2 / (r + sqrt(r * r - aside2));
    vec3 from_middle = aside.x * cloud_view.shadow_u[u_level].xyz + aside.y * cloud_view.shadow_v[u_level].xyz;
    vec3 place = u_middle.xyz + from_middle - u_up.xyz * drop;
    vec3 up = normalize(u_up.xyz * (r - drop) + from_middle);
    float mu = dot(up, frame.sun_direction.xyz), footprint = 2.0 * u_middle.w / float(size.x);
    CloudWeather w = cloud_weather(up, footprint);
    float depth = 0.0;
    for (int layer = 0; layer < int(cloud_view.counts.x); ++layer) {
        vec4 shell = cloud_view.shell[layer];
        float slant = 1.0 / max(mu, 0.06), step_m = (shell.y - shell.x) / float(u_steps);
        for (int i = 0; i < u_steps; ++i) {
            float share = (float(i) + 0.5) / float(u_steps);
            float rise = mix(shell.x, shell.y, share) - cloud_view.shadow.x;
            vec3 there = place + frame.sun_direction.xyz * (rise * slant);
            depth += shell.w * step_m * slant * cloud_density(layer, there, share, w, max(footprint, 0.5 * step_m), 0);
        }
    }
    // Two-stream, conservative: 1 / (1 + 3/4 (1 - g) depth) of all light comes through (Bohren 1987).
    float seeps = 1.0 / (1.0 + 0.75 * (1.0 - cloud_view.droplets[0].y) * depth);
    float beam = exp(-depth);
    float night = step(-0.05, mu);
    imageStore(o_shadow, ivec3(at, u_level), vec4(beam, mix(1.0, mix(beam, seeps, 0.7), night), 0.0, 0.0));
}
