"""Stars: the night sky."""

from __future__ import annotations

from dataclasses import dataclass

from ._knob import knob

__all__ = ["Stars"]


@dataclass
class Stars:
    """Stars at fixed places of the sky. Equal seeds give equal skies."""

    density: float = knob(1.0, 0.0, 10.0, "", "Number of stars; 1 is about what the eye sees from Earth")
    brightness: float = knob(1.0, 0.0, 1000.0, "", "Brightness of all stars; 1 is about that of Earth's", log=True)
    seed: int = knob(1, 0, 2**31 - 1, "", "Which sky")
