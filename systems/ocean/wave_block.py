"""The waves as shaders take them: a WaveSet seen from an anchor at a moment, in float32."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.waves import AnchoredWaves, WaveSet, at_anchor, phases

__all__ = ["BINS", "BLOCK_BYTES", "MOST", "SeaMesh", "WaveBlock"]

MOST = 1000
BINS = 64
_HEADER = 5
_BINS_PER_OCTAVE, _FIRST_OCTAVE = 4.0, -12.0  # wave_bin() of ocean/wave_block.glsl: k from 2^-12 to 2^4 rad/m
BLOCK_BYTES = 16 * (_HEADER + BINS + 3 * MOST)

_NEAR_TURN = 1e-3
"""A wave whose direction turns by more than this over a kilometre is placed by the whole formula, not by its series."""
_NEAR_RAD = 0.05
"""So is one that is still fading in, or would be within a view of this size."""

Singles = NDArray[np.float32]


@dataclass(frozen=True)
class SeaMesh:
    """What the sea's vertices are chosen by. eye_m: the proxy from the anchor; angle_rad: between vertices; smallest_m:
    their smallest distance; footprint_px: width of what a pixel averages."""

    eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    angle_rad: float = 0.01
    smallest_m: float = 0.1
    footprint_px: float = 1.0


class WaveBlock:
    """Packs a set: `place` once per anchor, `at` per moment."""

    def __init__(self) -> None:
        self._data = np.zeros((_HEADER + BINS + 3 * MOST, 4), np.float32)
        self._order = np.zeros(0, np.int64)
        self._way = np.zeros(0)
        self.used_bytes = 16 * (_HEADER + BINS)

    def place(self, waves: WaveSet, anchor: NDArray[np.float64], planet_radius_m: float, mesh: SeaMesh) -> None:
        """Everything but the phases, at an anchor (3,), unit."""
        seen, k = at_anchor(waves, anchor, 0.0), waves.wave_number_per_m
        cos0, sin0 = seen.cos0.astype(np.float64), np.maximum(seen.sin0.astype(np.float64), 1e-30)
        near = np.abs(cos0) * 1000.0 > _NEAR_TURN * sin0 * waves.radius_m
        near |= seen.angle < waves.fade_rad[:, 1] + _NEAR_RAD
        # A stable sort keeps the longest first in both lists.
        self._order = np.argsort(near, kind="stable")
        self._way = seen.way
        far_count = int(np.count_nonzero(~near))
        data = self._data
        data[:] = 0.0
        data[0] = *seen.east, waves.radius_m
        data[1] = *seen.north, waves.radius_m / planet_radius_m
        data[2] = far_count, len(waves), waves.farthest_m, 0.0
        data[3] = *mesh.eye_m, mesh.angle_rad
        data[4] = mesh.smallest_m, mesh.footprint_px, waves.ice_sine, 0.0
        data[_HEADER : _HEADER + BINS] = _bins(waves, seen, near)
        self._write_waves(waves, seen, near, cos0, sin0, k)
        self.used_bytes = 16 * (_HEADER + BINS + 3 * len(waves))

    def _write_waves(
        self,
        waves: WaveSet,
        seen: AnchoredWaves,
        near: NDArray[np.bool_],
        cos0: NDArray[np.float64],
        sin0: NDArray[np.float64],
        k: NDArray[np.float64],
    ) -> None:
        rows = np.zeros((len(waves), 3, 4))
        rows[:, 0, :2], rows[:, 0, 3] = seen.heading, k / (2.0 * np.pi)
        rows[:, 1, 0], rows[:, 1, 1] = waves.amplitude_m, waves.steepness * waves.amplitude_m
        half = 0.5 * cos0 / sin0
        rows[:, 1, 2] = np.where(near, cos0, half / waves.radius_m)
        rows[:, 1, 3] = np.where(near, sin0, (2.0 * half**2 + 1.0 / 6.0) / waves.radius_m**2)
        h1, h2 = seen.heading.astype(np.float64).T * (k / np.pi)
        squares = np.stack([h1 * h1, 2.0 * h1 * h2, h2 * h2], axis=1)
        squares[near, :2] = waves.fade_edges[near]
        rows[:, 2, :3], rows[:, 2, 3] = squares, k
        first = _HEADER + BINS
        self._data[first : first + 3 * len(waves)] = rows[self._order].reshape(-1, 4)

    def at(self, waves: WaveSet, time_s: float) -> Singles:
        """The block of the waves placed last at a moment; valid until the next call. Rows beyond `used_bytes` are not
        used."""
        first = _HEADER + BINS
        self._data[first : first + 3 * len(waves) : 3, 2] = phases(waves, self._way, time_s)[self._order]
        return self._data[: self.used_bytes // 16]


def _bins(waves: WaveSet, seen: AnchoredWaves, near: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(BINS, 4): for wave numbers up to each bin's end the waves that long of both lists, and the others' slopes."""
    k = waves.wave_number_per_m
    ends = 2.0 ** (_FIRST_OCTAVE + (np.arange(BINS) + 1) / _BINS_PER_OCTAVE)
    ends[-1] = np.inf
    longer = np.searchsorted(k, ends, side="right")  # k rises: waves are sorted, longest first
    of_near = np.concatenate([[0], np.cumsum(near)])[longer]
    # Waves close to their origin have any direction hereabouts.
    heading = seen.heading.astype(np.float64)
    dd = np.stack([heading[:, 0] ** 2, heading[:, 1] ** 2, heading[:, 0] * heading[:, 1]], axis=1)
    dd[near] = 0.5, 0.5, 0.0
    slopes = 0.5 * (waves.amplitude_m * k)[:, None] ** 2 * dd
    rest = np.concatenate([np.cumsum(slopes[::-1], axis=0)[::-1], np.zeros((1, 3))])[longer]
    beyond = 0.5 * waves.slope_variance_beyond * np.array([1.0, 1.0, 0.0])
    return np.column_stack([(longer - of_near) + 1024.0 * of_near, rest + beyond])
