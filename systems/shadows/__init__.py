"""Shadows of the ground and its shelter from the sky: a clipmap of heights, see docs/shadows.md."""
