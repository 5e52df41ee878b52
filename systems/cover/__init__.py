"""Cover: trees on the ground, near the camera."""

from .system import CoverSystem

__all__ = ["CoverSystem"]
