// Paths of light from a camera through clouds, any number of orders: the truth that pictures are measured against.
//
// Delta tracking (Woodcock et al. 1965) for free flights, ratio tracking (Novak et al. 2014) for the way to the sun,
// next-event estimation at each place of scattering, Henyey and Greenstein's phase function sampled by its inverse in
// closed form, a Lambert ground. Albedo of droplets and ground is the chance that a path goes on. There is no air; the
// sky is black but for the sun's disc.
//
// The way to the first place of scattering is long and mostly clear: PATH_BRANCHES paths go on from each, and share its
// weight.
//
// A lane follows one path at a time, one look at the density a turn, be it of the path or of its way to the sun, so
// that no lane waits for another. It keeps its state from dispatch to dispatch and takes job after job: a number of
// paths of one ray. Chance is a hash of ray, path and draw: results are the same to the bit, whichever lane has the
// job.
#define CLOUD_NO_CIRRUS
#include "generated/bindings.glsl"
#include "generated/paths.glsl"
#include "clouds/probe/path_medium.glsl"
#include "clouds/phase.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = PATH_RAY_BUFFER) readonly buffer Rays { PathRay rays[]; };
layout(std430, binding = 1) readonly buffer Jobs { uvec2 jobs[]; };       // ray, number of its first path
layout(std430, binding = 2) buffer Results { vec4 results[]; };           // of jobs: light, its square, cloud met
layout(std430, binding = 3) buffer Lanes { PathLane lanes[]; };
layout(std430, binding = 4) buffer Next { uint next_job; };

layout(location = 3) uniform int u_turns;
layout(location = 4) uniform int u_jobs;
layout(location = 5) uniform int u_paths;        // of a job
layout(location = 6) uniform vec3 u_up;          // at the anchor, from which places count
layout(location = 7) uniform vec3 u_sun;
layout(location = 8) uniform float u_sun_radius_rad;
layout(location = 9) uniform float u_ground;     // albedo
layout(location = 10) uniform vec3 u_right;      // across a pixel, for rays 1 long along the camera's forward axis
layout(location = 11) uniform vec3 u_above;
layout(location = 12) uniform float u_little;    // light that is not worth a whole way to the sun
layout(location = 13) uniform uint u_seed;
layout(location = 14) uniform int u_orders;      // of scattering by droplets, at most

const int FLIGHT = 0, TO_SUN = 1, IDLE = 2;
const int CLOUD = 0, GROUND = 1;
const float BRANCH = 1.0 / float(PATH_BRANCHES);
const uint PATH_NONE = 0xffffffffu;

// Jarzynski and Olano 2020, pcg3d; 0..1, never 1.
vec3 path_chance(uint ray, uint path, uint draw) {
    uvec3 v = uvec3(ray ^ u_seed, path, draw) * 1664525u + 1013904223u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    return vec3(v >> 8u) * (1.0 / 16777216.0);
}

// Turned by an angle of that cosine, about the way by a share of the full circle.
vec3 path_turned(vec3 way, float cosine, float share) {
    float side = sign_nonzero(way.z), a = -1.0 / (side + way.z), b = way.x * way.y * a;   // Duff et al. 2017
    vec3 across = vec3(1.0 + side * way.x * way.x * a, side * b, -side * way.x),
        along = vec3(b, side + way.y * way.y * a, -way.y);
    float sine = sin_from_cos(cosine), angle = 2.0 * PI * share;
    return normalize(cosine * way + sine * (cos(angle) * across + sin(angle) * along));
}

float path_scattering_cosine(float g, float chance) {
    float ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * chance);
    return clamp(abs(g) < 1e-3 ? 2.0 * chance - 1.0 : (1.0 + g * g - ratio * ratio) / (2.0 * g), -1.0, 1.0);
}

// The lane's next job, if there is one.
void next_job_of(inout PathLane l) {
    l.job = atomicAdd(next_job, 1u);
    bool some = l.job < uint(u_jobs);
    l.mode = some ? FLIGHT : IDLE;
    l.job = some ? l.job : PATH_NONE;
    l.done = 0;
    l.sum = l.square = l.met_cloud = 0.0;
}

void begin_path(inout PathLane l) {
    PathRay r = rays[jobs[l.job].x];
    l.draw = 0u;
    vec3 chance = path_chance(jobs[l.job].x, jobs[l.job].y + uint(l.done), l.draw++);
    vec3 middle = normalize(r.way), way = normalize(r.way + (chance.x - 0.5) * u_right + (chance.y - 0.5) * u_above);
    l.way = way;
    l.at = r.start + r.skipped_m * (way - middle) + r.clear_m * way;
    l.bound = 0.0;
    l.light = 0.0;
    l.orders = l.branch = 0;
}

// From the first place of scattering once more: as if its way to the sun had come to nothing.
void begin_branch(inout PathLane l) {
    ++l.branch;
    l.at = l.place = l.first;
    l.came = l.first_came;
    l.share = l.first_share;
    l.asymmetry = l.first_asymmetry;
    l.place_bound = l.first_bound;
    l.place_reach = l.first_reach;
    l.kind = CLOUD;
    l.orders = 1;
    l.bound = l.carried = 0.0;
    l.mode = TO_SUN;
}

