"""A moderngl-window game whose own Scene objects, read from a file, stand on the planet."""
