// Clouds over the picture, and the light that the air in their shadow doesn't scatter off it. What is drawn into is
// read as well, each pixel by itself alone.
//
// Define PICTURE_PX: a pixel of the clouds' picture has so many of the frame's a side. Between those of a coarser
// picture clouds are interpolated; those that end at this pixel's own surface count most.
//
// HELD: of a still picture that has all its rays, while anti-aliasing looks at other places in the pixels. Along an
// outline they show another surface than that up to which clouds were followed: then pixels beside them have those.
layout(binding = 0) uniform sampler2D u_clouds;   // nearest
layout(binding = 1) uniform sampler2D u_radiance;
#if PICTURE_PX > 1 || defined(HELD)
layout(binding = 2) uniform sampler2D u_depth;
layout(binding = 3) uniform sampler2D u_surface;   // depth up to which clouds were followed
#endif
in vec2 v_uv;
layout(location = 0) out vec4 o_radiance;

const float LEFT = 0.2;   // of the light behind

#ifdef HELD
const float SAME_SURFACE = 0.7;   // least ratio of distances, as in resolve.comp
const float NONE = 1e30;

// Distance over that of the near plane; the sky's is the largest.
float distance_of(float depth) {
    return 1.0 / max(depth, 1e-20);
}
#endif

vec4 clouds_of(ivec2 pixel) {
#ifdef HELD
    // Between the last before this pixel's surface and the first behind it: along a sea's horizon rows lie kilometres
    // apart, and what there is before them grows with the distance.
    vec2 texel = 1.0 / vec2(textureSize(u_clouds, 0)), before = v_uv, behind = v_uv;
    float own = distance_of(textureLod(u_depth, v_uv, 0.0).r), nearer = 0.0, farther = NONE, there = own;
    for (int i = 0; i < 5; ++i) {
        vec2 at = v_uv + texel * vec2(i == 1 ? -1 : i == 2 ? 1 : 0, i == 3 ? -1 : i == 4 ? 1 : 0);
        float away = distance_of(textureLod(u_surface, at, 0.0).r);
        there = i == 0 ? away : there;
        before = away <= own && away > nearer ? at : before;
        nearer = away <= own ? max(away, nearer) : nearer;
        behind = away >= own && away < farther ? at : behind;
        farther = away >= own ? min(away, farther) : farther;
    }
    bool same = min(own, there) >= SAME_SURFACE * max(own, there);
    float share = same || farther == NONE ? 0.0 : nearer == 0.0 ? 1.0 : (own - nearer) / max(farther - nearer, 1e-20);
    return mix(textureLod(u_clouds, same ? v_uv : before, 0.0), textureLod(u_clouds, behind, 0.0), share);
#elif PICTURE_PX > 1
    vec2 at = (vec2(pixel) + 0.5) / float(PICTURE_PX) - 0.5, first = floor(at), share = at - first, rest = 1.0 - share;
    vec2 texel = 1.0 / vec2(textureSize(u_clouds, 0));
    vec4 weight = vec4(rest.x * rest.y, share.x * rest.y, rest.x * share.y, share.x * share.y), found[4];
    for (int i = 0; i < 4; ++i) found[i] = textureLod(u_clouds, (first + 0.5 + vec2(i & 1, i >> 1)) * texel, 0.0);
    // In the order of the others; it clamps as they do.
    vec4 ends = textureGather(u_surface, (first + 1.0) * texel).wzxy;
    // Depth is near / distance: its ratio is that of the distances. Of depths that this pixel's is 1 in, or 0 for the
    // sky.
    float depth = textureLod(u_depth, v_uv, 0.0).r, per = 1.0 / max(depth, 1e-20);
    ends = min(ends * per, 1e3);
    vec4 apart = ends - depth * per, larger = max(ends, 1.0);
    apart *= apart;
    larger *= larger;
    // (weight + 1e-3) / (1e-3 + unlike^2) of each with unlike = apart / larger, over a common denominator: divisions
    // are slow.
    vec4 under = 1e-3 * larger + apart;
    weight = (weight + 1e-3) * larger * vec4(under.yx * (under.z * under.w), under.wz * (under.x * under.y));
    vec4 sum = weight.x * found[0] + weight.y * found[1] + weight.z * found[2] + weight.w * found[3];
    return sum * (1.0 / (weight.x + weight.y + weight.z + weight.w));
#else
    return textureLod(u_clouds, v_uv, 0.0);
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 clouds = clouds_of(pixel), picture = textureLod(u_radiance, v_uv, 0.0);
    // Shafts are smooth and what lies behind is not: along an outline a ray to the sky may take more than a pixel of
    // near ground has of the air's light. So much less is taken of all colours that some of each is left.
    vec3 behind = max(picture.rgb * clouds.a, 0.0), shadowed = max(-clouds.rgb, 0.0),
        share = (1.0 - LEFT) * behind / max(shadowed, 1e-30);
    float most = min(min(share.r, min(share.g, share.b)), 1.0);
    o_radiance = vec4(behind + max(clouds.rgb, 0.0) - most * shadowed, picture.a);
}
