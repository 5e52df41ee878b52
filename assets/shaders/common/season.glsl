// Where it is winter, the twin of components/season.py.
const vec2 SEASONAL = vec2(0.391, 0.643);   // sines of latitudes between which seasons begin to count

// 0..1: how far it is winter. winter: of the northern and the southern half; sine: of the latitude.
float winter_here(vec2 winter, float sine) {
    return clamp((abs(sine) - SEASONAL.x) / (SEASONAL.y - SEASONAL.x), 0.0, 1.0) * (sine < 0.0 ? winter.y : winter.x);
}
