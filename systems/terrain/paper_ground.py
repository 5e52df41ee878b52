"""The ground of the projected grid's paper mode: a continents texture and layers of simplex noise, in float64.

Michelic (2018, section 6) draws his planet from a precomputed 1024^2 texture of the continents in longitude and
latitude, and up to ten layers of 3D simplex noise on top. Printed are the texture's size and mapping, and the number
of layers. Filled in here: the texture holds this planet's own heights, low-passed, so that it shows the same
continents as the scene; it is read with a cubic B-spline; the first layer is 32 km wide on Earth, each half of the one
before, 0.57 times as high; near height 0 the layers are lower.

assets/shaders/terrain/paper/ground.glsl is the GPU's side, around an anchor. The scene's truth stays what
TerrainSampler says; `PaperField` is the truth of what this mode draws.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import TERRAIN_TABLE_BLOCK
from ...engine.blocks.layout import IVec2, IVec3, StructLayout, Vec2, Vec3, array
from ...engine.made_shaders import made_shader
from ...engine.surface.noise import octave_offset
from ...engine.surface.simplex import simplex_noise, skew
from .height import TerrainField, TerrainParams

Floats = NDArray[np.float64]

TEXELS = 1024
"""Of the continents texture, each way."""
MOST_LAYERS = 10
FIRST_WAVELENGTH_M = 32768.0
"""Of the first layer on a planet of Earth's size: about the width of a texel."""
GAIN = 2.0**-0.8
"""Height of a layer against the one before."""
RELIEF_SHARE = 0.035
"""Height of the first layer as a share of the planet's relief ..."""
STEEPNESS = 0.03
"""... but not more than this of its wavelength, times the roughness of the scene's ground."""
ROUGH_SHARE = 0.15
"""Layers have their full height where the continents are as far as this share of their highest from height 0 ..."""
CALM = 0.05
"""... and at least this share of it: plains and shelves would be archipelagos otherwise."""
_SEED_OFFSET = 4096  # octaves of the scene's own ground have smaller numbers
_CONTINENT_LAYERS = 5  # of the scene's ground: 8 km on Earth, well below a texel
_BLUR_TEXELS = 0.6  # standard deviation of the low-pass, in texels at the equator
_FEWEST = 64  # samples of a parallel
_BLOCK = 8192


@dataclass
class PaperOctave:
    """A layer of simplex noise around the anchor, in skewed cells."""

    cell: Annotated[IVec3, "of the anchor"]
    frequency_per_m: float
    fraction: Annotated[Vec3, "the anchor's place in its cell"]
    amplitude_m: float


@dataclass
class PaperTable:
    """The ground around an anchor. GLSL: ``generated/paper_table.glsl``, ``paper_table``."""

    up: Annotated[Vec3, "of the anchor"]
    radius_m: float
    meridian: Annotated[Vec2, "cosine and sine of the longitude counted from"]
    beside: Annotated[float, "what the anchor lies beside it, in radii"]
    from_axis: Annotated[float, "the anchor's distance from the planet's axis, in radii"]
    texel_fraction: Annotated[Vec2, "of the anchor's column and row"]
    height_m: Annotated[float, "of the anchor"]
    per_rough_m: Annotated[float, "1 / height of full roughness"]
    texel: Annotated[IVec2, "the anchor's column and row"]
    layer_count: int
    layers: Annotated[Any, array(PaperOctave, MOST_LAYERS)]


_LAYOUT = StructLayout(PaperTable)
TABLE_DTYPE = _LAYOUT.dtype
_NUMBERS = f"const int PAPER_TEXELS = {TEXELS};\nconst float PAPER_CALM = {CALM};\n"
made_shader("generated/paper_table.glsl", lambda: _NUMBERS + _LAYOUT.block(TERRAIN_TABLE_BLOCK, "paper_table"))


@dataclass(frozen=True, eq=False)
class PaperLayer:
    """One layer of simplex noise."""

    wavelength_m: float
    amplitude_m: float
    offset: Floats
    """(3,), wavelengths."""


