// Depth of the clouds' picture where it is coarser than the frame: of each block of pixels in turn the nearest and the farthest,
// as a chessboard, so that on both sides of an outline there are clouds that end where its pixels do.
//
// Define PICTURE_PX: pixels of a block's side.
layout(binding = 0) uniform sampler2D u_depth;
layout(location = 0) out float o_depth;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), most = textureSize(u_depth, 0) - 1;
    float nearest = 0.0, farthest = 1e30;
    for (int i = 0; i < PICTURE_PX * PICTURE_PX; ++i) {
        float depth = texelFetch(u_depth, min(at * PICTURE_PX + ivec2(i % PICTURE_PX, i / PICTURE_PX), most), 0).r;
        nearest = max(nearest, depth);
        farthest = min(farthest, depth);
    }
    o_depth = ((at.x + at.y) & 1) == 0 ? nearest : farthest;
}
