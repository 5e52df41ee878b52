// A ribbed column with arms, as a saguaro: rods with round ends. Where a ray meets it; cover/tree.glsl has the space.
const float COLUMN_TRUNK = 0.30;        // its stem's radius over that of all of it
const float COLUMN_ARM = 0.68;          // an arm's over its stem's
const int COLUMN_ARMS = 4;
const float COLUMN_RIBS = 17.0, COLUMN_RIB = 0.55;   // around the stem; how far they turn its normal

// A rod from `foot` to `tip`, of a radius. ribs: around it, 0 for none.
void column_rod(inout TreeHit found, TreeRay r, vec3 foot, vec3 tip, float radius, float ribs) {
    vec3 along = tip - foot, from = r.from - foot;
    float long_2 = dot(along, along), ray_along = dot(r.ray, along), from_along = dot(from, along);
    float a = long_2 - ray_along * ray_along, b = long_2 * dot(from, r.ray) - from_along * ray_along;
    float c = long_2 * (dot(from, from) - radius * radius) - from_along * from_along, root = b * b - a * c;
    if (root < 0.0) return;
    float t = (-b - sqrt(root)) / a, share = (from_along + t * ray_along) / long_2;
    vec3 end = foot;
    if (share < 0.0 || share > 1.0) {   // its round ends
        end = share < 0.0 ? foot : tip;
        vec3 o = r.from - end;
        float half_b = dot(o, r.ray), sphere = half_b * half_b - dot(o, o) + radius * radius;
        if (sphere < 0.0) return;
        t = -half_b - sqrt(sphere);
        share = clamp(share, 0.0, 1.0);
    }
    if (t <= 0.0 || (found.t > 0.0 && t > found.t)) return;
    vec3 place = r.from + t * r.ray, normal = normalize(place - foot - share * along);
    if (place.z < 0.0) return;   // in the ground, which all of it would be drawn in front of from above
    // Ribs along it: their flanks turn the normal, and less of the sky shows between them.
    float angle = atan(normal.y, normal.x), rib = ribs > 0.0 ? cos(ribs * angle) : 0.0;
    vec3 around = vec3(-normal.y, normal.x, 0.0);
    normal = normalize(normal + (COLUMN_RIB * r.fine * (ribs > 0.0 ? sin(ribs * angle) : 0.0)) * around);
    // Older skin below is darker, and cross bands show where growth has rested.
    float band = tree_wave(23.0 * place.z + 0.6 * tree_wave(7.0 * place.z + r.turn));
    found = TreeHit(t, normal, clamp(0.50 + 0.22 * place.z + (0.20 * rib + 0.06 * band) * r.fine + 0.08 * normal.z,
        0.1, 1.0), 0.0);
}

void tree_column(inout TreeHit found, TreeRay r) {
    float stem = COLUMN_TRUNK * r.radius, arm = COLUMN_ARM * stem;
    column_rod(found, r, vec3(0.0, 0.0, -0.1), vec3(0.0, 0.0, 1.0 - stem), stem, COLUMN_RIBS);
    for (int k = 0; k < COLUMN_ARMS; ++k) {
        vec3 chance = tree_chance(ivec3(k, 3, 7), floatBitsToUint(r.turn + 1.0));
        if (chance.x > 0.62) continue;
        // Out from the stem and up again, none above its top.
        vec3 out_m = vec3(TREE_ANGLES[k + 1] * (r.radius - arm), 0.0);
        float elbow = min(0.28 + 0.30 * chance.y, 0.92 - arm - 0.6 * r.radius);
        float top = min(elbow + 0.14 + 0.30 * chance.z, 0.94 - arm);
        vec3 shoulder = vec3(0.0, 0.0, elbow - 0.03), bend = 0.8 * out_m + vec3(0.0, 0.0, elbow);
        vec3 rise = out_m + vec3(0.0, 0.0, elbow + 0.6 * r.radius);
        column_rod(found, r, shoulder, bend, 0.85 * arm, 0.0);
        column_rod(found, r, bend, rise, arm, floor(0.7 * COLUMN_RIBS));
        column_rod(found, r, rise, out_m + vec3(0.0, 0.0, max(top, rise.z)), arm, floor(0.7 * COLUMN_RIBS));
    }
}
