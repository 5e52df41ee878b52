"""The height function's octaves and constants for one set of params, shared by numpy and the GPU's table.

The surface is a point-wise function of a few noises (see docs/terrain-height.md for the picture):

    w1, w2      two vector noises (4194 km, 262 km): domain warps; w1 also says where belts, hills and moisture are
    c           five octaves (8388..524 km), warped by w1 and w2: continents; x = (c - sea level) / deviation + coast s
    b           two octaves (4194, 1048 km), warped likewise: mountain belts run along b = 0
    s           up to four ridged layers (131..16 km), warped by w2: the ranges and valleys inside a belt; the first
                two (a) gate the next two (b), so that basins between ranges are calm: s = a + gate(a) b
    z           the remaining layers (8 km..4 m), amplitudes in metres: ridged down to 2 km and warped by w2 so far

    M = belts and coastal ranges (0..1), faded in the sea     E = hypsometry(x)      m = smoothstep(s)
    roughness = T (1/2 + m) + M (r0 + r1 m)                   T = plains and hills
    h = limit( E + M (foot + range m) + T hill m + roughness z + craters + map )

A height map takes the place of E, M and T as far as it is told to, and adds its own roughness.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.noise import Lattice, octave_offset
from .craters import Craters, craters_of
from .gullies import FIRST_GULLY
from .height_map import roughness_factor
from .height_params import TerrainParams
from .height_steps import RIDGE_SLOPE

Floats = NDArray[np.float64]

CONTINENTS, BELTS = 5, 2
FIELDS = CONTINENTS + BELTS
"""Octaves warped by both warps, before the layers."""

GATING_LAYERS, SHAPE_LAYERS, WARPED_LAYERS = 2, 4, 7
"""Layers below the first index gate the next ones, those below the second make ranges, below the third are warped."""


def _single(values: float | list[float] | Floats) -> Floats:
    """Rounded to float32: the GPU's table holds these numbers, and a rounded slope of kilometres is decimetres."""
    return np.asarray(values, dtype=np.float32).astype(np.float64)


# The two families in one order that puts the steepest first: c0 c1 b0 c2 b1 c3 c4.
_FIELD_WAVELENGTHS_M: Floats = 2.0 ** np.array([23, 22, 22, 21, 20, 20, 19])
_CONTINENT_WEIGHTS = _single([1.0, 0.8, 0.0, 0.42, 0.0, 0.24, 0.13])
_BELT_WEIGHTS = _single([0.0, 0.0, 1.0, 0.0, 0.35, 0.0, 0.0])
_FIRST_LAYER_M = 2.0**17
_WARP_WAVELENGTHS_M: Floats = 2.0 ** np.array([22, 18])
_WARP_AMPLITUDES_M = np.array([1.1e6, 4.5e4])
_SHAPE_WEIGHTS = _single([1.0, 0.8, 0.5, 0.3])

GATE_SHUT, GATE_LOW, GATE_WIDTH = 0.2, 0.8, 1.4
"""gate(a) = shut + (1 - shut) smoothstep((a + low) / width)."""

_NOISE_SLOPE = 0.86
"""Root mean square slope of one octave of gradient noise, by the lattice coordinate."""


@dataclass(frozen=True, slots=True)
class TerrainConstants:
    """Scalars of the point-wise part, in the order in which the GPU's table holds them. Heights in metres.

    All are rounded to float32, see `_single`.
    """

    sea_level: float  # value of c at height 0
    inverse_deviation: float  # 1 / standard deviation of c
    coast: float  # how much s bends the coasts
    inverse_belt: float  # 1 / half width of a belt in b
    mountains: float  # 0..1: height of coastal ranges
    # hypsometry: plains * (earth) + (1 - plains) * (even)
    coast_m: float
    lowland_m: float
    slope_m: float
    abyss_m: float
    plateau_m: float
    middle_m: float
    spread_m: float
    plains: float
    # ranges
    foot_m: float
    range_m: float
    hill_m: float
    shape_low: float  # m = smoothstep((s + low) * inverse_width)
    shape_inverse: float
    gentle: float  # roughness of plains
    hills: float  # added by hills
    calm: float  # roughness of valleys in belts
    wild: float  # added on ranges
    knee_high_m: float  # the limit is the identity between the knees
    knee_low_m: float
    room_high_m: float
    room_low_m: float

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, float(np.float32(getattr(self, field.name))))


