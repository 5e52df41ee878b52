"""A planet in an arcade 3 game: its sprites and text over the picture, boxes of its own arcade.gl in the landscape."""
