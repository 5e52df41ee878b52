// The distance of vertices that the screen asks for at foot offset D (metres from the anchor, on the reference sphere):
// a continuous function of the place, so that band limits agree where cells of different levels meet.
float grid_spacing(vec3 D, vec4 spacing) {
    float scale = 1.0 + frame.anchor_up.w / planet.radii.x;
    return max(spacing.y, spacing.x * sqrt(dot(D, D) * scale * scale + spacing.z * spacing.z));
}

float grid_spacing(vec3 D) {
    return grid_spacing(D, terrain_grid.spacing);
}
