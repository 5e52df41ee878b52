// Clouds over the picture, drawn with "premultiplied" blending: alpha is what they take of it.
layout(binding = 0) uniform sampler2D u_clouds;
layout(location = 0) out vec4 o_color;

void main() {
    vec4 found = texelFetch(u_clouds, ivec2(gl_FragCoord.xy), 0);
    o_color = vec4(found.rgb, 1.0 - found.a);
}
