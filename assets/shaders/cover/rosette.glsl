// Fronds from the ground, as a fern's or an agave's: two rings of nine, leaves along both sides of their ribs.
// cover/tree.glsl has the space.
// Heights of both rings' fronds: where they begin, at the ground, and how they go on outwards.
const vec2 ROSETTE_FOOT = vec2(0.80, 0.80), ROSETTE_RISE = vec2(0.60, 0.40), ROSETTE_HANG = vec2(0.46, 0.33);
// The same of narrow plants, as reeds, whose fronds stand; and crowns between which these are the others.
const vec2 REED_RISE = vec2(0.34, 0.26), REED_HANG = vec2(0.14, 0.11), REED_RADIUS = vec2(0.06, 0.12);
const float ROSETTE_WIDE = 0.17;      // of a frond's half, over the crown's radius
const float ROSETTE_LEAVES = 15.0;    // along it, where a pixel can show them
const int ROSETTE_STEPS = 32;
const float ROSETTE_STEP = 0.039;     // over the crown's radius
const float ROSETTE_FINE = 0.048;     // steps over the crown's radius where it can
const float ROSETTE_DROOP = 0.35;     // how far they hang to the sides

// Whether a place is on a frond; its normal; further: how far along the ray none can be.
bool rosette_leaf(TreeRay r, vec3 place, out vec3 normal, out float further) {
    float aside = length(place.xy), share = min(aside / r.radius, 1.0);
    vec2 out_xy = place.xy / max(aside, 1e-4);
    float turn = 9.0 / (2.0 * PI) * atan(out_xy.y, out_xy.x), nearest = 1e9;
    float spread = smoothstep(REED_RADIUS.x, REED_RADIUS.y, r.radius);
    vec2 rise = mix(REED_RISE, ROSETTE_RISE, spread), hang = mix(REED_HANG, ROSETTE_HANG, spread);
    bool found = false, fine = r.size < ROSETTE_FINE * r.radius;
    for (int ring = 0; ring < 2; ++ring) {
        float across = (fract(turn + 0.5 * float(ring)) - 0.5) * (2.0 * PI / 9.0) * aside;
        float wide = ROSETTE_WIDE * r.radius * sqrt(share) * (1.0 - share * share) * r.leaves;
        float off = place.z - ROSETTE_FOOT[ring] - (rise[ring] - hang[ring] * share) * share
            + ROSETTE_DROOP * abs(across);
        // At right angles to the frond: those of narrow plants are steep.
        float slope = (rise[ring] - 2.0 * hang[ring] * share) / r.radius;
        off *= inversesqrt(1.0 + slope * slope);
        nearest = min(nearest, abs(off));
        float row = fract(ROSETTE_LEAVES * share - 2.0 * abs(across) / r.radius) - 0.5;
        float side = abs(across) / max(wide, 1e-5);
        bool leaf = !fine || abs(row) < 0.42 * (1.0 - 0.6 * side) || side < 0.10;
        if (!found && abs(off) < 0.6 * r.size && side < 1.0 && leaf) {
            vec3 beside = vec3(-out_xy.y, out_xy.x, 0.0) * sign(across);
            normal = normalize(vec3(-slope * out_xy, 1.0) + (0.45 + 0.8 * row * float(fine)) * beside);
            found = true;
        }
    }
    further = max(r.size, 0.7 * nearest);
    return found;
}

// In what holds all fronds: a cylinder around the axis. pixel: what one spans.
void tree_rosette(inout TreeHit found, TreeRay r, float pixel) {
    r.size = max(ROSETTE_STEP * r.radius, 1.3 * pixel);
    float a = dot(r.ray.xy, r.ray.xy), b = dot(r.from.xy, r.ray.xy);
    float root = b * b - a * (dot(r.from.xy, r.from.xy) - r.radius * r.radius);
    if (root <= 0.0 || a < 1e-9) return;
    float begin = max((-b - sqrt(root)) / a, 0.0), end = (sqrt(root) - b) / a;
    if (abs(r.ray.z) > 1e-4) {
        float low = (ROSETTE_FOOT.x - 0.05 - r.from.z) / r.ray.z, high = (1.02 - r.from.z) / r.ray.z;
        begin = max(begin, min(low, high));
        end = min(end, max(low, high));
    }
    float t = begin + 0.3 * r.size;
    for (int i = 0; i < ROSETTE_STEPS && t < end; ++i) {
        vec3 place = r.from + t * r.ray, normal;
        float further;
        if (rosette_leaf(r, place, normal, further)) {
            float share = length(place.xy) / r.radius;
            found = TreeHit(t, normal, tree_open(min(0.25 + 0.75 * share, 1.0), 0.4, 0.4), 0.0);
            return;
        }
        t += further;
    }
}
