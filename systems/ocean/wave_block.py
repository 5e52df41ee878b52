"""The waves as shaders take them: a WaveSet seen from an anchor at a moment, in float32."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import WAVE_BLOCK
from ...engine.blocks.layout import StructLayout, Vec2, Vec3, array
from ...engine.made_shaders import made_shader
from ...engine.waves import AnchoredWaves, WaveSet, at_anchor, phases

__all__ = ["WAVE_LAYOUT", "SeaMesh", "WaveBlock", "WavePacker"]

_MOST, _BINS = 1000, 64
_BINS_PER_OCTAVE, _FIRST_OCTAVE = 4.0, -12.0  # wave_bin() of ocean/wave_block.glsl: k from 2^-12 to 2^4 rad/m

_NEAR_TURN = 1e-3
"""A wave whose direction turns by more than this over a kilometre is placed by the whole formula, not by its series."""
_NEAR_RAD = 0.05
"""So is one that is still fading in, or would be within a view of this size."""


@dataclass
class Wave:
    """One wave at the anchor; its amplitude stays, its phase runs. A far one's origin and antipode are so far away that
    a short series places it exactly enough; near ones need the whole formula."""

    heading: Annotated[Vec2, "away from the origin: east, north"]
    phase_cycles: float
    cycles_per_m: float
    amplitude_m: float
    sideways_m: Annotated[float, "how far it moves points aside: Q A"]
    half_cotangent_per_m: Annotated[float, "far: a / radius, a half the cotangent of the angle from the origin"]
    curve_per_m2: Annotated[float, "far: (2 a^2 + 1/6) / radius^2"]
    origin_cos: Annotated[float, "near: of the angle from the origin"]
    origin_sin: float
    fade_from: Annotated[float, "near: where it begins to fade in, 1 - |cos| of the angle from the origin"]
    fade_to: Annotated[float, "near: and where it has its amplitude"]


@dataclass
class WaveBin:
    """What is longer than the waves of a range of wave numbers."""

    slope_variance: Annotated[Vec3, "of all waves that are not: along east, along north, mixed"]
    far_count: int
    near_count: int


@dataclass
class WaveBlock:
    """The waves around an anchor. GLSL: ``generated/sea_waves.glsl``, instance ``sea_waves``."""

    east: Annotated[Vec3, "first tangent at the anchor"]
    radius_m: Annotated[float, "of the calm sea"]
    north: Annotated[Vec3, "second tangent"]
    per_foot: Annotated[float, "radius of the calm sea over the planet's"]
    proxy_m: Annotated[Vec3, "from the anchor"]
    spacing_rad: Annotated[float, "wanted between vertices, seen from the proxy"]
    smallest_spacing_m: float
    footprint_px: Annotated[float, "width of what a pixel averages"]
    ice_sine: Annotated[float, "of the latitude where ice begins; 2: none"]
    farthest_m: Annotated[float, "that waves move anything aside"]
    far_count: int
    count: Annotated[int, "of far waves, then near ones"]
    bins: Annotated[Any, array(WaveBin, _BINS, flat=True)]
    waves: Annotated[Any, array(Wave, _MOST, flat=True)]
    """far ones first, each kind from the longest on"""


WAVE_LAYOUT = StructLayout(WaveBlock)
_HEADER_BYTES = next(m.offset for m in WAVE_LAYOUT.members if m.name == "waves")
_WAVE_BYTES = (WAVE_LAYOUT.size - _HEADER_BYTES) // _MOST
made_shader("generated/sea_waves.glsl", lambda: WAVE_LAYOUT.block(WAVE_BLOCK, "sea_waves"))


@dataclass(frozen=True)
class SeaMesh:
    """What the sea's vertices are chosen by. eye_m: the proxy from the anchor; angle_rad: between vertices; smallest_m:
    their smallest distance; footprint_px: width of what a pixel averages."""

    eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    angle_rad: float = 0.01
    smallest_m: float = 0.1
    footprint_px: float = 1.0


class WavePacker:
    """Fills the block for a set: `place` once per anchor, `at` per moment."""

    def __init__(self) -> None:
        self._bytes = np.zeros(WAVE_LAYOUT.size, np.uint8)
        self._block = self._bytes.view(WAVE_LAYOUT.dtype)[0]
        self.order = np.zeros(0, np.int64)
        """Of the waves of a set in the block."""
        self.way = np.zeros(0)
        self.east, self.north = np.zeros(3), np.zeros(3)
        self.used_bytes = _HEADER_BYTES

    @property
    def head(self) -> NDArray[np.uint8]:
        """The bytes of all but the waves."""
        return self._bytes[:_HEADER_BYTES]

    def place(self, waves: WaveSet, anchor: NDArray[np.float64], planet_radius_m: float, mesh: SeaMesh) -> None:
        """Everything but the phases, at an anchor (3,), unit."""
        seen = at_anchor(waves, anchor, 0.0)
        cos0, sin0 = seen.cos0.astype(np.float64), np.maximum(seen.sin0.astype(np.float64), 1e-30)
        near = np.abs(cos0) * 1000.0 > _NEAR_TURN * sin0 * waves.radius_m
        near |= seen.angle < waves.fade_rad[:, 1] + _NEAR_RAD
        # A stable sort keeps the longest first in both lists.
        self.order = np.argsort(near, kind="stable")
        self.way, self.east, self.north = seen.way, seen.east, seen.north
        block = self._block
        block["east"], block["north"], block["radius_m"] = seen.east, seen.north, waves.radius_m
        block["per_foot"] = waves.radius_m / planet_radius_m
        block["proxy_m"], block["spacing_rad"] = mesh.eye_m, mesh.angle_rad
        block["smallest_spacing_m"], block["footprint_px"] = mesh.smallest_m, mesh.footprint_px
        block["ice_sine"], block["farthest_m"] = waves.ice_sine, waves.farthest_m
        block["far_count"], block["count"] = np.count_nonzero(~near), len(waves)
        _fill_bins(block["bins"], waves, seen, near)
        half = np.where(near, 0.0, 0.5 * cos0 / sin0)
        columns = {
            "heading": seen.heading,
            "cycles_per_m": waves.wave_number_per_m / (2.0 * np.pi),
            "amplitude_m": waves.amplitude_m,
            "sideways_m": waves.steepness * waves.amplitude_m,
            "half_cotangent_per_m": half / waves.radius_m,
            "curve_per_m2": (2.0 * half**2 + 1.0 / 6.0) / waves.radius_m**2,
            "origin_cos": cos0,
            "origin_sin": sin0,
            "fade_from": waves.fade_edges[:, 0],
            "fade_to": waves.fade_edges[:, 1],
        }
        for name, values in columns.items():
            block["waves"][name][: len(waves)] = values[self.order]
        self.used_bytes = _HEADER_BYTES + _WAVE_BYTES * len(waves)

    def at(self, waves: WaveSet, time_s: float) -> NDArray[np.uint8]:
        """The bytes of the waves placed last at a moment; valid until the next call."""
        self._block["waves"]["phase_cycles"][: len(waves)] = phases(waves, self.way, time_s)[self.order]
        return self._bytes[: self.used_bytes]


def _fill_bins(bins: NDArray[np.void], waves: WaveSet, seen: AnchoredWaves, near: NDArray[np.bool_]) -> None:
    """For wave numbers up to each bin's end the waves that long of both lists, and the others' slopes."""
    k = waves.wave_number_per_m
    ends = 2.0 ** (_FIRST_OCTAVE + (np.arange(_BINS) + 1) / _BINS_PER_OCTAVE)
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
    bins["slope_variance"], bins["near_count"] = rest + beyond, of_near
    bins["far_count"] = longer - of_near
