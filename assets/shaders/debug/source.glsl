// The texture under inspection. SOURCE: 0 float 2D, 1 unsigned 2D, 2 float 3D, 3 float array. Slices lie side by side.
#include "generated/bindings.glsl"
#define SOURCE_UINT 1
#define SOURCE_3D 2
#define SOURCE_ARRAY 3

#if SOURCE == SOURCE_UINT
layout(binding = DEBUG_SOURCE_UNIT) uniform usampler2D u_source;
#elif SOURCE == SOURCE_3D
layout(binding = DEBUG_SOURCE_UNIT) uniform sampler3D u_source;
#elif SOURCE == SOURCE_ARRAY
layout(binding = DEBUG_SOURCE_UNIT) uniform sampler2DArray u_source;
#else
layout(binding = DEBUG_SOURCE_UNIT) uniform sampler2D u_source;
#endif

#if SOURCE == SOURCE_3D || SOURCE == SOURCE_ARRAY
vec4 source_at(vec2 uv) {
    ivec3 size = textureSize(u_source, 0);
    int columns = int(ceil(sqrt(float(size.z))));
    int rows = (size.z + columns - 1) / columns;
    vec2 place = clamp(uv, 0.0, 0.999999) * vec2(columns, rows);
    ivec2 tile = ivec2(place);
    int slice = (rows - 1 - tile.y) * columns + tile.x;
    if (slice >= size.z) return vec4(0.0);
    return texelFetch(u_source, ivec3(ivec2(fract(place) * vec2(size.xy)), slice), 0);
}
#else
vec4 source_at(vec2 uv) {
    ivec2 size = textureSize(u_source, 0);
    return vec4(texelFetch(u_source, min(ivec2(uv * vec2(size)), size - 1), 0));
}
#endif

// As a whole number, which a float would round above 2^24.
uint number_at(vec2 uv) {
#if SOURCE == SOURCE_UINT
    ivec2 size = textureSize(u_source, 0);
    return texelFetch(u_source, min(ivec2(uv * vec2(size)), size - 1), 0).r;
#else
    return uint(source_at(uv).r);
#endif
}