@dataclass(frozen=True, slots=True)
class Model:
    """Octaves (lattices) and constants of one planet.

    `unwarped`: two warps, then the layers from WARPED_LAYERS on. `warped`: FIELDS octaves, then the layers before.
    `ridge`: share of the ridge transform in each layer, negative for its mirror image (sharp valleys, round hills);
    the rest is plain noise. `amplitude_m`: of layers that make z (0 for the others). `shape`: weights of layers in s.
    """

    params: TerrainParams
    layers: int
    wavelength_m: Floats
    amplitude_m: Floats
    ridge: Floats
    shape: Floats
    unwarped: Lattice
    warped: Lattice
    warp_m: Floats
    sums: Floats  # (3, layers): weights of the layers in a and b (of s) and in z
    ridge_column: Floats  # of the ridged layers
    constants: TerrainConstants
    craters: Craters | None = None
    real_rough: tuple[float, ...] | None = None  # multipliers likewise, of the levels of real ground
    map_roughness: float = 0.0  # multiplier of the layers by the map's height differences at its finest scale, 1/m

    @property
    def map_sample_m(self) -> float:
        """Distance of the height map's samples."""
        found = self.params.height_map
        return found.sample_rad * self.params.radius_m if found else 0.0

    @property
    def finest_m(self) -> float:
        """Over what distance a height map, or the finest tiles of elevation, bend; 0 without any."""
        real = self.params.real
        if real is None:
            return self.map_sample_m
        sample_m = real.finest_m(self.params.radius_m)
        return sample_m if self.real_rough is None else min(sample_m, 0.5 * float(self.wavelength_m[-1]))

    @property
    def gullied(self) -> bool:
        """Whether any of its relief follows the slope."""
        return self.params.erosion > 0.0 and self.layers > FIRST_GULLY

    @property
    def relief_slope(self) -> float:
        """Three standard deviations of the slope of z; a ridged layer is RIDGE_SLOPE times as steep as its noise."""
        steep = self.amplitude_m / self.wavelength_m * _NOISE_SLOPE * (1.0 + (RIDGE_SLOPE - 1.0) * np.abs(self.ridge))
        return 3.0 * float(np.sqrt((steep**2).sum()))

    @property
    def range_slope(self) -> float:
        """About the largest slope of ranges where M is 1."""
        return self.constants.range_m * self.shape_slope

    @property
    def slopes_by_x(self) -> tuple[float, float]:
        """About the largest slopes of x (1/m): of continents, and of the coasts that ranges bend."""
        k = self.constants
        steep = _CONTINENT_WEIGHTS * self.warped.frequency[:FIELDS] * _NOISE_SLOPE
        return 4.0 * float(np.sqrt((steep**2).sum())) * k.inverse_deviation, k.coast * self.shape_slope

    @property
    def hill_slope(self) -> float:
        """About the largest slope of hills."""
        return 0.3 * self.constants.hill_m * self.shape_slope

    def broad_slope(self, by_x_m: Floats) -> Floats:
        """About the largest slope of continents and hills where heights change by `by_x_m` metres a unit of x."""
        return by_x_m * sum(self.slopes_by_x) + self.hill_slope

    @property
    def steepest(self) -> float:
        """The largest of heights_slopes' bounds, about."""
        k = self.constants
        steepest_m = k.plains * (4.0 * k.slope_m + 6.0 * k.coast_m) + (1.0 - k.plains) * 0.6 * k.spread_m
        added = self.craters.slope if self.craters else 0.0
        if self.params.height_map:
            added += float(self.params.height_map.slopes(self.params.radius_m).max())
        if self.params.real:
            added += self.params.real.steepest(self.params.radius_m)
        return float(self.broad_slope(np.asarray(steepest_m))) + 1.25 * self.relief_slope + self.range_slope + added

    @property
    def shape_slope(self) -> float:
        """About the largest slope of m, by which ranges rise from 0 to 1 (1/m)."""
        k = self.constants
        return 1.5 * k.shape_inverse * RIDGE_SLOPE * _NOISE_SLOPE * float((self.shape / self.wavelength_m).sum())

    @property
    def warped_layers(self) -> int:
        return min(self.layers, WARPED_LAYERS)


