"""A wave in 28 bytes, as the papers hold it: where it comes from, amplitude, wave number, steepness, and how it runs.

At an anchor the same seven numbers say where a wave is in float32: its origin counted in the anchor's axes gives the
heading and the angle from the origin, and the phase of the moment, reduced in float64, stands in place of the speed.
What a wave's place needs beside them follows from these, and its fade from its length and the set's own numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import StructLayout
from ...engine.made_shaders import made_shader
from ...engine.waves import MOST_WAVES, WaveSet, phases
from .wave_block import SeaMesh, WavePacker

__all__ = ["MOST_RECORD_BYTES", "RECORD_LAYOUT", "RecordPacker", "fade_lengths", "printed_records"]


@dataclass
class WaveRecord:
    """Seven floats. GLSL: ``generated/wave_record.glsl``."""

    origin_x: Annotated[float, "unit: planet axes as printed; at an anchor its east, north and up"]
    origin_y: float
    origin_z: float
    amplitude_m: float
    wave_number: Annotated[float, "rad per m as printed, cycles per m at an anchor"]
    steepness: float
    turn: Annotated[float, "speed in rad per s as printed, phase of the moment in cycles at an anchor"]


RECORD_LAYOUT = StructLayout(WaveRecord, "std430")
MOST_RECORD_BYTES = RECORD_LAYOUT.size * MOST_WAVES
made_shader("generated/wave_record.glsl", lambda: RECORD_LAYOUT.glsl)


def printed_records(waves: WaveSet) -> NDArray[np.void]:
    """(N,), as the printed formulas take them."""
    return _records(waves, waves.origins, waves.wave_number_per_m, waves.speed_rad_s)


def fade_lengths(waves: WaveSet) -> tuple[float, float, float, float]:
    """What a wave's fade is found by: angles at which it begins and ends, over the wavelength in metres, and the angles
    at which both end at the latest."""
    begin, end = waves.fade
    return begin / waves.radius_m, end / waves.radius_m, *waves.fade_most_rad


class RecordPacker(WavePacker):
    """Fills the block's head, and a record a wave in place of the block's own.

    printed: as printed, in planet axes, in place of those at an anchor."""

    def __init__(self, printed: bool = False) -> None:
        super().__init__()
        self.printed = printed
        self.records = np.zeros(0, RECORD_LAYOUT.dtype)

    def place(self, waves: WaveSet, anchor: NDArray[np.float64], planet_radius_m: float, mesh: SeaMesh) -> None:
        super().place(waves, anchor, planet_radius_m, mesh)
        if self.printed:
            self.records = printed_records(waves)
            return
        axes = np.stack([self.east, self.north, anchor], axis=1)
        cycles = waves.wave_number_per_m / (2.0 * np.pi)
        self.records = _records(waves, waves.origins @ axes, cycles, np.zeros(len(waves)))[self.order]

    def at(self, waves: WaveSet, time_s: float) -> NDArray[np.uint8]:
        if not self.printed:
            self.records["turn"] = phases(waves, self.way, time_s)[self.order]
        return self.head


def _records(
    waves: WaveSet, origins: NDArray[np.float64], wave_number: NDArray[np.float64], turn: NDArray[np.float64]
) -> NDArray[np.void]:
    found = np.zeros(len(waves), RECORD_LAYOUT.dtype)
    for axis, name in enumerate(("origin_x", "origin_y", "origin_z")):
        found[name] = origins[:, axis]
    found["amplitude_m"], found["steepness"] = waves.amplitude_m, waves.steepness
    found["wave_number"], found["turn"] = wave_number, turn
    return found
