"""A planet in a pygame game with moderngl: its surfaces as textures over the picture, its boxes in the landscape."""
