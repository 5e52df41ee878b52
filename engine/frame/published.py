"""What systems publish for one another in the world, by key: the key knows what is behind it."""

from __future__ import annotations

from collections.abc import Callable

from ..surface.field import HeightField
from ..world import Key
from .frame import View

__all__ = ["AIR_GENERATION", "AIR_TOP_M", "HEIGHT_FIELD", "SEA_TOP_M", "SURFACE_HEIGHT"]

HEIGHT_FIELD: Key[HeightField] = Key("height_field")
"""Heights of the ground that is drawn, on the CPU."""
SURFACE_HEIGHT: Key[Callable[[View], None]] = Key("surface_height")
"""Binds what the GPU's height function reads, for a view."""
SEA_TOP_M: Key[float] = Key("sea_top_m")
"""How high the sea's waves reach."""
AIR_TOP_M: Key[float] = Key("air_top_m")
"""How high air reaches."""
AIR_GENERATION: Key[int] = Key("air_generation")
"""Which of the air's tables are in use: another number with each change."""