def layer_slope(wavelength_m: Floats) -> Floats:
    """Amplitude over wavelength of a layer of natural relief, by its wavelength in metres.

    Steepest near 5 km, the width of mountains and valleys, rising again to 0.19 at the ground's own
    roughness; ranges broader than 16 km come from the shape layers.
    """
    log = np.log2(wavelength_m / 5000.0)
    return 0.22 / (1.0 + np.sqrt(wavelength_m / 150.0)) + 0.095 * np.exp(-(log**2) / 6.0)


def build_model(params: TerrainParams) -> Model:
    """Octaves and constants of `params`; the sea's level is still to be found (height_octaves.model_of does)."""
    p, scale = params, params.scale
    offsets = np.array([octave_offset(p.seed, k) for k in range(2 + FIELDS + p.layers)])
    size = 2.0 ** round(np.log2(p.continent_size))
    wavelength: Floats = np.asarray(_FIRST_LAYER_M * scale * 0.5 ** np.arange(p.layers), dtype=np.float64)
    warped_layers = min(p.layers, WARPED_LAYERS)

    ridge = np.zeros(p.layers)
    ridge[:WARPED_LAYERS] = 1.0
    ridge[WARPED_LAYERS : WARPED_LAYERS + 2] = (-0.5, -0.25)[: max(p.layers - WARPED_LAYERS, 0)]
    amplitude = _single(layer_slope(wavelength) * wavelength * p.roughness)
    amplitude[:SHAPE_LAYERS] = 0.0
    map_roughness = 0.0
    if p.height_map is not None:
        sample_m = p.height_map.sample_rad * p.radius_m
        whole = layer_slope(wavelength) * wavelength * p.roughness
        map_roughness = p.height_map_detail * roughness_factor(whole, wavelength, sample_m)
        # Layers as long as what the map shows stay only as far as the procedural shapes do; shorter ones go on from it,
        # those that make the ranges elsewhere as well.
        longer = np.clip((wavelength / sample_m - 2.0) / 2.0, 0.0, 1.0)
        blend = p.height_map_blend
        amplitude = _single(blend * amplitude + (1.0 - blend) * (1.0 - longer) * whole)
    shape = np.zeros(p.layers)
    shape[:SHAPE_LAYERS] = _SHAPE_WEIGHTS[: p.layers]
    first = np.arange(p.layers) < GATING_LAYERS

    fields = _FIELD_WAVELENGTHS_M * scale * size
    warp_wavelengths = _WARP_WAVELENGTHS_M * scale * np.array([size, 1.0])
    layer_offsets = offsets[2 + FIELDS :]
    return Model(
        params=p,
        layers=p.layers,
        wavelength_m=wavelength,
        amplitude_m=amplitude,
        ridge=ridge,
        shape=shape,
        unwarped=Lattice.of(
            np.concatenate([warp_wavelengths, wavelength[warped_layers:]]),
            np.concatenate([offsets[:2], layer_offsets[warped_layers:]]),
        ),
        warped=Lattice.of(
            np.concatenate([fields, wavelength[:warped_layers]]),
            np.concatenate([offsets[2 : 2 + FIELDS], layer_offsets[:warped_layers]]),
        ),
        sums=np.stack([np.where(first, shape, 0.0), np.where(first, 0.0, shape), amplitude]),
        ridge_column=ridge[ridge != 0.0][:, None],
        warp_m=_single(_WARP_AMPLITUDES_M * scale * np.array([size, 1.0]) * p.warp),
        constants=_constants(p),
        craters=craters_of(p.craters, p.crater_largest_m, float(wavelength[-1]), p.radius_m, p.seed),
        map_roughness=float(np.float32(map_roughness)),
        real_rough=_real_rough(p, wavelength, amplitude),
    )


