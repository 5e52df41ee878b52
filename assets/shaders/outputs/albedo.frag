// Albedo and material of what keeps its colour in the G-buffer: props and trees. Ground and water add theirs
// (terrain/labels.comp, ocean/labels.comp).
#include "generated/material_ids.glsl"
#include "common/surfaces.glsl"
#include "cover/translucency.glsl"

layout(binding = 0) uniform sampler2D u_attributes;
layout(binding = 1) uniform usampler2D u_surface;
layout(location = 0) out vec4 o_albedo;   // w: number of the material

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint surface = texelFetch(u_surface, pixel, 0).r;
    vec4 attributes = texelFetch(u_attributes, pixel, 0);   // the albedo's root
    bool prop = surface == SURFACE_PROPS, tree = surface == SURFACE_COVER;
    bool leaf = attributes.a > 0.5 || is_coded_leaf(attributes);
    uint material = prop ? MATERIAL_PROPS : leaf ? MATERIAL_LEAVES : MATERIAL_WOOD;
    o_albedo = prop || tree ? vec4(attributes.rgb * attributes.rgb, float(material)) : vec4(0.0);
}
