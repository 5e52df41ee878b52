layout(binding = 0) uniform sampler2D u_picture;
in vec2 v_uv;
layout(location = 0) out vec4 o_color;

#ifdef SCALED
// Catmull-Rom: a picture of other size keeps its edges, and a constant stays one. What overshoots is cut to what the
// four nearest pixels show, so that no edge gets a bright or dark line.
vec4 weights(float t) {
    return 0.5 * vec4(((2.0 - t) * t - 1.0) * t, (3.0 * t - 5.0) * t * t + 2.0, ((4.0 - 3.0 * t) * t + 1.0) * t,
                      (t - 1.0) * t * t);
}

vec3 picture(vec2 uv) {
    ivec2 size = textureSize(u_picture, 0);
    vec2 at = uv * vec2(size) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec4 across = weights(at.x - float(first.x)), up = weights(at.y - float(first.y));
    vec3 sum = vec3(0.0), least = vec3(1.0), most = vec3(0.0);
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 4; i++) {
            vec3 seen = texelFetch(u_picture, clamp(first + ivec2(i - 1, j - 1), ivec2(0), size - 1), 0).rgb;
            sum += across[i] * up[j] * seen;
            bool near = (i == 1 || i == 2) && (j == 1 || j == 2);
            least = near ? min(least, seen) : least;
            most = near ? max(most, seen) : most;
        }
    }
    return clamp(sum, least, most);
}
#else
vec3 picture(vec2 uv) {
    return texelFetch(u_picture, ivec2(uv * vec2(textureSize(u_picture, 0))), 0).rgb;
}
#endif

void main() {
    o_color = vec4(picture(v_uv), 1.0);
}