def _real_rough(p: TerrainParams, wavelength_m: Floats, amplitude_m: Floats) -> tuple[float, ...] | None:
    """Multipliers of the layers that no warp bends, by the height differences of each level's samples, 1/m."""
    if p.real is None or p.height_map_detail <= 0.0 or p.layers <= WARPED_LAYERS:
        return None
    fine = slice(WARPED_LAYERS, None)
    return tuple(
        float(np.float32(p.height_map_detail * roughness_factor(amplitude_m[fine], wavelength_m[fine], sample_m)))
        for sample_m in (level.lattice.sample_m(p.radius_m) for level in p.real.levels)
    )


def continent_weights() -> tuple[Floats, Floats]:
    """Weights of the FIELDS octaves in c and in b."""
    return _CONTINENT_WEIGHTS, _BELT_WEIGHTS


def _constants(p: TerrainParams) -> TerrainConstants:
    lowest_m, highest_m = p.shaped_m
    high, low = max(highest_m, 0.0), max(-lowest_m, 0.0)
    span = highest_m - lowest_m
    # Ranges, hills and bent coasts never get steeper than on Earth, however narrow the layers of a small body.
    reach_m = _FIRST_LAYER_M * p.scale
    range_m = min(0.54 * high, 0.04 * reach_m) if p.mountains > 0.0 else 0.0
    plains = p.plains if lowest_m < 0.0 < highest_m else 0.0  # seas and shelves need a height 0 to be at
    spread_m = 0.4 * span
    steepest_m = plains * 1.5 / 0.6 * 0.38 * low + (1.0 - plains) * 0.6 * spread_m  # metres by x
    knee = 0.15 * span * 0.5
    knee_high, knee_low = knee, knee
    if p.height_map is not None:  # which is to stay as it is
        knee_high = min(knee, 0.5 * (highest_m - p.height_map.highest_m))
        knee_low = min(knee, 0.5 * (p.height_map.lowest_m - lowest_m))
    found = TerrainConstants(
        sea_level=0.0,
        inverse_deviation=1.0,
        coast=min(0.13, 0.0085 * reach_m / max(steepest_m, 1e-9)),
        inverse_belt=1.0 / (0.09 * max(p.mountains, 1e-3)),
        mountains=p.hills if p.mountains > 0.0 else 0.0,
        coast_m=0.017 * high,
        lowland_m=0.0245 * high,
        slope_m=0.38 * low,
        abyss_m=0.15 * low,
        plateau_m=0.055 * high,
        middle_m=0.5 * (highest_m + lowest_m),
        spread_m=spread_m,
        plains=plains,
        foot_m=0.2 * range_m,
        range_m=range_m,
        hill_m=min(0.1 * high, 0.007 * reach_m) * min(p.roughness, 1.0),
        shape_low=0.50,
        shape_inverse=1.0 / 1.5,
        gentle=0.2 - 0.14 * p.hills,
        hills=0.22 * p.hills,
        calm=0.12,
        wild=0.95,
        knee_high_m=highest_m - knee_high,
        knee_low_m=lowest_m + knee_low,
        room_high_m=knee_high,
        room_low_m=knee_low,
    )
    if p.height_map is None:
        return found
    return replace(found, **{name: p.height_map_blend * getattr(found, name) for name in _BROAD})


_BROAD = (
    *("coast_m", "lowland_m", "slope_m", "abyss_m", "plateau_m", "middle_m", "spread_m", "foot_m", "range_m"),
    *("hill_m", "gentle", "hills", "calm", "wild"),
)
"""Constants of what a height map stands in for."""
