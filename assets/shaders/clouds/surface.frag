// Depth of the clouds' picture where each of its pixels stands for a block of 2 x 2: in the block's middle, where one
// surface fills it. Across an outline the nearest and the farthest in turn, as a checkerboard, so that on both sides of
// it there are clouds that end where its pixels do.
layout(binding = 0) uniform sampler2D u_depth;
layout(location = 0) out float o_depth;

// How far depth may be from linear on screen, relative, within one surface. On a plane it is linear.
const float BENT = 0.005;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), most = textureSize(u_depth, 0) - 1;
    // Beyond the last row and column as these are.
    vec4 depth = textureGather(u_depth, vec2(at * 2 + 1) / vec2(most + 1)).wzxy;
    float nearest = max(max(depth.x, depth.y), max(depth.z, depth.w)),
        farthest = min(min(depth.x, depth.y), min(depth.z, depth.w));
    bool one = farthest > 0.0 && abs(depth.x + depth.w - depth.y - depth.z) <= BENT * (depth.x + depth.w);
    o_depth = one ? 0.25 * (depth.x + depth.y + depth.z + depth.w) : ((at.x + at.y) & 1) == 0 ? nearest : farthest;
}
