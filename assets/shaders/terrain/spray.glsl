// A fall's spray, as the vertex shader hands it on: systems/terrain/spray.py has its numbers.
struct Spray {
    vec3 foot;         // of the fall, from the camera, m
    vec3 up, way;      // unit: from the planet's centre, and level, the way the water goes
    float height, half_width;   // of the fall, m
    float density;     // 1/m, of its densest cloud; 0: none
    float seed;        // of its puffs
};

// What terrain/spray_light.comp has for each.
struct SprayLight {
    vec4 beam;      // the sun's light on a surface across it
    vec4 diffuse;   // radiance of light that comes evenly from all sides, by what a droplet scatters
    vec4 dense;     // radiance of spray that is as white as foam
    vec4 loss;      // of the air before it, 1/m
    vec4 air;       // and that air's source
};

const int SPRAY_CLOUDS = 2;
const float SPRAY_DEVIATIONS = 3.0;   // from a cloud's middle at which it ends

// Of one of its two clouds, each Gaussian along three axes: middle (xyz, from the foot: along the way, across, up) and
// density, and its deviations. What rises from the pool, and the veil before the falling water.
void spray_cloud(Spray s, int k, out vec4 middle, out vec3 deviation) {
    bool pool = k == 0;
    middle = (pool ? vec4(0.40, 0.0, 0.12, 1.0) : vec4(0.08, 0.0, 0.40, 0.22)) * vec4(vec3(s.height), s.density);
    deviation = pool ? vec3(0.50 * s.height, 0.6 * s.half_width + 0.25 * s.height, 0.34 * s.height)
        : vec3(0.20 * s.height, 0.6 * s.half_width, 0.40 * s.height);
}

// Odd rational approximation of erf, to 5e-4 (Abramowitz and Stegun 1964, 7.1.27).
float erf_of(float x) {
    float a = min(abs(x), 8.0), d = 1.0 + a * (0.278393 + a * (0.230389 + a * (0.000972 + a * 0.078108)));
    d *= d;
    return sign(x) * (1.0 - 1.0 / (d * d));
}

// Optical depth of both clouds along a ray up to `end`, m, without puffs, and how far away their mean is. eye, going:
// from the foot, along the way, across and up; going 1 long.
float spray_depth(Spray s, vec3 eye, vec3 going, float end, out float mean_m) {
    float optical = 0.0;
    mean_m = 0.0;
    for (int k = 0; k < SPRAY_CLOUDS; ++k) {
        vec4 middle;
        vec3 deviation;
        spray_cloud(s, k, middle, deviation);
        vec3 from = (eye - middle.xyz) / deviation, along = going / deviation;
        float a = dot(along, along), b = dot(from, along) / a;
        vec3 beside = from - b * along;   // its square as a difference of two would be rounded away from afar
        float c = dot(beside, beside);
        float root = sqrt(0.5 * a), ends = exp(-0.5 * SPRAY_DEVIATIONS * SPRAY_DEVIATIONS);
        float found = middle.w * max(exp(-0.5 * c) - ends, 0.0) * (0.8862269 / root)
            * (erf_of((end + b) * root) - erf_of(b * root));
        optical += found;
        mean_m += found * clamp(-b, 0.0, end);
    }
    mean_m /= max(optical, 1e-20);
    return optical;
}
