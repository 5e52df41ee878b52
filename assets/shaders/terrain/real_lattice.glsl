// Where places lie on lattices of tiles, in columns and rows (engine/real_ground/lattice.py).
#include "generated/terrain_table.glsl"
#include "generated/terrain_real_numbers.glsl"

// To a unit in the last place: angles become rows and columns.
float real_atan(float t) {
    t /= 1.0 + sqrt(1.0 + t * t);
    t /= 1.0 + sqrt(1.0 + t * t);
    float s = t * t;
    return 4.0 * t * (1.0 + s * (-0.33333333 + s * (0.2 + s * (-0.14285714 + s * (0.11111111 - s * 0.09090909)))));
}

float real_angle(float y, float x) {
    bool steep = abs(y) > abs(x);
    float angle = steep ? real_atan(x / y) : real_atan(y / x);
    if (steep) return (y > 0.0 ? 0.5 * REAL_PI : -0.5 * REAL_PI) - angle;
    return x >= 0.0 ? angle : angle + (y >= 0.0 ? REAL_PI : -REAL_PI);
}

float real_atanh(float t) {
    if (abs(t) > 0.2) return 0.5 * log((1.0 + t) / (1.0 - t));
    float s = t * t;
    return t * (1.0 + s * (0.33333333 + s * (0.2 + s * (0.14285714 + s * (0.11111111 + s * 0.09090909)))));
}

// Column and row of the sample about direction p, the column counted from the date line or the first one.
ivec2 real_about(TerrainRealLevel level, vec3 p) {
    float flat_m = length(p.xy), latitude = real_angle(p.z, flat_m);
    float rise = p.z / flat_m, y = log(rise + sqrt(1.0 + rise * rise));
    float v = 0.5 - (level.mercator != 0 ? 0.5 * y : latitude) / REAL_PI;
    float x = (real_angle(p.y, p.x) / (2.0 * REAL_PI) + 0.5) * level.across - level.phase.x - level.first_column;
    x = level.first_column + x - level.across * floor(x / level.across);
    return ivec2(floor(x), floor(v * level.down - level.phase.y));
}

// Columns and rows from a sample c to the place at d from it.
vec2 real_samples(TerrainRealLevel level, vec3 c, vec3 d) {
    vec3 p = c + d;
    float turned = (c.x * d.y - c.y * d.x) / (c.x * p.x + c.y * p.y);
    float flat_c = length(c.xy), flat_p = length(p.xy);
    float out_m = (2.0 * dot(c.xy, d.xy) + dot(d.xy, d.xy)) / (flat_c + flat_p);
    float rise;
    if (level.mercator != 0) {
        float r = terrain_table.radius_m;
        rise = real_atanh(d.z * r / (flat_c * flat_c - c.z * d.z));
    } else {
        rise = real_atan((d.z * flat_c - c.z * out_m) / (c.z * p.z + flat_c * flat_p));
    }
    return vec2(real_atan(turned), -rise) * level.per_rad;
}
