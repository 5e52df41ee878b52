"""A planet in a game of one's own on moderngl: the game draws before and after it, in its own framebuffer."""
