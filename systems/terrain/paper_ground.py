"""The ground of the projected grid's paper mode: a continents texture and layers of simplex noise, in float64.

Michelic (2018, section 6) draws his planet from a precomputed 1024^2 texture of the continents in longitude and
latitude, and up to ten layers of 3D simplex noise on top. Printed are the texture's size and mapping, and the number
of layers. Filled in here: the texture holds this planet's own heights, low-passed and before rivers and gullies, so
that it shows the same continents as the scene, and beside them how much relief they lack; it is read with a cubic
B-spline. The first layer is 32 km wide on Earth, each half of the one before, 0.57 times as high, and their height is
the relief that is lacking: mountains stand where the scene's do, and plains are as flat.

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
_FULL_LAYERS = 5
"""So many layers, the source's own choice for its pictures, have the relief that the texture lacks."""
_NOISE_DEVIATION = 0.2
"""Standard deviation of the first layers within some 100 km; of simplex noise everywhere it is 0.216."""
_SEED_OFFSET = 4096  # octaves of the scene's own ground have smaller numbers
_SCENE_LAYERS = 8  # of the scene's ground: 1 km on Earth, well below a texel
_BLUR_TEXELS = 0.6  # standard deviation of the low-pass, in texels at the equator
_WINDOW_TEXELS = 0.74  # and of the window that relief is measured in: that of 100 km on Earth
_FEWEST = 64  # samples of a parallel
_BLOCK = 8192


@dataclass
class PaperOctave:
    """A layer of simplex noise around the anchor, in skewed cells."""

    cell: Annotated[IVec3, "of the anchor"]
    frequency_per_m: float
    fraction: Annotated[Vec3, "the anchor's place in its cell"]
    amplitude: Annotated[float, "a share of the relief that the texture lacks"]


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
    texel: Annotated[IVec2, "the anchor's column and row"]
    layer_count: int
    layers: Annotated[Any, array(PaperOctave, MOST_LAYERS)]


_LAYOUT = StructLayout(PaperTable)
TABLE_DTYPE = _LAYOUT.dtype
_NUMBERS = f"const int PAPER_TEXELS = {TEXELS};\n"
made_shader("generated/paper_table.glsl", lambda: _NUMBERS + _LAYOUT.block(TERRAIN_TABLE_BLOCK, "paper_table"))


@dataclass(frozen=True, eq=False)
class PaperLayer:
    """One layer of simplex noise."""

    wavelength_m: float
    amplitude: float
    """A share of the relief that the texture lacks."""
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
        unit = 1.0 / (_NOISE_DEVIATION * np.sqrt(sum(GAIN ** (2 * k) for k in range(_FULL_LAYERS))))
        self.layers = tuple(
            PaperLayer(first_m * 0.5**k, unit * GAIN**k, octave_offset(params.seed, _SEED_OFFSET + k))
            for k in range(layers)
        )
        land, relief = self.continents[..., 0], self.continents[..., 1]
        most = sum(layer.amplitude for layer in self.layers)
        self._highest_m = float((land + most * relief).max())
        self._lowest_m = float((land - most * relief).min())

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
        land, relief = sample_continents(self.continents, feet_m)
        noise = np.zeros(len(feet_m))
        for layer in self.layers:
            noise += layer.amplitude * simplex_noise(feet_m / layer.wavelength_m + layer.offset)
        return land + relief * noise

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
        table["height_m"] = anchor_height_m
        table["layer_count"] = len(self.layers)
        for k, layer in enumerate(self.layers):
            skewed = skew(np.asarray(direction) * (self.radius_m / layer.wavelength_m) + layer.offset)
            cell = np.floor(skewed)
            octave = table["layers"][k]
            octave["cell"], octave["fraction"] = cell.astype(np.int64).astype(np.int32), skewed - cell
            octave["frequency_per_m"], octave["amplitude"] = 1.0 / layer.wavelength_m, layer.amplitude
        return table


