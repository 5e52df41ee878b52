// Light that droplets have scattered more than once: moments of a plane slab as deep as the clouds above and below a
// point, from a table (systems/clouds/slab.py), and what the forward peak does to light that is scattered once besides.
//
// Defines: CLOUD_SLAB (depths, suns, shares of the table, as a vec3), CLOUD_SLAB_RANGE (least depth, logarithm of the
// ratio of the most to it, least cosine of the sun).
#include "generated/bindings.glsl"
#include "clouds/droplets.glsl"

const int CLOUD_DEGREE = 3, CLOUD_LOBES = 8;
const float CLOUD_BROADEN = 0.6, CLOUD_BACK = 0.5;
const float CLOUD_LOBES_DEEPEST = 1e3;   // beyond, powers of the depth overflow, and nothing is left of the light

layout(binding = CLOUD_SLAB_UNIT) uniform sampler3D u_cloud_slab;

// Share of scattered light that counts as going straight on (delta-M, Wiscombe 1977).
float cloud_peak(int layer) {
    float g = max(cloud_model.layers[layer].asymmetry, 0.0);
    return cloud_model.layers[layer].albedo * g * g * g * g;
}

// The sun's cosine for the slab. A shell gets some light from a level sun, and from one a little below: as much as if
// it stood where the light's way through the shell is that long.
float cloud_slab_sun(int layer, float mu_s) {
    CloudModelLayer shell = cloud_model.layers[layer];
    float c2 = 0.5 * (shell.top_m - shell.base_m) / (shell_radius() + shell.top_m);
    float root = sqrt(mu_s * mu_s + 4.0 * c2);
    return mu_s > 0.0 ? 0.5 * (mu_s + root) : 2.0 * c2 / (root - mu_s);
}

// Harmonics of a ray and a sun, for the table's moments: mu, mu_s: cosines of the ray and of the sun to the zenith, nu:
// between the two.
struct CloudHarmonics {
    vec4 moments[3];   // order m of degree l is number l (l + 1) / 2 + m, as in the table
};

CloudHarmonics cloud_harmonics(float mu, float mu_s, float nu) {
    // As in atmosphere/moments.glsl: (sin sin_s)^m cos(m phi) and P_l^m / sin^m by their recurrences.
    float rho2 = max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 0.0), rho = sqrt(rho2);
    float x = clamp(nu - mu * mu_s, -rho, rho), turn = 1.0, turn_last = 0.0, diagonal = 1.0;
    CloudHarmonics found;
    found.moments[2] = vec4(0.0);
    for (int order = 0; order <= CLOUD_DEGREE; ++order) {
        float p = diagonal, p_last = 0.0;
        for (int l = order; l <= CLOUD_DEGREE; ++l) {
            int index = l * (l + 1) / 2 + order;
            found.moments[index >> 2][index & 3] = p * turn;
            float p_next = (float(2 * l + 1) * mu * p - float(l + order) * p_last) / float(l + 1 - order);
            p_last = p;
            p = p_next;
        }
        diagonal *= float(2 * order + 1);
        float turn_next = order == 0 ? x : 2.0 * x * turn - rho2 * turn_last;
        turn_last = turn;
        turn = turn_next;
    }
    return found;
}

// Radiance per optical depth towards the camera for a sun of irradiance 1 on top of the clouds. up, down: vertical
// optical depth of the clouds above and below; sun: cloud_slab_sun().
float cloud_slab_light(int layer, float up, float down, float sun, CloudHarmonics harmonics) {
    vec3 size = CLOUD_SLAB, range = CLOUD_SLAB_RANGE;
    float depth = (up + down) * (1.0 - cloud_peak(layer));
    float share = up / max(up + down, 1e-20), near = sqrt(share), far = sqrt(max(1.0 - share, 0.0));
    vec3 at = clamp(vec3(near / (near + far), sqrt(max(sun - range.z, 0.0) / (1.0 - range.z)),
        log(max(depth, 1e-20) / range.x) / range.y), 0.0, 1.0);
    // A slab thinner than the thinnest in the table scatters light again in proportion, one under a lower sun gets
    // less.
    float less = min(depth / range.x, 1.0) * min(sun / range.z, 1.0), sum = 0.0;
    vec3 texel = at * (size.zyx - 1.0) + 0.5;
    float layers = 3.0 * float(CLOUD_SLABS) * size.x, first = texel.z + 3.0 * size.x * float(layer);
    for (int k = 0; k < 3; ++k) {
        vec4 m = textureLod(u_cloud_slab, vec3(texel.xy / size.zy, (first + float(k) * size.x) / layers), 0.0);
        sum += dot(m, harmonics.moments[k]);
    }
    return less * max(sum, 0.0);
}

float cloud_slab(int layer, float up, float down, float mu, float mu_s, float nu) {
    return cloud_slab_light(layer, up, down, cloud_slab_sun(layer, mu_s), cloud_harmonics(mu, mu_s, nu));
}

// Light that goes k times into the forward peak and is scattered once besides is spread by all of these: lobes of
// asymmetry g^(1 + 0.6 k), in numbers that follow Poisson's law. The exponent, and the share of each lobe's level in
// its back that is left out (light that far astray is in the table already), are fitted to Monte-Carlo slabs.
struct CloudLobes {
    float relative[CLOUD_LOBES];   // phase function of each lobe over that of single scattering, over k!
    float peak;                    // cloud_peak()
};

CloudLobes cloud_lobes_at(int layer, float nu) {
    float g = cloud_model.layers[layer].asymmetry, once = cloud_phase(nu, g);
    float broader = pow(max(g, 1e-3), CLOUD_BROADEN), lobe = g, count = 1.0;
    CloudLobes found;
    found.peak = cloud_peak(layer);
    for (int k = 0; k < CLOUD_LOBES; ++k) {
        count *= float(k + 1);
        lobe *= broader;
        found.relative[k] = max(cloud_phase(nu, lobe) - CLOUD_BACK * cloud_phase(-1.0, lobe), 0.0) / (once * count);
    }
    return found;
}

// How much more light there is than what is scattered once; depth: optical depth of the clouds on the light's whole
// way.
float cloud_lobes_sum(CloudLobes lobes, float depth) {
    float mean = lobes.peak * min(depth, CLOUD_LOBES_DEEPEST), weight = 1.0, sum = 1.0;
    for (int k = 0; k < CLOUD_LOBES; ++k) {
        weight *= mean;
        sum += weight * lobes.relative[k];
    }
    return sum;
}

float cloud_lobes(int layer, float nu, float depth) {
    return cloud_lobes_sum(cloud_lobes_at(layer, nu), depth);
}
