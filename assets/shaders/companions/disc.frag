// A companion of many pixels: the mean of the texels inside each pixel.
layout(binding = 0) uniform sampler2D u_picture;
uniform ivec2 u_corner;   // of the picture, in pixels from the lower left
uniform int u_texels;     // along each side of a pixel
layout(location = 0) out vec4 o_light;

void main() {
    ivec2 first = (ivec2(gl_FragCoord.xy) - u_corner) * u_texels;
    vec4 total = vec4(0.0);
    for (int k = 0; k < u_texels * u_texels; ++k)
        total += texelFetch(u_picture, first + ivec2(k % u_texels, k / u_texels), 0);
    o_light = total / float(u_texels * u_texels);
}
