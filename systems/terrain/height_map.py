"""A height map as a part of the height function, float64: the twin of assets/shaders/terrain/height_map.glsl.

The map is resampled once to the faces of a cube (engine/surface/cube_map.py), whose samples are float32 on both sides;
between them heights are cubic (Catmull-Rom, continuous slopes). A second channel says how rough the map is at its
finest scale; there the relief layers shorter than its samples go on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.display import reflectance
from ...engine.surface.cube_map import CubeMap, cube_of, face_directions, face_place
from ...engine.surface.map_files import files_stamp, load_cube, read_colors, read_heights
from ...engine.wavelengths import Nanometres

__all__ = ["HeightMap", "color_cube", "height_map", "map_level"]

Floats = NDArray[np.float64]

LEVEL_SAMPLES = 1.5
"""Gradients come from the level whose samples are this many footprints apart."""

_NEXT_OCTAVE = 0.55
"""Of the relief between two and four samples apart: what one octave below it has, for a spectrum that falls as that of
ground between 100 m and 10 km does (height differences grow as distance^0.55 to ^0.85)."""

_NOISE_RMS = 0.27  # of gradient noise

_BLOCKS = 4
_STEEPER = 1.25  # than between samples: the cubic's slope in the middle of a step is 1.5 at most, 1.25 on even ground


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights and roughness around a planet, and what is known of them. Equal only to itself.

    cube: channels (height in m, height differences of its finest scale in m, rms). lowest_m, highest_m: of all samples.
    sample_rad: angle between samples in the middle of a face, where they are widest.
    """

    cube: CubeMap
    lowest_m: float
    highest_m: float

    @property
    def sample_rad(self) -> float:
        return 2.0 / self.cube.cells

    def slopes(self, radius_m: float) -> Floats:
        """Largest slopes (6, blocks, blocks) of ground in blocks of samples and a block around each."""
        return _block_slopes(self, radius_m)


