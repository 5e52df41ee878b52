// The ground of the projected grid's paper mode around an anchor: a continents texture in longitude and latitude, and
// layers of simplex noise. float64 twin: systems/terrain/paper_ground.py. D is the foot on the reference sphere minus
// the anchor's foot.
//
// Longitude and latitude are differences from the anchor's, built without cancellation: near the anchor they are as
// good as D.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "common/simplex.glsl"
#include "generated/paper_table.glsl"

layout(binding = CONTINENTS_UNIT) uniform sampler2D u_continents;

// atan(y, x), right to 2e-7 radians: the built-in one is a hundred times worse on some drivers. Fit to atan(t) / t on
// [0, 1].
float paper_atan(float y, float x) {
    float a = abs(x), b = abs(y), t = min(a, b) / max(max(a, b), 1e-30), t2 = t * t;
    float r = t * (0.999999986 + t2 * (-0.33333094 + t2 * (0.199930541 + t2 * (-0.142071332 + t2 * (0.106546749
        + t2 * (-0.0753366962 + t2 * (0.0430392817 + t2 * (-0.0162829498 + t2 * 0.00290353685))))))));
    r = b > a ? 1.5707963 - r : r;
    r = x < 0.0 ? PI - r : r;
    return y < 0.0 ? -r : r;
}

vec4 paper_spline(float f) {
    float g = 1.0 - f;
    return vec4(g * g * g, 4.0 - 6.0 * f * f + 3.0 * f * f * f, 4.0 - 6.0 * g * g + 3.0 * g * g * g, f * f * f) / 6.0;
}

// Height of the continents above the anchor's height, and the relief that they lack; texels are as wide as footprints.
vec2 paper_continents(vec3 D, float footprint_m) {
    vec3 d = D / paper_table.radius_m, up = paper_table.up;
    vec2 meridian = paper_table.meridian;
    float beside = paper_table.beside + meridian.x * d.y - meridian.y * d.x;
    float along = dot(meridian, up.xy + d.xy);
    float columns = paper_atan(beside, along) * (float(PAPER_TEXELS) / TWO_PI);
    float rho0 = paper_table.from_axis, rho = length(up.xy + d.xy);
    float wider = dot(d.xy, 2.0 * up.xy + d.xy) / max(rho + rho0, 1e-20);
    float rows = paper_atan(d.z * rho0 - wider * up.z, (up.z + d.z) * up.z + rho * rho0)
        * (float(PAPER_TEXELS) / PI);

    float texels = footprint_m * (float(PAPER_TEXELS) / TWO_PI) / paper_table.radius_m;
    int level = int(round(log2(clamp(texels, 1.0, float(PAPER_TEXELS / 8))))), side = PAPER_TEXELS >> level;
    ivec2 anchor = paper_table.texel >> level;
    vec2 fraction = vec2(paper_table.texel - (anchor << level)) + paper_table.texel_fraction + vec2(columns, rows);
    vec2 place = (fraction + 0.5) * exp2(-float(level)) - 0.5, whole = floor(place);
    vec4 across = paper_spline(place.x - whole.x), upwards = paper_spline(place.y - whole.y);
    ivec2 first = anchor + ivec2(whole);
    vec2 total = vec2(0.0);
    for (int k = 0; k < 4; ++k) {
        int y = first.y + k - 1;
        bool over = y < 0 || y >= side;   // over a pole columns go on half a turn away
        y = y < 0 ? -1 - y : y >= side ? 2 * side - 1 - y : y;
        int x = first.x - 1 + (over ? side / 2 : 0);
        for (int l = 0; l < 4; ++l) {
            vec2 texel = texelFetch(u_continents, ivec2((x + l) & (side - 1), y), level).rg;
            total += upwards[k] * across[l] * (texel - vec2(paper_table.height_m, 0.0));
        }
    }
    return total;
}

// Height above the anchor's height at foot offset D, all layers. seen: without what a footprint can't show. Waves of
// simplex noise are down to half as wide as its cells, so a layer of less than four footprints is not there at all, and
// one of eight in full.
float paper_dh(vec3 D, float footprint_m, float texels_m, out float seen) {
    vec2 land = paper_continents(D, texels_m);
    float noise = 0.0, shown = 0.0;
    for (int k = 0; k < paper_table.layer_count; ++k) {
        PaperOctave octave = paper_table.layers[k];
        vec3 d = D * octave.frequency_per_m;
        d += (d.x + d.y + d.z) * (1.0 / 3.0);
        vec3 whole = floor(d);
        vec3 f = (d - whole) + octave.fraction;
        vec3 carry = floor(f);
        float value = octave.amplitude * simplex_noise(octave.cell + ivec3(whole) + ivec3(carry), f - carry);
        noise += value;
        shown += value * (1.0 - smoothstep(0.125, 0.25, octave.frequency_per_m * footprint_m));
    }
    seen = land.x + land.y * shown;
    return land.x + land.y * noise;
}

float paper_dh(vec3 D) {
    float seen;
    return paper_dh(D, 0.0, 0.0, seen);
}

// What a pixel that wide shows, from texels as wide as that too.
float paper_seen_dh(vec3 D, float footprint_m) {
    float seen, whole = paper_dh(D, footprint_m, footprint_m, seen);
    return seen;
}
