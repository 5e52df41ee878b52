// Light of a smooth sea: what its surface mirrors (sky, sun) and what comes up from below (water, and ground where it is shallow).
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "generated/ocean.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/sun_visibility.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_normal;
layout(binding = 2) uniform sampler2D u_attributes;
layout(binding = 3) uniform usampler2D u_surface;
in vec2 v_ndc;
layout(location = 0) out vec4 o_radiance;

const float PI = 3.14159265358979;
const float WATER_F0 = 0.0204;   // ((1.333 - 1) / (1.333 + 1))^2

// Smith's masking of a Beckmann surface, rational fit of Walter et al. 2007 (their equation 24 and the text below it).
float smith_beckmann(float cosine, float alpha) {
    float a = cosine / (alpha * sqrt(max(1.0 - cosine * cosine, 1e-8)));
    return a >= 1.6 ? 1.0 : (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(u_surface, pixel, 0).r != SURFACE_SEA) discard;
    vec3 point = position_from_depth(v_ndc, texelFetch(u_depth, pixel, 0).r);
    vec3 view = -normalize(point);
    vec3 normal = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    vec2 bytes = texelFetch(u_attributes, pixel, 0).rg * 255.0;
    float shallow = (bytes.x * 256.0 + bytes.y) / 65535.0;
    float depth_m = 16.0 * shallow / max(1.0 - shallow, 1e-4);

    vec3 sun = frame.sun_direction.xyz;
    bool below = dot(view, normal) < 0.0;
    vec3 facing = below ? -normal : normal;
    float n_v = max(dot(facing, view), 1e-3), n_l = dot(normal, sun);
    vec3 sunlight = frame.sun_irradiance.rgb * sun_visibility(point) * air_to_space(point, sun);
    vec3 skylight = sky_irradiance(point, normal);

    // The sun's glitter: Beckmann's distribution of slopes.
    float alpha = ocean.water.x;
    vec3 half_vector = normalize(view + sun);
    float n_h = max(dot(facing, half_vector), 1e-4), v_h = max(dot(view, half_vector), 0.0);
    float tan2 = (1.0 - n_h * n_h) / (n_h * n_h);
    float distribution = exp(-tan2 / (alpha * alpha)) / (PI * alpha * alpha * n_h * n_h * n_h * n_h);
    float fresnel_sun = WATER_F0 + (1.0 - WATER_F0) * pow(1.0 - v_h, 5.0);
    float glitter = below || n_l <= 0.0 ? 0.0
        : distribution * fresnel_sun * smith_beckmann(n_v, alpha) * smith_beckmann(n_l, alpha) / (4.0 * n_v);

    // A rough sea seen at a flat angle shows faces that are turned towards the eye: the mean Fresnel term stays below one.
    float fresnel = WATER_F0 + (1.0 - WATER_F0) * pow(1.0 - n_v, 5.0 / (1.0 + 2.0 * alpha));
    vec3 mirrored = sky(reflect(-view, facing)) * fresnel;

    // Light from below: single scattering of the water column over a sandy bed, both ways through the column.
    vec3 loss = ocean.absorption.rgb + ocean.scattering.rgb;
    float down = sqrt(1.0 - (1.0 - max(n_l, 0.0) * max(n_l, 0.0)) / 1.777), back = sqrt(1.0 - (1.0 - n_v * n_v) / 1.777);
    vec3 through = exp(-loss * depth_m * (1.0 / down + 1.0 / back));
    vec3 reflectance = ocean.scattering.rgb / (2.0 * loss) * (1.0 - through) + ocean.bed.rgb * through;
    float enters = 1.0 - (WATER_F0 + (1.0 - WATER_F0) * pow(1.0 - max(n_l, 0.0), 5.0));
    vec3 upwelling = reflectance * (sunlight * max(n_l, 0.0) * enters + skylight) / PI * (1.0 - fresnel) * 0.54;

    vec3 radiance = upwelling + mirrored + glitter * sunlight;
    Air between = air(vec3(0.0), point);
    o_radiance = vec4((radiance * between.transmittance + between.in_scatter) * frame.scale.x, 1.0);
}
