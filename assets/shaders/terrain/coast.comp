// The line between land and water, pixel by pixel: the meshes meet along straight edges some pixels long, the height function
// knows better. Pixels change sides in the G-buffer before anything is shaded.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "generated/terrain_grid.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "terrain/grid_spacing.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 3) uniform usampler2D u_surface;
layout(binding = 0) writeonly uniform image2D u_normal_out;
layout(binding = 1) writeonly uniform image2D u_attributes_out;
layout(binding = 2) writeonly uniform uimage2D u_surface_out;

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * ivec2(16, 8) + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0)))) return;
    uint surface = texelFetch(u_surface, pixel, 0).r;
    if (surface != SURFACE_TERRAIN && surface != SURFACE_SEA) return;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    float drawn;
    vec3 D = foot_offset_of(point, drawn);
    float spacing = grid_spacing(D), sagitta = spacing * spacing / (8.0 * planet.radii.x);
    // Ground that was drawn well above the water stays: the meshes are wrong by a fraction of their spacing at most.
    if (surface == SURFACE_TERRAIN && drawn - planet.sea.x > 0.5 * spacing + sagitta + 2.0) return;
    // Heights have all layers down to an eighth of the spacing, about two pixels; the gradient has the vertices' band limit.
    TerrainPoint terrain = terrain_point(D, spacing);
    float height = frame.anchor_up.w + terrain.dh;
    vec3 zenith = up_at(point);
    if (surface == SURFACE_TERRAIN && height < planet.sea.x) {
        float depth = planet.sea.x - height;
        imageStore(u_normal_out, pixel, vec4(oct_encode(zenith), 0.0, 0.0));
        imageStore(u_attributes_out, pixel, vec4(sea_depth_encode(depth / (depth + 16.0)), 0.0, 0.0));
        imageStore(u_surface_out, pixel, uvec4(SURFACE_SEA));
    } else if (surface == SURFACE_SEA && height > planet.sea.x) {
        float to_sphere = planet.radii.x / (planet.radii.x + height);
        imageStore(u_normal_out, pixel, vec4(oct_encode(normalize(zenith - terrain.gradient * to_sphere)), 0.0, 0.0));
        imageStore(u_attributes_out, pixel, terrain_attributes(terrain, height));
        imageStore(u_surface_out, pixel, uvec4(SURFACE_TERRAIN));
    } else if (surface == SURFACE_SEA) {
        float depth = planet.sea.x - height;
        imageStore(u_attributes_out, pixel, vec4(sea_depth_encode(depth / (depth + 16.0)), 0.0, 0.0));
    }
}
