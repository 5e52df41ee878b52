"""Sky: the sun's disc in black space, stars and the Milky Way. Air comes through the shader contracts air and sky."""

from .catalogue import StarField, make_stars
from .system import SkySystem, StarsSystem

__all__ = ["SkySystem", "StarField", "StarsSystem", "make_stars"]
