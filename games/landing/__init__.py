"""An environment to learn in: land softly on the moon, from a picture, distances and a few numbers."""
