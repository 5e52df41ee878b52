"""A planet in a moderngl-window game: its panel and its cubes before and after it, standing in its world."""