@lru_cache(maxsize=2)
def continents(params: TerrainParams) -> NDArray[np.float32]:
    """The texture (TEXELS rows from south to north, TEXELS columns from longitude 0 eastwards, 2), metres: heights,
    and the standard deviation that heights within some 100 km have beyond the texture's own.

    Texel (row, column) stands for latitude (row + 1/2) 180/1024 - 90 and longitude (column + 1/2) 360/1024 degrees.
    A second or two, then cached. The same on every machine up to the rounding of float32.
    """
    field = TerrainField(replace(params, layers=min(params.layers, _SCENE_LAYERS), erosion=0.0, rivers=None))
    latitude: Floats = (np.arange(TEXELS, dtype=np.float64) + 0.5) * (np.pi / TEXELS) - 0.5 * np.pi
    scene = np.stack([_parallel(field, phi) for phi in latitude])
    land = _low_passed(scene, latitude, _BLUR_TEXELS)
    lacking = _variance(scene, latitude) - _variance(land, latitude)
    return np.stack([land, np.sqrt(np.maximum(lacking, 0.0))], axis=-1).astype(np.float32)


def _parallel(field: TerrainField, phi: float) -> Floats:
    """Heights (TEXELS,) along a parallel. Towards the poles it is shorter: fewer samples of it show the same."""
    count = max(_FEWEST, 2 ** int(np.ceil(np.log2(TEXELS * np.cos(phi)))))
    longitude = (np.arange(count) + 0.5) * (2.0 * np.pi / count)
    level = np.full(count, np.sin(phi))
    directions = np.stack([np.cos(phi) * np.cos(longitude), np.cos(phi) * np.sin(longitude), level], axis=1)
    order = np.arange(count // 2)
    waves = np.zeros(TEXELS // 2 + 1, complex)
    # From the middles of samples to those of texels.
    shift = np.exp(1j * np.pi * order * (1.0 / TEXELS - 1.0 / count)) * (TEXELS / count)
    waves[: count // 2] = np.fft.rfft(field.height(directions))[: count // 2] * shift
    return np.fft.irfft(waves, TEXELS)


def _variance(heights: Floats, latitude: Floats) -> Floats:
    """Of heights in a window around each texel."""
    square, mean = (_low_passed(values, latitude, _WINDOW_TEXELS) for values in (heights**2, heights))
    return square - mean**2


def _low_passed(values: Floats, latitude: Floats, texels: float) -> Floats:
    """Values under a Gaussian of this standard deviation, as wide on the ground whatever the latitude."""
    order = np.arange(TEXELS // 2 + 1)
    sigma = texels * (2.0 * np.pi / TEXELS) / np.cos(latitude)
    blurred = np.fft.irfft(np.fft.rfft(values) * np.exp(-0.5 * (sigma[:, None] * order) ** 2), TEXELS)
    # The same along the meridians, where texels are half as wide: over a pole the columns go on half a turn away.
    reach = int(np.ceil(8.0 * texels))
    turned = np.roll(blurred, TEXELS // 2, axis=1)
    padded = np.concatenate([turned[reach - 1 :: -1], blurred, turned[: -reach - 1 : -1]])
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (2.0 * texels)) ** 2)
    weights /= weights.sum()
    return np.asarray(sum(w * padded[k : k + TEXELS] for k, w in enumerate(weights)))


def sample_continents(texture: NDArray[np.float32], points: Floats) -> tuple[Floats, Floats]:
    """Both values (N,) of the texture in the directions of `points` (N, 3): cubic B-spline, over the poles too."""
    rho = np.hypot(points[:, 0], points[:, 1])
    column = np.arctan2(points[:, 1], points[:, 0]) * (TEXELS / (2.0 * np.pi)) - 0.5
    row = (np.arctan2(points[:, 2], rho) / np.pi + 0.5) * TEXELS - 0.5
    first_column, first_row = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)
    across, up = spline_weights(column - first_column), spline_weights(row - first_row)
    total = np.zeros((len(points), 2))
    for k in range(4):
        y = first_row + k - 1
        over = (y < 0) | (y >= TEXELS)
        y = np.where(y < 0, -1 - y, np.where(y >= TEXELS, 2 * TEXELS - 1 - y, y))
        for l in range(4):
            x = (first_column + l - 1 + np.where(over, TEXELS // 2, 0)) % TEXELS
            total += (up[k] * across[l])[:, None] * texture[y, x]
    return total[:, 0], total[:, 1]


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
