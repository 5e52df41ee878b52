"""A planet in a pyglet game: the game's sprites, labels and models before and after it, standing in its world."""
