"""Companions: other planets in the picture of a planet's camera, as small pictures of their own behind its air."""

from .system import PICTURE, CompanionSource, CompanionsSystem, Picture

__all__ = ["PICTURE", "CompanionSource", "CompanionsSystem", "Picture"]