class PaperField:
    """The paper mode's ground as a HeightField (engine/surface/field.py).

    layers: 0..10 layers of simplex noise on the continents.
    """

    def __init__(self, params: TerrainParams, layers: int) -> None:
        if not 0 <= layers <= MOST_LAYERS:
            raise ValueError(f"PaperField: layers: expected 0 to {MOST_LAYERS}, found {layers!r}")
        self.params = params
        self.continents = continents(params)
        first_m = FIRST_WAVELENGTH_M * params.scale
        relief_m = params.highest_m - params.lowest_m
        height_m = min(RELIEF_SHARE * relief_m, STEEPNESS * max(params.roughness, 0.0) * first_m)
        self.layers = tuple(
            PaperLayer(first_m * 0.5**k, height_m * GAIN**k, octave_offset(params.seed, _SEED_OFFSET + k))
            for k in range(layers)
        )
        self.rough_m = ROUGH_SHARE * max(abs(params.highest_m), abs(params.lowest_m))
        most = sum(layer.amplitude_m for layer in self.layers)
        self._highest_m = float(self.continents.max()) + most
        self._lowest_m = float(self.continents.min()) - most

    @property
    def highest_m(self) -> float:
        """No ground is higher."""
        return self._highest_m

    @property
    def lowest_m(self) -> float:
        """No ground is lower."""
        return self._lowest_m

    @property
    def radius_m(self) -> float:
        """Reference radius."""
        return self.params.radius_m

    def height(self, directions: Floats) -> Floats:
        """Heights (N,) at unit directions (N, 3)."""
        directions = np.asarray(directions, dtype=np.float64)
        return self.height_at_feet(directions * self.radius_m)

    def height_at_feet(self, feet_m: Floats) -> Floats:
        """Heights (N,) at points (N, 3) near the reference sphere, planet-centred metres: of the noise at the very
        point, of the texture in its direction."""
        parts = [self._heights(feet_m[k : k + _BLOCK]) for k in range(0, len(feet_m), _BLOCK)]
        return np.concatenate(parts) if parts else np.empty(0)

    def _heights(self, feet_m: Floats) -> Floats:
        land = sample_continents(self.continents, feet_m)
        noise = np.zeros(len(feet_m))
        for layer in self.layers:
            noise += layer.amplitude_m * simplex_noise(feet_m / layer.wavelength_m + layer.offset)
        return land + noise * np.clip(np.abs(land) / self.rough_m, CALM, 1.0)

    def height_gradient(self, directions: Floats, footprint_m: float | Floats | None = None) -> tuple[Floats, Floats]:
        """Heights (N,) and tangential gradients (N, 3) at unit directions (N, 3), from neighbours at half a footprint
        (a metre, if none is given) on both sides."""
        directions = np.asarray(directions, dtype=np.float64)
        footprint = np.asarray(1.0 if footprint_m is None else footprint_m, dtype=np.float64)
        step: Floats = 0.5 * np.broadcast_to(footprint, (len(directions),))[:, None]
        helper = np.eye(3)[np.argmin(np.abs(directions), axis=1)]
        u = np.asarray(np.cross(directions, helper), dtype=np.float64)
        u = u / np.linalg.norm(u, axis=1, keepdims=True)
        v = np.asarray(np.cross(directions, u), dtype=np.float64)
        feet = directions * self.radius_m
        gradient = np.zeros_like(directions)
        for side in (u, v):
            rise = self.height_at_feet(feet + step * side) - self.height_at_feet(feet - step * side)
            gradient += side * rise[:, None] / (2.0 * step)
        return self.height(directions), gradient

    def table(self, direction: Floats, anchor_height_m: float) -> NDArray[np.void]:
        """The block for the shader around an anchor: what has to be right to a millimetre comes from float64."""
        table = np.zeros((), TABLE_DTYPE)
        x, y, z = (float(v) for v in direction)
        rho = float(np.hypot(x, y))
        # Where longitudes crowd they are counted from the meridian of 0 instead of the anchor's own.
        mx, my = (x / rho, y / rho) if rho > 1e-3 else (1.0, 0.0)
        longitude = float(np.arctan2(my, mx))
        column = longitude * (TEXELS / (2.0 * np.pi)) - 0.5
        row = (float(np.arctan2(z, rho)) / np.pi + 0.5) * TEXELS - 0.5
        table["up"], table["radius_m"], table["meridian"] = (x, y, z), self.radius_m, (mx, my)
        table["beside"], table["from_axis"] = mx * y - my * x, rho
        table["texel_fraction"] = column - np.floor(column), row - np.floor(row)
        table["texel"] = np.floor(column), np.floor(row)
        table["height_m"], table["per_rough_m"] = anchor_height_m, 1.0 / self.rough_m
        table["layer_count"] = len(self.layers)
        for k, layer in enumerate(self.layers):
            skewed = skew(np.asarray(direction) * (self.radius_m / layer.wavelength_m) + layer.offset)
            cell = np.floor(skewed)
            octave = table["layers"][k]
            octave["cell"], octave["fraction"] = cell.astype(np.int64).astype(np.int32), skewed - cell
            octave["frequency_per_m"], octave["amplitude_m"] = 1.0 / layer.wavelength_m, layer.amplitude_m
        return table


