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

const int SPRAY_ROW = 17;   // numbers of a fall
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
