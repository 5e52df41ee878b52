"""The ground along rays, float64: as many layers of relief as a stretch's length asks for, and what it may do between.

Over a stretch of length D between two places whose heights are known, ground stays below the straight line between them
plus

    E(D) = sum of slope min(D / 2, D^2 / width) + rough e(D) + craters(D) + D^2 / (8 r)

Rivers and gullies: all layers are looked at where some are gullies, since these follow the longer ones. What valleys
add is in ray_valleys.py.

The sum is over continents, ranges and map: slope: how steep each gets about the two ends; width: over how much of the
way it bends. rough: multiplier of the relief layers; e(D): of these together, four standard deviations, where layers
shorter than 2 D count as a whole, so that they need not be looked at. craters: those that reach the stretch one by one,
narrower ones as a whole (crater_paths.py). The last term is the planet's curve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Kernels
from ...engine.surface.noise import Lattice
from .crater_paths import rest_m
from .height_added import MOST_ROUGH
from .height_map import map_values, slopes_at
from .height_model import FIELDS, SHAPE_LAYERS, WARPED_LAYERS, Model
from .height_octaves import BLOCK, broad_parts, ridge_layers
from .height_params import forget_with_tiles
from .height_steps import RIDGE_ROUND, RIDGE_SLOPE, RIDGE_TOP
from .height_surface import limit
from .real_heights import below_samples, margin_slopes, unlimited
from .rivers.steepness import Steepness, steepness

__all__ = ["Detail", "Kind", "detail_of", "ground_at", "kinds", "layers_at"]

Floats = NDArray[np.float64]

_COMPILED = Kernels(__package__, "height_kernels")

_NOISE_RMS, _NOISE_SLOPE = 0.27, 0.86
"""Of one octave of gradient noise; its slope by the lattice coordinate."""
_RIDGE_MEAN = RIDGE_TOP - RIDGE_SLOPE * 0.215
_RIDGE_RMS = 0.31
"""Of a ridged layer: 0.215 is the mean of |noise|."""
_SIGMAS = 4.0
_KEPT = 2.0
"""Layers at least so many times as long as a stretch are looked at: shorter ones would differ from the line between its
ends by more than they do from their mean."""


class Kind(IntEnum):
    """What ground is like: roughness, and the largest slopes of its parts."""

    ROUGH = 0
    CONTINENTS = 1
    RANGES = 2
    MAP = 3


@dataclass(frozen=True, eq=False)
class Detail:
    """What is looked at along stretches of up to `length_m`, and how far ground may go beyond that."""

    length_m: float
    model: Model
    """Of the first `layers` layers alone."""
    whole_model: Model
    layers: int
    octaves: int
    """Of craters."""
    mean_m: float
    """Of the layers that are left out, by roughness."""
    rest_m: float
    """Four standard deviations of them, by roughness."""
    craters_up_m: float
    craters_down_m: float
    whole: bool
    """Nothing is left out."""
    relief_m: Floats
    """(2,): e over length_m / 2 and length_m."""
    steepness: tuple[float, float, float, float]
    """Slopes of continents and coasts by what heights change by x, of hills, and of ranges where all is range."""
    broad_m: tuple[tuple[float, float], ...]
    """(width, most) for each kind but the first: ground of this kind with slope s rises above the line between two
    places by s times the least of D / 2, D^2 / width and most."""

    def rise(self, length_m: Floats, kind: Floats) -> Floats:
        """E (N,) over lengths (N,) between length_m / 2 and length_m, for ground of `kind`, without the craters that
        are looked at, and as if there were no valleys."""
        d = length_m
        part = np.clip(d * (2.0 / self.length_m) - 1.0, 0.0, 1.0)
        relief = self.relief_m[0] + part * (self.relief_m[1] - self.relief_m[0])
        rise = kind[Kind.ROUGH] * relief
        for steep, (width, most) in zip(kind[Kind.CONTINENTS : len(Kind)], self.broad_m, strict=True):
            rise += steep * np.minimum(d * np.minimum(0.5, d * (1.0 / width)), most)
        rise += d * d * (0.125 / self.model.params.radius_m)
        rise += self.craters_up_m
        return rise


@lru_cache(maxsize=256)
def _detail(model: _Same, length_m: float) -> Detail:
    whole = model.model
    wavelength, share = whole.wavelength_m, np.abs(whole.ridge)
    layers = max(int(np.count_nonzero(wavelength >= _KEPT * length_m)), min(WARPED_LAYERS, whole.layers))
    if whole.gullied:
        layers = whole.layers
    octaves, up, down = 0, 0.0, 0.0
    if whole.craters:
        octaves = int(np.count_nonzero(1.0 / whole.craters.frequency >= length_m))
        up, down = rest_m(whole.craters, octaves)
    amplitude = whole.amplitude_m
    left = slice(layers, None)
    still = amplitude * ((1.0 - share) * _NOISE_RMS + share * _RIDGE_RMS)
    relief = []
    for d in (0.5 * length_m, length_m):
        by_wave = d / wavelength
        plain = _NOISE_RMS * np.minimum(1.5, 0.25 * (_NOISE_SLOPE / _NOISE_RMS * by_wave) ** 2)
        # A crest is a kink, rounded off over RIDGE_ROUND.
        round_off = RIDGE_SLOPE / RIDGE_ROUND * (_NOISE_SLOPE * by_wave) ** 2 / 8.0
        kink = np.minimum(np.minimum(0.55, 0.5 * RIDGE_SLOPE * _NOISE_SLOPE * by_wave), round_off)
        each = amplitude * ((1.0 - share) * plain + share * kink)
        relief.append(_SIGMAS * np.sqrt((each[:layers] ** 2).sum() + (still[left] ** 2).sum()))
    continents, coasts = whole.slopes_by_x
    shortest = 1.0 / float(whole.warped.frequency[:FIELDS].max())
    fine = slice(0, 2 + max(layers - WARPED_LAYERS, 0))
    part = replace(
        whole,
        layers=layers,
        wavelength_m=wavelength[:layers],
        amplitude_m=amplitude[:layers],
        ridge=whole.ridge[:layers],
        shape=whole.shape[:layers],
        unwarped=Lattice(whole.unwarped.frequency[fine], whole.unwarped.offset[fine]),
        sums=np.ascontiguousarray(whole.sums[:, :layers]),
        ridge_column=whole.ridge_column[:layers],
    )
    return Detail(
        length_m,
        part,
        whole,
        layers,
        octaves,
        float((amplitude * whole.ridge * _RIDGE_MEAN)[left].sum()),
        _SIGMAS * float(np.sqrt((still[left] ** 2).sum())),
        up,
        down,
        layers == whole.layers and (whole.craters is None or octaves == len(whole.craters)),
        np.array(relief),
        (continents, coasts, whole.hill_slope, whole.range_slope),
        (
            # Shelves and coasts bend within a part of the width of continents.
            (shortest / (np.pi * (1.0 + 2.0 * whole.constants.plains)), np.inf),
            (float(wavelength[min(SHAPE_LAYERS, whole.layers) - 1]) / np.pi, 2.0 / whole.shape_slope),
            (0.5 * max(whole.finest_m, 1e-3), np.inf),
        ),
    )


forget_with_tiles(_detail.cache_clear)


def kinds(model: Model) -> int:
    """Rows of what `ground_at` says the ground is like."""
    return len(Kind) + (0 if model.params.rivers is None else len(Steepness))


class _Same:
    """A model as a key: equal only to itself."""

    __slots__ = ("model",)

    def __init__(self, model: Model) -> None:
        self.model = model

    def __hash__(self) -> int:
        return id(self.model)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.model is self.model


def detail_of(model: Model, length_m: float) -> Detail:
    """For stretches whose feet on the reference sphere are at most `length_m` apart."""
    return _detail(_Same(model), length_m)


def ground_at(feet: Floats, detail: Detail) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """At places (3, N) on the sphere: height (N,) of continents, ranges and map; the detail's layers of relief (N,), by
    roughness, and the gullies among them (N,); what the ground is like (4, N), see Kind, and with rivers ten
    rows more, see Steepness; and what rivers make of it (3,
    N): their own height, what is left above that, and filled below it."""
    parts = [_ground_at(feet[:, a : a + BLOCK], detail) for a in range(0, feet.shape[1], BLOCK)]
    if len(parts) == 1:
        return parts[0]
    base, z, furrows, kind, cut = (np.concatenate(p, axis=-1) for p in zip(*parts, strict=True))
    return base, z, furrows, kind, cut


def _ground_at(feet: Floats, detail: Detail) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    model = detail.model
    (base, rough, on_land, by_x), z, furrows, valleys = broad_parts(feet, model)
    continents, coasts, hills, ranges = detail.steepness
    kind = np.zeros((kinds(model), len(z)))
    kind[Kind.CONTINENTS] = continents * by_x
    kind[Kind.RANGES] = coasts * by_x + hills + ranges * on_land
    found, real = model.params.height_map, model.params.real
    if real is not None:
        base, rough, kind = _really(feet, detail, base, rough, z, kind)
    if found is not None:
        height, differences = map_values(found, feet)
        base = base + height
        rough = rough + np.minimum(model.map_roughness * differences, MOST_ROUGH)
        kind[Kind.MAP] = slopes_at(found, feet, model.params.radius_m)
    kind[Kind.ROUGH] = rough
    cut = np.zeros((3, len(z)))
    cut[1] = 1.0
    table = model.params.rivers
    if valleys is not None and table is not None:
        cut[:] = valleys.base_m, valleys.open, valleys.raised
        kind[len(Kind) :] = steepness(valleys, table)
    return base, z, np.broadcast_to(furrows, z.shape), kind, cut


def _really(
    feet: Floats, detail: Detail, base: Floats, rough: Floats, z: Floats, kind: Floats
) -> tuple[Floats, Floats, Floats]:
    """base, rough and kind with real ground in their place: limit(base + rough z) is then the ground's height."""
    model = detail.model
    real, k = model.params.real, model.constants
    assert real is not None
    whole = detail.whole_model
    height, rest, below = below_samples(feet, whole)
    at = np.flatnonzero(rest < 1.0)
    if not at.size:
        return base, rough, kind
    base, rough = base.copy(), rough.copy()
    around = limit(k, base[at] + rough[at] * z[at])
    kind[Kind.CONTINENTS : Kind.MAP, at] *= rest[at]
    kind[Kind.MAP, at] = real.slopes(feet[:, at], model.params.radius_m) + margin_slopes(feet, model, at, around)
    kind[Kind.MAP, at] += whole.relief_slope * below[at]
    rough[at] *= rest[at]
    base[at] = unlimited(k, height[at] + rest[at] * around) - rough[at] * z[at]
    return base, rough, kind


def layers_at(feet: Floats, before: Detail, now: Detail) -> Floats:
    """What the layers that `now` has and `before` lacks add to z (N,), at places (3, N) on the sphere."""
    model, first = now.model, before.layers
    at = slice(2 + first - WARPED_LAYERS, None)
    fine = Lattice(model.unwarped.frequency[at], model.unwarped.offset[at])
    share = model.ridge_column[first:]
    if (compiled := _COMPILED()) is not None:
        return compiled.layers(feet, fine.frequency, fine.offset, model.amplitude_m[first:], share[:, 0])
    total = np.empty(feet.shape[1])
    for start in range(0, len(total), BLOCK):
        n = fine.cells(feet[:, start : start + BLOCK]).noise()
        if len(share):
            n = ridge_layers(n, share)
        total[start : start + BLOCK] = model.amplitude_m[first:] @ n
    return total
