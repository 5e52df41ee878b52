// Light of props, and their shadows on ground and water: the radiance there, without the air before it, is scaled by
// the share of its light that they leave.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"

layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = NORMAL_UNIT) uniform sampler2D u_normal;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(binding = 4) uniform sampler2D u_shadow;
layout(RADIANCE_FORMAT, binding = RADIANCE_IMAGE) uniform image2D u_radiance;

const float STARLIGHT = 1.5e-8;   // as terrain/shade.comp
const float GROUND_ALBEDO = 0.2;  // of what lies around: light from below

// Reflected radiance per irradiance at normal incidence: Lambert below a dielectric GGX surface (Walter et al. 2007)
// with Hammon's 2017 approximation of Smith's joint masking.
vec3 reflected(vec3 albedo, float roughness, vec3 normal, vec3 view, vec3 sun) {
    float alpha = roughness * roughness, n_l = max(dot(normal, sun), 0.0), n_v = max(dot(normal, view), 1e-3);
    vec3 half_vector = normalize(view + sun);
    float n_h = max(dot(normal, half_vector), 0.0), v_h = max(dot(view, half_vector), 0.0);
    float bend = n_h * n_h * (alpha * alpha - 1.0) + 1.0, t = 1.0 - v_h, t2 = t * t;
    float fresnel = 0.04 + 0.96 * t2 * t2 * t;
    float glint = alpha * alpha / (PI * bend * bend) * fresnel * 0.5 / mix(2.0 * n_l * n_v, n_l + n_v, alpha);
    return (albedo * (1.0 - fresnel) / PI + glint) * n_l;
}

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0)))) return;
    uint surface = texelFetch(u_surface, pixel, 0).r;
    vec2 left = texelFetch(u_shadow, pixel, 0).rg;
    bool ground = (surface == SURFACE_TERRAIN || surface == SURFACE_SEA) && min(left.r, left.g) < 0.998;
    if (surface != SURFACE_PROPS && !ground) return;

    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    vec3 normal = oct_decode(texelFetch(u_normal, pixel, 0).rg), zenith = up_at(point), view = -normalize(point);
    vec3 sun = frame.sun_direction;
    vec3 sunlight = frame.sun_irradiance * sun_visibility(point) * air_to_space(point, sun);
    vec3 from_sky = skylight(point, normal) + frame.sun_irradiance * STARLIGHT;
    Air between = air_from_camera(point);
    if (ground) {
        vec3 direct = sunlight * max(dot(normal, sun), 0.0);
        vec3 share = (direct * left.r + from_sky * left.g) / max(direct + from_sky, 1e-30);
        // The sky's image in the water stays; what shines out of it and the sun's glitter don't.
        float facing = 1.0 - clamp(dot(normal, view), 0.0, 1.0), facing2 = facing * facing;
        share = mix(share, vec3(1.0), surface == SURFACE_SEA ? 0.02 + 0.98 * facing2 * facing2 * facing : 0.0);
        vec3 seen = imageLoad(u_radiance, pixel).rgb, air_light = between.in_scatter * frame.hdr_per_radiance;
        imageStore(u_radiance, pixel, vec4(max(seen - air_light, 0.0) * share + min(seen, air_light), 1.0));
        return;
    }
    vec4 attributes = texelFetch(u_attributes, pixel, 0);
    vec3 albedo = attributes.rgb * attributes.rgb;
    vec3 around = sunlight * max(dot(zenith, sun), 0.0) * (GROUND_ALBEDO * (0.5 - 0.5 * dot(normal, zenith)));
    vec3 radiance = sunlight * left.r * reflected(albedo, attributes.a, normal, view, sun);
    radiance += albedo / PI * left.g * (from_sky + around);
    radiance = radiance * between.transmittance + between.in_scatter;
    imageStore(u_radiance, pixel, vec4(radiance * frame.hdr_per_radiance, 1.0));
}
