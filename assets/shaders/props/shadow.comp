// What props leave of the sun's light (red) and of the sky's (green) at each pixel: a workgroup a tile, which first
// finds the few props that reach into the box around its points, in axes along the sun.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "generated/props.glsl"
#include "props/shadow.glsl"

layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
layout(std430, binding = 0) readonly buffer OccluderBuffer { PropOccluder occluders[]; };
layout(std430, binding = 1) writeonly buffer TouchedBuffer { uint touched[]; };   // 1: a prop may reach into the tile
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_normal;
layout(binding = 2) uniform usampler2D u_surface;
layout(binding = 0) writeonly uniform image2D u_left;
uniform int u_count;

const uint MOST = 128u;   // props that count for a tile, for sun and sky each
shared uint s_low[3], s_high[3];
shared uint s_sun_count, s_sky_count;
shared uint s_sun[MOST], s_sky[MOST];

// Floats as integers in the same order.
uint ordered(float x) {
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float unordered(uint key) {
    return uintBitsToFloat((key & 0x80000000u) != 0u ? key & 0x7fffffffu : ~key);
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 3u) {
        s_low[lane] = 0xffffffffu;
        s_high[lane] = 0u;
    }
    if (lane == 0u) {
        s_sun_count = 0u;
        s_sky_count = 0u;
    }
    barrier();
    ivec2 size = textureSize(u_depth, 0), pixel = ivec2(gl_GlobalInvocationID.xy);
    bool inside = all(lessThan(pixel, size));
    ivec2 at = min(pixel, size - 1);
    float depth = texelFetch(u_depth, at, 0).r;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(at) + 0.5), max(depth, 1e-30));
    vec3 sun = frame.sun_direction;
    vec3 u = normalize(cross(sun, abs(sun.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0))), w = cross(sun, u);
    vec3 place = vec3(dot(u, point), dot(w, point), dot(sun, point));
    if (depth > 0.0) {
        for (int k = 0; k < 3; ++k) {
            atomicMin(s_low[k], ordered(place[k]));
            atomicMax(s_high[k], ordered(place[k]));
        }
    }
    barrier();
    if (s_high[0] != 0u) {   // the tile shows some surface
        vec3 low = vec3(unordered(s_low[0]), unordered(s_low[1]), unordered(s_low[2]));
        vec3 high = vec3(unordered(s_high[0]), unordered(s_high[1]), unordered(s_high[2]));
        for (int i = int(lane); i < u_count; i += 128) {
            PropOccluder prop = occluders[i];
            vec3 middle = vec3(dot(u, prop.place_m), dot(w, prop.place_m), dot(sun, prop.place_m));
            float radius = prop_radius(prop), length_m = prop_shadow_m(prop), reach = radius * PROP_REACH;
            vec3 wide = vec3(vec2(radius + length_m * frame.sun_radius_rad), radius);
            bool shades = length_m > 0.0 && all(greaterThan(middle + wide, low))
                && all(lessThan(middle - vec3(wide.xy, length_m), high));
            bool shelters = all(greaterThan(middle + reach, low)) && all(lessThan(middle - reach, high));
            if (shades) {
                uint slot = atomicAdd(s_sun_count, 1u);
                if (slot < MOST) s_sun[slot] = uint(i);
            }
            if (shelters) {
                uint slot = atomicAdd(s_sky_count, 1u);
                if (slot < MOST) s_sky[slot] = uint(i);
            }
        }
    }
    barrier();
    float own = texelFetch(u_surface, at, 0).r == SURFACE_PROPS ? 1.04 : 0.0;
    vec3 normal = oct_decode(texelFetch(u_normal, at, 0).rg);
    vec2 left = vec2(1.0);
    for (uint k = 0u; k < min(s_sun_count, MOST); ++k) left.r *= prop_sun(occluders[s_sun[k]], point, own);
    for (uint k = 0u; k < min(s_sky_count, MOST); ++k) left.g *= prop_ambient(occluders[s_sky[k]], point, normal, own);
    if (inside) imageStore(u_left, pixel, vec4(depth > 0.0 ? left : vec2(1.0), 0.0, 0.0));
    if (lane == 0u) {
        touched[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = s_sun_count + s_sky_count > 0u ? 1u : 0u;
    }
}