@lru_cache(maxsize=4)
def _block_slopes(found: HeightMap, radius_m: float) -> Floats:
    values = found.cube.levels[0][..., 0].astype(np.float64)
    n = found.cube.cells
    blocks = max(n // _BLOCKS, 1)
    at = (2.0 * np.arange(-1, n + 2) - n) / n
    steep = np.zeros((6, blocks, blocks))
    bins = np.minimum(np.arange(n) * blocks // n, blocks - 1)
    starts = np.searchsorted(bins, np.arange(blocks))
    for face in range(6):
        d = face_directions(face, *np.broadcast_arrays(at[None, :], at[:, None]))
        d /= np.linalg.norm(d, axis=2)[..., None]
        along = np.abs(np.diff(values[face], axis=1)) / (radius_m * np.linalg.norm(np.diff(d, axis=1), axis=2))
        across = np.abs(np.diff(values[face], axis=0)) / (radius_m * np.linalg.norm(np.diff(d, axis=0), axis=2))
        each = np.hypot(
            np.maximum(along[1:-2, 1:-1], along[2:-1, 1:-1]), np.maximum(across[1:-1, 1:-2], across[1:-1, 2:-1])
        )
        steep[face] = np.maximum.reduceat(np.maximum.reduceat(each, starts, axis=0), starts, axis=1)
    middle = (2.0 * np.arange(-1, blocks + 1) + 1.0 - blocks) / blocks
    wide = np.empty((6, blocks + 2, blocks + 2))
    for face in range(6):
        points = face_directions(face, *np.broadcast_arrays(middle[None, :], middle[:, None])).reshape(-1, 3).T
        wide[face] = CubeMap.block_values(steep, points).reshape(blocks + 2, blocks + 2)
    near = [wide[:, j : j + blocks, i : i + blocks] for j in range(3) for i in range(3)]
    return _STEEPER * np.maximum.reduce(near)


def slopes_at(found: HeightMap, points: Floats, radius_m: float) -> Floats:
    """Slopes (N,) that the map hardly ever exceeds around points (3, N)."""
    return CubeMap.block_values(found.slopes(radius_m), points)


def map_level(sample_m: float, footprint_m: Floats, levels: int) -> Floats:
    """The level, a fraction, whose gradients a footprint shows."""
    return np.clip(np.log2(LEVEL_SAMPLES * footprint_m / sample_m), 0.0, levels - 1.0)


def map_values(found: HeightMap, points: Floats) -> tuple[Floats, Floats]:
    """Height in m (N,) and height differences of the finest scale in m (N,), at points (3, N)."""
    height, rough = found.cube.sample(points)
    return height, np.maximum(rough, 0.0)


def map_gradients(
    found: HeightMap, points: Floats, radius_m: float, footprint_m: Floats | None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Height (N,), its gradient (3, N), height differences of the finest scale (N,) and theirs (3, N)."""
    values, slopes = found.cube.sample_gradient(points)
    rising = values[1] > 0.0
    height, rough = values[0], np.where(rising, values[1], 0.0)
    gradient, rougher = slopes[0], np.where(rising, slopes[1], 0.0)
    levels = len(found.cube.levels)
    if footprint_m is not None and levels > 1:
        level = map_level(found.sample_rad * radius_m, footprint_m, levels)
        gradient = gradient * np.maximum(1.0 - level, 0.0)
        for k in range(1, levels):
            near = np.flatnonzero(np.abs(level - k) < 1.0)
            if near.size:
                _, coarse = found.cube.sample_gradient(points[:, near], k)
                gradient[:, near] += (1.0 - np.abs(level[near] - k)) * coarse[0]
    return height, gradient, rough, rougher


def height_map(path: str, range_m: tuple[float, float] | None) -> HeightMap:
    """The map at `path`, read once as long as its files stay as they are. MapError says what is wrong."""
    return _height_map(path, range_m, files_stamp(path))


@lru_cache(maxsize=3)
def _height_map(path: str, range_m: tuple[float, float] | None, _files: tuple[object, ...]) -> HeightMap:
    cube = load_cube(path, "Terrain.height_map", read_heights(range_m))
    heights = cube.levels[0][..., 0]
    return HeightMap(_with_roughness(cube), float(heights.min()), float(heights.max()))


@lru_cache(maxsize=3)
def _color_cube(path: str, nm: Nanometres, _files: tuple[object, ...]) -> CubeMap:
    return load_cube(path, "Terrain.color_map", partial(_read_reflectance, nm))


def _read_reflectance(nm: Nanometres, file: Path, what: str) -> NDArray[Any]:
    """(h, w, 3) reflectance at the three wavelengths of a picture's colours."""
    roots = np.rint(np.sqrt(read_colors(file, what)) * 1023.0).astype(np.uint32)  # four steps in one of the texture's
    packed, place = np.unique(roots[..., 0] << 20 | roots[..., 1] << 10 | roots[..., 2], return_inverse=True)
    colors = (np.stack([packed >> 20, packed >> 10 & 1023, packed & 1023], axis=1) / 1023.0) ** 2
    return reflectance(colors, nm).astype(np.float32)[place.reshape(roots.shape[:2])]


def color_cube(path: str, nm: Nanometres) -> CubeMap:
    """Reflectance at the wavelengths `nm` of the colours at `path`, three channels, read once. MapError says what is
    wrong."""
    return _color_cube(path, nm, files_stamp(path))


def _with_roughness(cube: CubeMap) -> CubeMap:
    """A second channel: rms over some samples of what a [1 2 1] blur takes away, the relief 2 to 4 samples wide."""
    heights = cube.levels[0][..., 0].astype(np.float64)
    blurred = 0.25 * heights[:, :-2] + 0.5 * heights[:, 1:-1] + 0.25 * heights[:, 2:]
    blurred = 0.25 * blurred[:, :, :-2] + 0.5 * blurred[:, :, 1:-1] + 0.25 * blurred[:, :, 2:]
    power = (heights[:, 1:-1, 1:-1] - blurred) ** 2
    for _ in range(3):
        padded = np.pad(power, ((0, 0), (1, 1), (1, 1)), mode="edge")
        power = 0.25 * padded[:, :-2] + 0.5 * padded[:, 1:-1] + 0.25 * padded[:, 2:]
        power = 0.25 * power[:, :, :-2] + 0.5 * power[:, :, 1:-1] + 0.25 * power[:, :, 2:]
    inner = np.sqrt(power)
    # Read across the edges once more, so that both faces agree on them.
    rough = cube_of(lambda points: _nearest(inner, points), cube.cells, coarsest=cube.cells)
    levels = [np.concatenate([cube.levels[0], rough.levels[0]], axis=3)]
    levels += [np.concatenate([level, np.zeros_like(level)], axis=3) for level in cube.levels[1:]]
    return CubeMap(tuple(levels))


def _nearest(inner: Floats, points: Floats) -> Floats:
    n = inner.shape[1] - 1
    face, s, t, _ = face_place(points)
    i, j = (np.clip(np.rint((v * 0.5 + 0.5) * n).astype(np.int64), 0, n) for v in (s, t))
    return inner[face, j, i][None]


def roughness_factor(amplitude_m: Floats, wavelength_m: Floats, sample_m: float) -> float:
    """What makes of height differences at the map's finest scale a multiplier of the layers: those are then as high as
    the map goes on. amplitude_m, wavelength_m: of the layers at multiplier 1."""
    shorter = np.flatnonzero((wavelength_m < 2.0 * sample_m) & (amplitude_m > 0.0))
    if not shorter.size:
        return 0.0
    first = shorter[0]
    # The layer's own place in that spectrum: octaves below the first one beyond the samples.
    octaves = math.log2(max(2.0 * sample_m / float(wavelength_m[first]), 1.0))
    return _NEXT_OCTAVE ** (1.0 + octaves) / (_NOISE_RMS * float(amplitude_m[first]))
