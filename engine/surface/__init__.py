"""Pure geometry of a sphere's surface: lattice, anchors, cell selection, coverage, culling, noise. No GL, no ECS."""