@lru_cache(maxsize=2)
def continents(params: TerrainParams) -> NDArray[np.float32]:
    """The texture (TEXELS rows from south to north, TEXELS columns from longitude 0 eastwards), metres.

    Texel (row, column) stands for latitude (row + 1/2) 180/1024 - 90 and longitude (column + 1/2) 360/1024 degrees.
    A second or two, then cached. The same on every machine up to the rounding of float32.
    """
    field = TerrainField(replace(params, layers=min(params.layers, _CONTINENT_LAYERS)))
    rows = TEXELS // 2  # a texel is half as tall as wide
    latitude = (np.arange(rows) + 0.5) * (np.pi / rows) - 0.5 * np.pi
    order = np.arange(TEXELS // 2 + 1)
    heights = np.empty((rows, TEXELS))
    for k, phi in enumerate(latitude):
        # Towards the poles a parallel is shorter: fewer samples of it show the same.
        count = max(_FEWEST, 2 ** int(np.ceil(np.log2(TEXELS * np.cos(phi)))))
        longitude = (np.arange(count) + 0.5) * (2.0 * np.pi / count)
        level = np.full(count, np.sin(phi))
        directions = np.stack([np.cos(phi) * np.cos(longitude), np.cos(phi) * np.sin(longitude), level], axis=1)
        waves = np.zeros(len(order), complex)
        half = count // 2
        waves[:half] = np.fft.rfft(field.height(directions))[:half] * (TEXELS / count)
        # From the middles of samples to those of texels, and the low-pass: as wide on the ground whatever the latitude.
        shift = np.exp(1j * np.pi * order * (1.0 / TEXELS - 1.0 / count))
        sigma = _BLUR_TEXELS * (2.0 * np.pi / TEXELS) / np.cos(phi)
        heights[k] = np.fft.irfft(waves * shift * np.exp(-0.5 * (sigma * order) ** 2), TEXELS)
    # The same along the meridians: over a pole the columns go on half a turn away.
    turned = np.roll(heights, TEXELS // 2, axis=1)
    padded = np.concatenate([turned[3::-1], heights, turned[:-5:-1]])
    texture = np.empty((TEXELS, TEXELS))
    reach = np.arange(-4, 5)
    for side in (0, 1):  # texels lie a quarter of a row below and above the rows' middles
        weights = np.exp(-0.5 * ((reach - (0.25, -0.25)[1 - side]) / _BLUR_TEXELS) ** 2)
        weights /= weights.sum()
        texture[side::2] = sum(w * padded[4 + r : 4 + r + rows] for w, r in zip(weights, reach, strict=True))
    return texture.astype(np.float32)


def sample_continents(texture: NDArray[np.float32], points: Floats) -> Floats:
    """Heights (N,) of the texture in the directions of `points` (N, 3): cubic B-spline, over the poles too."""
    rho = np.hypot(points[:, 0], points[:, 1])
    column = np.arctan2(points[:, 1], points[:, 0]) * (TEXELS / (2.0 * np.pi)) - 0.5
    row = (np.arctan2(points[:, 2], rho) / np.pi + 0.5) * TEXELS - 0.5
    first_column, first_row = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)
    across, up = spline_weights(column - first_column), spline_weights(row - first_row)
    total = np.zeros(len(points))
    for k in range(4):
        y = first_row + k - 1
        over = (y < 0) | (y >= TEXELS)
        y = np.where(y < 0, -1 - y, np.where(y >= TEXELS, 2 * TEXELS - 1 - y, y))
        for l in range(4):
            x = (first_column + l - 1 + np.where(over, TEXELS // 2, 0)) % TEXELS
            total += up[k] * across[l] * texture[y, x]
    return total


def spline_weights(f: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Weights of the cubic B-spline of the four texels around fraction f."""
    g = 1.0 - f
    return (
        g**3 / 6.0,
        (4.0 - 6.0 * f**2 + 3.0 * f**3) / 6.0,
        (4.0 - 6.0 * g**2 + 3.0 * g**3) / 6.0,
        f**3 / 6.0,
    )


__all__ = ["MOST_LAYERS", "TABLE_DTYPE", "TEXELS", "PaperField", "PaperLayer", "continents", "sample_continents"]
