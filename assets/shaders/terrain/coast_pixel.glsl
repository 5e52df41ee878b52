// What a pixel beside a coast becomes, shared by terrain/coast_find.comp, coast_ask.comp and coast.comp.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/lens_edge.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "common/texel.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "contract/vertex_spacing.glsl"
#include "contract/waterline.glsl"

layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(binding = COAST_NORMAL_IMAGE) writeonly uniform image2D u_normal_out;
layout(binding = COAST_ATTRIBUTES_IMAGE) writeonly uniform image2D u_attributes_out;
layout(binding = COAST_SURFACE_IMAGE) writeonly uniform uimage2D u_surface_out;

// Next to the edge (WATERLINE_PX) the drawn sea leaves a gap, which is seen as water: nothing to change there.

struct CoastPixel {
    uint surface;   // as drawn
    vec3 point;     // camera-relative
    vec3 D;         // foot offset
    float depth;    // as the buffer has it
    float code;     // of the vertices' spacing
    float spacing;
    bool open;      // land or sea, and the height function has a say in which
};

CoastPixel coast_pixel(ivec2 pixel) {
    CoastPixel p;
    p.surface = texel_at(u_surface, pixel).r;
    p.depth = texel_at(u_depth, pixel).r;
    p.point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), max(p.depth, 1e-30));
    float drawn;
    p.D = foot_offset_of(p.point, drawn);
    p.code = texel_at(u_attributes, pixel).w;
    p.spacing = vertex_spacing(p.D, p.code);
    float sagitta = p.spacing * p.spacing / (8.0 * planet.radius_m);
    // Ground that was drawn well above the water stays: the meshes are wrong by a fraction of their spacing at most.
    bool high = p.surface == SURFACE_TERRAIN && drawn - planet.sea_level_m > 0.5 * p.spacing + sagitta + 2.0;
    // Seen from under water the bed is below the sea, and still in front of it.
    p.open = (p.surface == SURFACE_TERRAIN || p.surface == SURFACE_SEA) && !high
        && lens_over_water(ndc_of_pixel(vec2(pixel) + 0.5)) > WATERLINE_PX;
    return p;
}

void coast_to_sea(ivec2 pixel, CoastPixel p, float depth) {
    if (p.surface == SURFACE_TERRAIN) {
        imageStore(u_normal_out, pixel, vec4(oct_encode(up_at(p.point)), 0.0, 0.0));
        imageStore(u_surface_out, pixel, uvec4(SURFACE_SEA));
    }
    imageStore(u_attributes_out, pixel, vec4(sea_depth_encode(depth / (depth + 16.0)), 0.0, p.code));
}

// above: height above the sea; attributes: as terrain_attributes has them.
void coast_to_land(ivec2 pixel, CoastPixel p, vec3 gradient, float above, vec3 attributes) {
    float to_sphere = planet.radius_m / (planet.radius_m + planet.sea_level_m + above);
    imageStore(u_normal_out, pixel, vec4(oct_encode(normalize(up_at(p.point) - gradient * to_sphere)), 0.0, 0.0));
    imageStore(u_attributes_out, pixel, vec4(attributes, p.code));
    imageStore(u_surface_out, pixel, uvec4(SURFACE_TERRAIN));
}
