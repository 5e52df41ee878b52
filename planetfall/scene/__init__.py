"""Scenes: a planet or several with their components, presets, and the files they come from."""
