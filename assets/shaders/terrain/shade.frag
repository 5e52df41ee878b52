// Materials and light of the ground, once per pixel: the vertices' normal, continued by the layers below their spacing.
#include "common/camera.glsl"
#include "generated/terrain_grid.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "terrain/height.glsl"
#include "terrain/grid_spacing.glsl"
#include "terrain/material.glsl"
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

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(u_surface, pixel, 0).r != SURFACE_TERRAIN) discard;
    vec3 point = position_from_depth(v_ndc, texelFetch(u_depth, pixel, 0).r);
    float height;
    vec3 D = foot_offset_of(point, height);
    vec3 zenith = up_at(point);
    vec3 view = -normalize(point);
    vec3 coarse = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    vec4 attributes = texelFetch(u_attributes, pixel, 0);
    float roughness = attributes.x * 4.0, moisture = attributes.y;

    // What a pixel covers on the ground: wider along the view at flat angles; the geometric mean keeps detail without noise.
    float across = length(point) * frame.clock.w;
    float footprint = across / sqrt(max(dot(coarse, view), 0.06));
    float to_sphere = planet.radii.x / (planet.radii.x + height);
    vec3 gradient = zenith - coarse / max(dot(coarse, zenith), 0.05);
    gradient += terrain_detail_gradient(D, roughness, grid_spacing(D), footprint) * to_sphere;
    vec3 normal = normalize(zenith - gradient);

    Material material = terrain_material(D, zenith, height, length(gradient), roughness, moisture, footprint);

    vec3 sun = frame.sun_direction.xyz;
    float n_l = max(dot(normal, sun), 0.0);
    vec3 sunlight = frame.sun_irradiance.rgb * sun_visibility(point) * air_to_space(point, sun);
    // Light that lit neighbouring ground throws back: without it the airless dark sides would be pure black.
    float sun_height = max(dot(zenith, sun), 0.0);
    vec3 bounce = material.albedo * sunlight * sun_height * (0.5 - 0.5 * dot(normal, zenith)) * 0.6;
    vec3 irradiance = sunlight * n_l + sky_irradiance(point, normal) + bounce;
    vec3 radiance = material.albedo * irradiance / PI;

    Air between = air(vec3(0.0), point);
    o_radiance = vec4((radiance * between.transmittance + between.in_scatter) * frame.scale.x, 1.0);
}
