// Flowers in grass: petals around an eye, at the tip of a tuft's middle blade, which is the stem. They grow in drifts,
// most of a drift of one sort. A ray keeps the first head that it comes near to; its petals are worked out once, after
// all cells, so that a cell without a flower costs little.

struct FlowerSort {
    vec3 petals, eye;   // albedo
    float radius_m;
};
const int FLOWER_SORTS = 6;
const FlowerSort FLOWERS[FLOWER_SORTS] = FlowerSort[](
    FlowerSort(vec3(0.46, 0.45, 0.41), vec3(0.42, 0.27, 0.03), 0.021),
    FlowerSort(vec3(0.47, 0.35, 0.04), vec3(0.36, 0.22, 0.02), 0.014),
    FlowerSort(vec3(0.30, 0.19, 0.31), vec3(0.36, 0.30, 0.27), 0.015),
    FlowerSort(vec3(0.45, 0.43, 0.37), vec3(0.40, 0.31, 0.06), 0.012),
    FlowerSort(vec3(0.17, 0.18, 0.40), vec3(0.11, 0.09, 0.17), 0.017),
    FlowerSort(vec3(0.40, 0.075, 0.04), vec3(0.04, 0.03, 0.03), 0.023));

// What a cell may bear.
struct Bloom {
    bool there;
    float sort;     // 0..1
    vec2 chance;    // 0..1
};

// Nearest to the eye of those near the ray.
struct Flower {
    float left;     // 0..1: of the pixel, for it and what lies behind; 0: none
    vec2 away_m;    // of its middle from the ray
    float sort;
    vec2 chance;
};

Bloom flower_bloom(vec2 group, vec3 one, vec3 two, float share) {
    float drift = clutter_wave(71.0 * group.x + 0.5 * clutter_wave(83.0 * group.y))
        + clutter_wave(59.0 * group.y + 0.5 * clutter_wave(97.0 * group.x));
    float sort = fract(0.5 * clutter_wave(31.0 * group.x + 37.0 * group.y) + 0.4 * one.y);
    float chance = fract(two.z * 5.0 + one.x);
    return Bloom(chance < share * max(5.0 * drift - 1.0, 0.3), sort, vec2(one.z, two.y));
}

// away: of the tip from the ray, in cells; left: of the pixel, 0 where there is one already.
void find_flower(inout Flower flower, Bloom bloom, vec2 away, float left, float size_m, float across_m) {
    vec2 away_m = size_m * away;
    float reach_m = 0.03 + 0.5 * across_m;
    if (bloom.there && left > 0.0 && dot(away_m, away_m) < reach_m * reach_m)
        flower = Flower(left, away_m, bloom.sort, bloom.chance);
}

void add_flower(inout GroundClutter found, inout float left, Flower flower, ClutterView v, mat2 plane, vec2 rise) {
    FlowerSort of = FLOWERS[clamp(int(float(FLOWER_SORTS) * flower.sort), 0, FLOWER_SORTS - 1)];
    float radius_m = of.radius_m * (0.7 + 0.6 * flower.chance.x), blur = v.across / radius_m;
    // It faces up, a little to a side.
    vec2 aside = 0.9 * (fract(vec2(5.0, 11.0) * flower.chance.yx) - 0.5);
    vec3 level = vec3(aside, -dot(aside, v.up.xy) / v.up.z);
    vec3 faces = normalize(vec3(rise + plane * aside, v.eye_rise + dot(v.to_eye, level)));
    float open = max(abs(faces.z), 0.2), shown = max(open, min(0.5 * blur, 1.0));
    vec2 axis = faces.xy * inversesqrt(max(dot(faces.xy, faces.xy), 1e-6)), away = -flower.away_m / radius_m;
    vec2 place = vec2(away.x * axis.y - away.y * axis.x, dot(away, axis) / shown);
    float far = length(place), turn = 6.2831853 * flower.chance.y;
    // Five petals: the cosine of five times the angle.
    float c = dot(place, vec2(cos(turn), sin(turn))) / max(far, 1e-4), cc = c * c;
    float petal = c * (5.0 + cc * (16.0 * cc - 20.0)), seen = max(1.0, 0.5 * blur);
    float cover = clamp((seen * (0.76 + 0.24 * petal) - far) / blur + 0.5, 0.0, 1.0) * open / (shown * seen * seen);
    float eye = clamp((0.34 * seen - far) / max(blur, 0.1) + 0.5, 0.0, 1.0);
    vec3 color = mix(of.petals * (0.7 + 0.2 * far + 0.1 * petal), of.eye, eye);
    float weight = flower.left * cover * clamp(12.0 * v.eye_rise - 0.9, 0.0, 1.0), rest = 1.0 - weight;
    left *= rest;
    found.tint *= rest;
    found.dry *= rest;
    found.plant = found.plant * rest + weight;
    found.light = found.light * rest + weight;
    found.normal = found.normal * rest + weight * v.up;
    found.bloom += weight * color;
    found.bloomed += weight;
}
