// Gusts that run over plants: waves whose crests strengthen the wind (systems/cover/sway.py). The block cover_map has
// to be there.

// Times the wind's bend. point: camera-relative metres, planet axes.
float gust_at(vec3 point) {
    float sum = 0.0;
    for (int k = 0; k < 3; ++k)
        sum += sin(6.2831853 * fract(dot(cover_map.gusts[k].xyz, point) + cover_map.gusts[k].w));
    return 1.0 + cover_map.gusting * sum;
}
