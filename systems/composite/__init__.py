"""Composite: from scene radiance to the picture (exposure, glare, tone map, dither); see docs/exposure.md."""

from .system import CompositeSystem, ExposureReading, read_exposure
from .tone_maps import TONE_MAPS, tone_map

__all__ = ["TONE_MAPS", "CompositeSystem", "ExposureReading", "read_exposure", "tone_map"]
