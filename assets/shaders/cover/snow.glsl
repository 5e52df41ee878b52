// Where snow lies on a tree: on what faces up and has open sky above it. Chosen by eye.
const vec2 SNOW_STEEP = vec2(0.80, 0.58);  // how far up it has to face, where there is little and much
const float SNOW_EDGE = 5.0;               // 1 over the range of that in which it ends
const float SNOW_OPEN = 0.6;               // what open sky counts
const float SNOW_TWIGS = 0.5;              // share of it that falls through twigs without leaves
const float SNOW_SMOOTH = 0.7;             // how far it hides the shape of tufts

// 0..1: how white the tree is there. snow: share of what faces up that is; bare: of leaves that have fallen.
float snow_on(TreeHit hit, float snow, float bare) {
    snow *= (1.0 - SNOW_TWIGS * bare) * (1.0 - hit.bark);
    float up = hit.normal.z + SNOW_OPEN * (hit.open - 0.6);
    return snow > 0.0 ? clamp(0.5 + SNOW_EDGE * (up - mix(SNOW_STEEP.x, SNOW_STEEP.y, snow)), 0.0, 1.0) : 0.0;
}
