// Contract "air_point", default: no air.
//
//   AirPoint air_point(float h, float mu, float mu_s, float nu, float scattered_before)
//
// The air at one height, for whoever marches through it: h above the reference sphere, cosines of the ray and of the
// sun to the zenith there, and between the two. scattered_before: 1, or 0 to leave out light that was scattered more
// than once (diffuse). Per wavelength, for a unit sun.

struct AirPoint {
    vec3 extinction;   // per metre
    vec3 sun_depth;    // optical depth of the air towards the sun; below the horizon, towards the horizon
    vec3 direct;       // emission per metre in sunlight that is not dimmed
    vec3 diffuse;      // emission per metre from light that has been scattered before, planet's shadow and all
    vec3 ambient;      // mean radiance of that light, from all around
};

AirPoint air_point(float h, float mu, float mu_s, float nu, float scattered_before) {
    return AirPoint(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
}
