// Light of a smooth sea: what its surface mirrors (sky, sun), what comes up from below (water, and ground where it is
// shallow), and ice near the poles.
#include "common/camera.glsl"
#include "common/nested_noise.glsl"
#include "common/octahedral.glsl"
#include "common/surface_tiles.glsl"
#include "generated/ocean.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/sun_visibility.glsl"

layout(binding = 4) uniform sampler2D u_rough;   // ocean/surface.comp

vec2 v_ndc;   // of the pixel at hand

const float PI = 3.14159265358979;
const float WATER_F0 = 0.0204;   // ((1.333 - 1) / (1.333 + 1))^2
const float STARLIGHT = 1.5e-8;  // of the sun's irradiance: 2e-3 lx of stars and airglow on a moonless night

// Smith's masking of a Beckmann surface, rational fit of Walter et al. 2007 (their equation 24 and the text below it).
float smith_beckmann(float cosine, float alpha) {
    float a = cosine * inversesqrt(max(1.0 - cosine * cosine, 1e-8)) / alpha;
    return a >= 1.6 ? 1.0 : (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a);
}

// Schlick 1994.
float water_fresnel(float cosine) {
    float t = 1.0 - cosine, t2 = t * t;
    return WATER_F0 + (1.0 - WATER_F0) * t2 * t2 * t;
}

// Share of ice (x) and its shade (y): closed towards the pole, floes at its edge, two octaves of noise that follow the
// footprint.
vec2 sea_ice(vec3 point, vec3 normal) {
    float unused;
    vec3 D = foot_offset_of(point, unused);
    float footprint = length(point) * frame.clock.w;
    float octave = log2(max(5.0 * footprint / NESTED_BASE_M, 1.0)) / 3.0;
    float low = min(floor(octave), 8.0), t = smoothstep(0.0, 1.0, clamp(octave - low, 0.0, 1.0));
    float past = (abs(normal.z) - ocean.water.y) * 60.0;
    int turns = abs(past) < 6.0 || past > 0.0 ? 2 : 1, k = 3 * int(low) + 1, i = 0;
    float noise = 0.0;
    do {
        ivec3 cell;
        vec3 fraction;
        float frequency;
        nested_place(ocean.anchor_cell.xyz, ocean.anchor_fraction.xyz, D, k, cell, fraction, frequency);
        noise += (i == 0 ? 1.0 - 0.6 * t : 0.4 + 0.6 * t) * gradient_noise_value(cell, fraction);
        k += 3;
    } while (++i < turns);
    noise *= 1.0 / NESTED_RMS;
    return vec2(smoothstep(-0.3, 0.3, past + 0.6 * noise), 1.0 + 0.07 * noise);
}

vec3 sea_radiance(ivec2 pixel) {
    vec3 point = position_from_depth(v_ndc, texelFetch(u_depth, pixel, 0).r);
    vec3 view = -normalize(point);
    vec3 normal = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    vec2 bytes = texelFetch(u_attributes, pixel, 0).rg * 255.0;
    float shallow = (bytes.x * 256.0 + bytes.y) / 65535.0;
    float depth_m = 16.0 * shallow / max(1.0 - shallow, 1e-4);

    vec3 sun = frame.sun_direction.xyz;
    bool below = dot(view, normal) < 0.0;
    vec3 facing = below ? -normal : normal;
    float n_v = clamp(dot(facing, view), 1e-3, 1.0), n_l = clamp(dot(normal, sun), 0.0, 1.0);   // unit only nearly
    vec3 sunlight = frame.sun_irradiance.rgb * sun_visibility(point) * air_to_space(point, sun);
    vec3 skylight = sky_irradiance(point, normal) + frame.sun_irradiance.rgb * STARLIGHT;

    // The sun's glitter: Beckmann's distribution of slopes, whose mean square is alpha^2 (Cox and Munk 1954: 0.003 +
    // 0.00512 times the wind's speed in m/s).
    vec4 rough = texelFetch(u_rough, pixel, 0);
    float alpha = sqrt(max(rough.x + rough.y, 1e-4));
    vec3 half_vector = normalize(view + sun);
    float n_h = max(dot(facing, half_vector), 1e-4), v_h = max(dot(view, half_vector), 0.0);
    float n_h2 = n_h * n_h;
    float distribution = exp((n_h2 - 1.0) / (n_h2 * alpha * alpha)) / (PI * alpha * alpha * n_h2 * n_h2);
    float glitter = below ? 0.0
        : distribution * water_fresnel(v_h) * smith_beckmann(n_v, alpha) * smith_beckmann(n_l, alpha) / (4.0 * n_v);

    // A rough sea seen at a flat angle shows faces that are turned towards the eye: the mean Fresnel term stays below one.
    float fresnel = WATER_F0 + (1.0 - WATER_F0) * pow(1.0 - n_v, 5.0 / (1.0 + 2.0 * alpha));
    // The sky is known as the camera sees it: what lies between the sea and a camera up high is missing, and its mean comes
    // from how much more skylight there is down here.
    vec3 between_them = max(skylight - sky_irradiance(vec3(0.0), frame.camera_zenith.xyz), 0.0) / PI;
    vec3 mirrored = below ? vec3(0.0) : (sky(reflect(-view, facing)) + between_them) * fresnel;

    // Light from below: single scattering of the water column over its bed, both ways through the column.
    vec3 loss = ocean.absorption.rgb + ocean.scattering.rgb;
    float paths = inversesqrt(1.0 - (1.0 - n_l * n_l) / 1.777) + inversesqrt(1.0 - (1.0 - n_v * n_v) / 1.777);
    vec3 through = exp(-loss * depth_m * paths);
    vec3 reflectance = ocean.scattering.rgb / (2.0 * loss) * (1.0 - through) + ocean.bed.rgb * through;
    vec3 upwelling = reflectance * (sunlight * (n_l * (1.0 - water_fresnel(n_l))) + skylight) / PI * (1.0 - fresnel) * 0.54;

    vec2 ice = sea_ice(point, normal);
    vec3 frozen = ocean.ice.rgb * ice.y * (sunlight * n_l + skylight) / PI;
    vec3 radiance = mix(upwelling + mirrored + glitter * sunlight, frozen, below ? 0.0 : ice.x);
    Air between = air_from_camera(point);
    return (radiance * between.transmittance + between.in_scatter);
}

void main() {
    ivec2 pixel = tile_pixel();
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0))) || texelFetch(u_surface, pixel, 0).r != SURFACE_SEA) return;
    v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    imageStore(u_radiance, pixel, vec4(sea_radiance(pixel) * frame.scale.x, 1.0));
}
