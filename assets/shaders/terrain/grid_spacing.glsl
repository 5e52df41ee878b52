// The distance of vertices that the screen asks for at foot offset D (metres from the anchor, on the reference sphere): a
// continuous function of the place, so that band limits agree where cells of different levels meet.
float grid_spacing(vec3 D) {
    float scale = 1.0 + frame.anchor_up.w / planet.radii.x;
    return max(terrain_grid.spacing.y, terrain_grid.spacing.x * sqrt(dot(D, D) * scale * scale + terrain_grid.spacing.z * terrain_grid.spacing.z));
}
