// The distance of vertices that the screen asks for at foot offset D (metres from the anchor, on the reference sphere):
// a continuous function of the place, so that band limits agree where cells of different levels meet.
float grid_spacing(vec3 D, GridSpacing grid) {
    float scale = 1.0 + frame.anchor_height_m / planet.radius_m;
    float distance_m = sqrt(dot(D, D) * scale * scale + grid.proxy_height_m * grid.proxy_height_m);
    return max(grid.smallest_m, grid.per_distance * distance_m);
}
