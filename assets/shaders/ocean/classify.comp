// What each tile's sea needs: bit 0 the plain sea, 2 also bed, surf or ice, 3 the surface from below; bit 4: the tile
// shows ground; bit 5: the air before it changes within the tile. A lane a tile. (Bit 1, ground to mirror, hangs on
// other tiles: ocean/list_tiles.comp.)
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/surfaces.glsl"
#include "contract/land_water.glsl"
#include "common/texel.glsl"
#include "generated/ocean.glsl"
#include "contract/waterline.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = FLAG_BUFFER) writeonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 4) readonly buffer ShownBuffer { uint shown[]; };   // gbuffer/classify.comp
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_attributes;
layout(binding = 2) uniform usampler2D u_surface;
uniform ivec2 u_tiles;
uniform int u_high;   // 1: the camera is above much of the air

// Cosine to the vertical with which a line of sight meets the calm sea, 0 where it misses.
float meeting_cosine(vec2 ndc) {
    vec3 direction = normalize(view_ray(ndc));
    float h = frame.camera_altitude_m - planet.sea_level_m, r = planet.radius_m + planet.sea_level_m;
    float b = (r + h) * dot(direction, frame.camera_zenith);
    return sqrt(max(b * b - h * (2.0 * r + h), 0.0)) / r;
}

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    ivec2 size = textureSize(u_surface, 0), first = ivec2(tile % u_tiles.x, tile / u_tiles.x) * TILE_PX;
    ivec2 last = min(first + TILE_PX, size);
    float shallowest = 2.0, highest_sine = 0.0;
    bool above = false, below = false;
    float limit = ocean.unseen_depth_m / (ocean.unseen_depth_m + 16.0);
    // Pixel by pixel only where there is sea, or where coasts were drawn since tiles were listed.
    uint surfaces = tile < u_tiles.x * u_tiles.y ? shown[tile] : 0u;
    bool look = (surfaces & (1u << SURFACE_SEA | SURFACE_ASKED)) != 0u, any_sea = false;
    bool any_ground = !look && (surfaces & 1u << SURFACE_TERRAIN) != 0u;
    if (!look) last.y = first.y;
    for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) {
            uint surface = texel_at(u_surface, ivec2(x, y)).r;
            bool sea = surface == SURFACE_SEA;
            any_ground = any_ground || surface == SURFACE_TERRAIN;
            vec4 attributes = texel_at(u_attributes, ivec2(x, y));
            shallowest = min(shallowest, sea ? (attributes.x * 256.0 + attributes.y) * (255.0 / 65535.0) : 2.0);
#ifdef LAND_WATER
            shallowest = sea && land_water_at(attributes.z) ? 0.0 : shallowest;
#endif
            any_sea = any_sea || sea;
        }
    }
    // Ice and the waterline, by the tile's corners.
    float steepest = 0.0, flattest = 1.0;
    for (int corner = 0; corner < 4; ++corner) {
        float meets = meeting_cosine(ndc_of_pixel(vec2(first + ivec2(corner & 1, corner >> 1) * TILE_PX)));
        steepest = max(steepest, meets);
        flattest = min(flattest, meets);
        ivec2 pixel = clamp(first + ivec2(corner & 1, corner >> 1) * ivec2(15, 7), ivec2(0), size - 1);
        vec2 ndc = ndc_of_pixel(vec2(pixel) + 0.5);
        bool wet = lens_in_water(ndc);
        above = above || !wet;
        below = below || wet;
        float depth = texel_at(u_depth, pixel).r;
        highest_sine = max(highest_sine, depth > 0.0 ? abs(up_at(position_from_depth(ndc, depth)).z) : 1.0);
    }
    bool rich = shallowest < limit || highest_sine * 1.02 + 0.12 > ocean.ice_sine;
    // The way through the air goes with 1 / cosine, and so does its depth: between corners whose cosines differ by a
    // share s of the least a straight line is s^2 / 4 of it off, a thousandth. From so far that a tile is degrees of
    // the planet wide the sun's height counts too.
    bool wide = frame.camera_altitude_m * frame.pixel_rad * 16.0 > 0.03 * planet.radius_m;
    bool limb = u_high != 0 && (wide || steepest - flattest > 0.06 * flattest);
    uint found = (above ? (rich ? 4u : 1u) : 0u) | (below ? 8u : 0u);
    if (tile < u_tiles.x * u_tiles.y) flags[tile] = (any_sea ? found : 0u) | (any_ground ? 16u : 0u)
        | (limb ? 32u : 0u);
}
