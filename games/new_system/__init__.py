"""A feature of a game's own in a planet: a ring, with knobs, panel, pass, scene file and debug view, by declaration."""
