// Light of trees. Leaves: Lambert's law, softened because a tuft has leaves of many directions, and light that comes
// through from behind. Chosen by eye: how much of either.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "contract/air.glsl"
#include "contract/cover_light.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"

layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer { uint tile_groups[4]; uint tiles[]; };
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = NORMAL_UNIT) uniform sampler2D u_normal;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(RADIANCE_FORMAT, binding = RADIANCE_IMAGE) writeonly uniform image2D u_radiance;

const float STARLIGHT = 1.5e-8;      // as terrain/shade.comp
const float GROUND_ALBEDO = 0.12;    // of what lies around: light from below
const float WRAP = 0.35;             // share of a tuft's leaves that turn to where its normal doesn't
const float THROUGH = 0.45;          // light that leaves let through, as a share of what they throw back
const vec3 YELLOWED = vec3(1.25, 1.15, 0.55);   // colour of that
const float BIAS_M = 0.8;            // leaves nearer to the sun than this are the tuft's own

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0)))) return;
    if (texelFetch(u_surface, pixel, 0).r != SURFACE_COVER) return;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    vec3 normal = oct_decode(texelFetch(u_normal, pixel, 0).rg), zenith = up_at(point), sun = frame.sun_direction;
    vec4 attributes = texelFetch(u_attributes, pixel, 0);
    vec3 albedo = attributes.rgb * attributes.rgb;
    bool leaf = attributes.a > 0.5;
    float open = leaf ? 2.0 * attributes.a - 1.0 : 2.0 * attributes.a;
    float left = cover_light(point, BIAS_M) * mix(0.35, 1.0, open);
    vec3 sunlight = frame.sun_irradiance * sun_visibility(point) * air_to_space(point, sun);
    float mu = dot(normal, sun), back = dot(normalize(point), sun);
    float front = leaf ? max((mu + WRAP) / (1.0 + WRAP), 0.0) : max(mu, 0.0);
    // Seen against the sun leaves glow where they are thin.
    float through = leaf ? THROUGH * (0.35 * max(-mu, 0.0) + 0.65 * max(back, 0.0) * open) : 0.0;
    vec3 from_sky = skylight(point, normal) + frame.sun_irradiance * STARLIGHT;
    vec3 around = sunlight * max(dot(zenith, sun), 0.0) * (GROUND_ALBEDO * (0.5 - 0.5 * dot(normal, zenith)));
    vec3 radiance = sunlight * left * (albedo * front + albedo * YELLOWED * through) / PI;
    radiance += albedo / PI * open * (from_sky + around);
    Air between = air_from_camera(point);
    radiance = radiance * between.transmittance + between.in_scatter;
    imageStore(u_radiance, pixel, vec4(radiance * frame.hdr_per_radiance, 1.0));
}