void end_path(inout PathLane l) {
    l.sum += l.light;
    l.square += l.light * l.light;
    l.met_cloud += l.orders > 0 ? 1.0 : 0.0;
    if (++l.done == u_paths) {
        results[l.job] = vec4(l.sum, l.square, l.met_cloud, 1.0);
        next_job_of(l);
    }
    if (l.mode != IDLE) begin_path(l);
}

void main() {
    frame.camera_offset_m = vec3(0.0);
    frame.camera_zenith = frame.anchor_up = u_up;
    frame.camera_altitude_m = frame.anchor_height_m = 0.0;
    PathLane l = lanes[gl_GlobalInvocationID.x];
    if (l.mode == IDLE) {
        next_job_of(l);
        if (l.mode != IDLE) begin_path(l);
    }
    int turn = 0;
    bool on = l.mode != IDLE;
    if (on) do {
        uint ray = jobs[l.job].x, path = jobs[l.job].y + uint(l.done);
        vec3 chance = path_chance(ray, path, l.draw), more = path_chance(ray, path, l.draw + 1u);
        l.draw += 2u;
        float altitude = altitude_of(l.at);
        vec3 up = up_at(l.at);
        PathMedium here = path_medium(l.at, altitude, up);
        float met = l.bound > 0.0 ? here.extinction / l.bound : 0.0;
        l.worst = max(l.worst, met);
        bool flight = l.mode == FLIGHT, to_sun = !flight;
        bool rises = dot(up, l.way) > 0.0, ground = altitude <= 0.0 && !rises,
            space = altitude > cloud_view.highest_m && rises;
        // The way to the sun: as much is left as is not met; of little, chance takes some and doubles the rest.
        l.carried *= to_sun ? 1.0 - met : 1.0;
        bool risked = to_sun && !space && l.carried < u_little;
        bool lost = to_sun && (ground || l.carried <= 0.0 || (risked && more.x < 0.5));
        l.carried *= risked ? 2.0 : 1.0;
        bool lit = to_sun && space;
        l.light += lit ? (l.orders == 1 && l.kind == CLOUD ? 1.0 : BRANCH) * l.carried : 0.0;
        // A place of scattering: first its way to the sun.
        bool scattered = flight && !ground && chance.x < met, landed = flight && ground;
        bool over = flight && (space || (landed && l.orders == 0));
        if (scattered || (landed && !over)) {
            // A place that was reached below the ground is put on it.
            l.at += landed ? up * (PATH_BEYOND_M - altitude) : vec3(0.0);
            l.kind = landed ? GROUND : CLOUD;
            l.orders += landed ? 0 : 1;
            l.place = l.at;
            l.came = landed ? up : l.way;
            l.share = landed ? u_ground : here.scattered;
            l.asymmetry = here.asymmetry;
            l.place_bound = landed ? 0.0 : here.bound;
            l.place_reach = landed ? 1.0 : here.reach;
            if (l.orders == 1 && scattered) {
                l.first = l.place;
                l.first_came = l.came;
                l.first_share = l.share;
                l.first_asymmetry = l.asymmetry;
                l.first_bound = l.place_bound;
                l.first_reach = l.place_reach;
            }
            // A place on the sun's disc.
            l.way = path_turned(u_sun, sqrt(1.0 - u_sun_radius_rad * u_sun_radius_rad * more.y), more.z);
            float phase = landed ? max(dot(up, l.way), 0.0) / PI : cloud_phase(dot(l.came, l.way), l.asymmetry);
            l.carried = l.share * phase;
            l.mode = TO_SUN;
        }
        bool back = lit || lost;
        if (back) {
            // On from the place of scattering, or swallowed there.
            bool landed_before = l.kind == GROUND;
            float cosine = landed_before ? sqrt(chance.y) : path_scattering_cosine(l.asymmetry, chance.y);
            l.way = path_turned(l.came, cosine, chance.z);
            l.at = l.place;
            l.mode = FLIGHT;
            over = more.y >= l.share || l.orders >= u_orders;
            here.bound = l.place_bound;
            here.reach = l.place_reach;
        }
        if (over && l.orders > 0 && l.branch + 1 < PATH_BRANCHES) begin_branch(l);
        else if (over) end_path(l);
        else {
            // Half of the chance has decided above.
            float mu = clamp_cos(dot(up_at(l.at), l.way)),
                to = min(here.reach, path_to_boundary(altitude_of(l.at), mu) + PATH_BEYOND_M),
                free_m = here.bound > 0.0 ? -log(1.0 - fract(2.0 * more.x)) / here.bound : PATH_ENDLESS;
            l.at += l.way * min(free_m, to);
            l.bound = free_m < to ? here.bound : 0.0;
        }
        on = l.mode != IDLE && ++turn < u_turns;
    } while (on);
    lanes[gl_GlobalInvocationID.x] = l;
}
