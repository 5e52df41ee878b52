"""Rivers and lakes as lines that carve the ground: where they lie, what they make of the ground, their water."""
