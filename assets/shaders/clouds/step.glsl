// One step of a march: light that leaves it towards the camera, exact where extinction is even and sunlight falls
// exponentially along the step, which it does in even cloud. So a step may be many optical depths long.
//
// It takes two samples, at the points of Gauss's rule: what is missed along a curved exponent cancels to leading order.
#include "clouds/droplets.glsl"

const float GAUSS_A = 0.211324865, GAUSS_B = 0.788675135;   // of the step

// The medium, air and droplets, at one of the two points. Per wavelength, for a unit sun.
struct MediumSample {
    vec3 extinction;   // per metre, of all that is there
    vec3 sun_depth;    // optical depth to the sun
    vec3 direct;       // emission per metre for sunlight that is not dimmed by sun_depth
    vec3 diffuse;      // emission per metre from light that has been scattered before
    float cloud;       // extinction per metre of droplets alone
    float forward;     // the part of it that goes straight on, which diffuse light doesn't lose (delta-M)
};

struct CloudLight {
    vec3 radiance;   // towards the camera, for a unit sun
    vec3 depth;      // optical depth so far
    float cloud;     // that of droplets alone
    float forward;   // the part of that which goes straight on
};

// Mean of exp(-x) where x runs evenly from one value to another.
vec3 cloud_mean_exp(vec3 from, vec3 to) {
    return exp(-min(from, to)) * one_minus_exp_over(abs(to - from));
}

// Emission times transmittance, meant over the step. Exponents at the two points.
vec3 cloud_step_mean(vec3 exponent_a, vec3 exponent_b, vec3 emission_a, vec3 emission_b, vec3 least) {
    vec3 overhang = (exponent_b - exponent_a) * (GAUSS_A / (GAUSS_B - GAUSS_A));
    // Past a kink (the sun's ray leaves a shell) the straight line would go below what is possible, and its exponential
    // grow.
    vec3 mean = cloud_mean_exp(max(exponent_a - overhang, least), max(exponent_b + overhang, least));
    vec3 share = 1.0 / (1.0 + exp(clamp(exponent_b - exponent_a, -80.0, 80.0)));
    return mean * mix(emission_a, emission_b, share);
}

void cloud_step(inout CloudLight light, float length_m, MediumSample a, MediumSample b) {
    // Depth to each point under the straight line through both extinctions.
    vec3 slope = (b.extinction - a.extinction) / (GAUSS_B - GAUSS_A);
    float xa = GAUSS_A, xb = GAUSS_B;
    vec3 depth_a = light.depth + length_m * max(a.extinction * xa - slope * (0.5 * xa * xa), 0.0);
    vec3 depth_b = light.depth + length_m * max(a.extinction * xb + slope * (0.5 * xb * xb - xa * xb), 0.0);
    vec3 diffuse = light.depth - light.forward;
    vec3 diffuse_a = depth_a - light.forward - length_m * xa * a.forward,
        diffuse_b = depth_b - light.forward - length_m * xb * b.forward;
    // Light that was turned straight on adds to sunlight: then exponents may be less than the depth before the step.
    vec3 sun_a = depth_a + a.sun_depth, sun_b = depth_b + b.sun_depth, least = min(light.depth, min(sun_a, sun_b));
    light.radiance += length_m
        * (cloud_step_mean(sun_a, sun_b, a.direct, b.direct, least)
            + cloud_step_mean(diffuse_a, diffuse_b, a.diffuse, b.diffuse, diffuse));
    light.depth += 0.5 * length_m * (a.extinction + b.extinction);
    light.cloud += 0.5 * length_m * (a.cloud + b.cloud);
    light.forward += 0.5 * length_m * (a.forward + b.forward);
}
