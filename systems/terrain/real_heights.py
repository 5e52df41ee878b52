"""Elevation from tiles in place of the procedural ground, in numpy: of heights, of bounds on slopes, and of gradients.

The ground around shows by what the tiles leave of it: all of it outside, nothing inside, both over a margin. Where
nothing of it shows it is not evaluated.

Below the samples relief goes on, on steep ground as gullies (gullies.py) that follow the slope of the samples.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...engine.real_ground.real_ground import Relief
from ...engine.surface.noise import Corners, Lattice
from .gullies import END_BELOW_SAMPLES, GullyLayers, gully_layers
from .height_model import WARPED_LAYERS, Model, TerrainConstants
from .height_steps import layer_weight, ridge, ridge_slope

__all__ = ["below_samples", "margin_slopes", "real_gradients", "real_heights", "real_slopes", "unlimited"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def real_heights(points: Floats, model: Model, around: Callable[[Floats, Model], Floats]) -> Floats:
    """Heights (N,) at points (3, N). around: those of the procedural ground."""
    real = model.params.real
    if real is None:
        return around(points, model)
    height, rest = below_samples(points, model)[:2]
    at = np.flatnonzero(rest > 0.0)
    if at.size:
        height[at] += rest[at] * around(points[:, at], model)
    return height


def below_samples(points: Floats, model: Model) -> tuple[Floats, Floats, Floats]:
    """Metres (N,) of real ground at points (3, N) with the relief below its samples, the rest (N,) of the ground
    around, and the roughness (N,) of that relief."""
    real = model.params.real
    assert real is not None
    height, rest, relief = real.compose(points, model.real_rough, model.params.radius_m, follow=_follows(model))
    if relief is None:
        return height, rest, np.zeros(len(rest))
    at = np.flatnonzero(relief.rough > 0.0)
    if at.size:
        cells, amplitude_m = _fine(model).cells(points[:, at]), _whole(model, relief.sample_m[at])
        layers = ridge(cells.noise(), model.ridge[WARPED_LAYERS:, None])
        if (found := _gullies(points, model, relief, at, cells, amplitude_m, False)) is not None:
            own = slice(0, len(found.share))
            layers[own] += found.share * (found.wave - layers[own])
        height[at] += relief.rough[at] * (amplitude_m * layers).sum(axis=0)
    return height, rest, relief.rough


def _follows(model: Model) -> bool:
    return model.params.erosion > 0.0 and model.real_rough is not None


def _gullies(
    points: Floats, model: Model, relief: Relief, at: Ints, cells: Corners, amplitude_m: Floats, slopes: bool
) -> GullyLayers | None:
    """Of places points[:, at] (3, M). cells: of the layers that no warp bends; amplitude_m (layers, M) of them."""
    if relief.falls is None:
        return None
    end = min(END_BELOW_SAMPLES, model.layers) - WARPED_LAYERS
    frequency = 1.0 / model.wavelength_m[WARPED_LAYERS : WARPED_LAYERS + end]
    d_falls = relief.d_falls[:, :, at] if slopes and relief.d_falls is not None else None
    up = points[:, at] * (1.0 / model.params.radius_m)
    falls, rough, strength = relief.falls[:, at], relief.rough[at], model.params.erosion
    return gully_layers(
        lambda k: cells.part(slice(k, k + 1)), frequency, amplitude_m[:end], falls, up, rough, strength, d_falls
    )


def _fine(model: Model) -> Lattice:
    """The layers that no warp bends."""
    return Lattice(model.unwarped.frequency[2:], model.unwarped.offset[2:])


def _whole(model: Model, sample_m: Floats) -> Floats:
    """Metres (layers, N) that layers have below samples sample_m (N,) apart."""
    wavelength_m = model.wavelength_m[WARPED_LAYERS:, None]
    longer = np.clip((wavelength_m / sample_m - 2.0) / 2.0, 0.0, 1.0)
    return (1.0 - longer) * model.amplitude_m[WARPED_LAYERS:, None]


def real_slopes(
    points: Floats, model: Model, around: Callable[[Floats, Model], tuple[Floats, Floats]]
) -> tuple[Floats, Floats]:
    """Heights (N,) and slopes (N,) that the ground hardly ever exceeds. around: those of the procedural ground."""
    real = model.params.real
    if real is None:
        return around(points, model)
    height, rest, rough = below_samples(points, model)
    slope = real.slopes(points, model.params.radius_m) + model.relief_slope * rough
    at = np.flatnonzero(rest > 0.0)
    if at.size:
        there, steep = around(points[:, at], model)
        height[at] += rest[at] * there
        slope[at] += rest[at] * steep + margin_slopes(points, model, at, there)
    return height, slope


def margin_slopes(points: Floats, model: Model, at: NDArray[np.int64], around_m: Floats) -> Floats:
    """What passing from real ground to the one around, around_m (M,) high, makes of slopes (M,) at points[:, at]."""
    real = model.params.real
    out = np.zeros(len(at))
    if real is None:
        return out
    _, rest = real.heights(points[:, at])
    faded = np.flatnonzero(rest < 1.0)
    if faded.size:
        found = real.gradients(points[:, at[faded]], model.params.radius_m, None)
        total = found.d_height + found.d_rest * around_m[faded]
        out[faded] = 2.0 * np.linalg.norm(total, axis=0)
    return out


def unlimited(k: TerrainConstants, h: Floats) -> Floats:
    """The height (N,) whose limit is h (N,)."""
    over, under = np.maximum(h - k.knee_high_m, 0.0), np.maximum(k.knee_low_m - h, 0.0)
    more = over * over / np.maximum(k.room_high_m - over, 1e-9) if k.room_high_m > 0.0 else 0.0
    less = under * under / np.maximum(k.room_low_m - under, 1e-9) if k.room_low_m > 0.0 else 0.0
    return h + more - less


def real_gradients(
    points: Floats,
    model: Model,
    footprint_m: Floats | None,
    around: Callable[[Floats, Model, Floats | None], tuple[Floats, Floats]],
) -> tuple[Floats, Floats]:
    """Heights (N,) and gradients (3, N) as the footprint (N,) shows them. around: those of the procedural ground."""
    real = model.params.real
    if real is None:
        return around(points, model, footprint_m)
    found = real.gradients(points, model.params.radius_m, footprint_m, model.real_rough, _follows(model))
    height, gradient, relief = found.height_m, found.d_height, found.relief
    near = np.flatnonzero(relief.rough > 0.0)
    if near.size:
        cells, whole = _fine(model).cells(points[:, near]), _whole(model, relief.sample_m[near])
        noise, slope = cells.noise_derivative()
        slope = slope * model.unwarped.frequency[2:, None]
        ridged = model.ridge[WARPED_LAYERS:, None]
        shown = np.ones_like(whole)
        if footprint_m is not None:
            shown = layer_weight(model.wavelength_m[WARPED_LAYERS:, None], np.maximum(footprint_m[near], 1e-9))
        layers, slope = ridge(noise, ridged), slope * ridge_slope(noise, ridged)
        gullies = _gullies(points, model, relief, near, cells, whole, True)
        if gullies is not None and gullies.d_share is not None and gullies.d_wave is not None:
            own, over = slice(0, len(gullies.share)), gullies.wave - layers[: len(gullies.share)]
            slope[:, own] *= 1.0 - gullies.share
            slope[:, own] += gullies.share * gullies.d_wave + gullies.d_share * over
            layers[own] += gullies.share * over
        metres = whole * layers
        rough = relief.rough[near]
        height[near] += rough * metres.sum(axis=0)
        gradient[:, near] += rough * (slope * (whole * shown)).sum(axis=1)
        gradient[:, near] += (metres * shown).sum(axis=0) * relief.d_rough[:, near]
    at = np.flatnonzero((found.rest > 0.0) | (found.seen_rest > 0.0))
    if at.size:
        there, slope = around(points[:, at], model, None if footprint_m is None else footprint_m[at])
        height[at] += found.rest[at] * there
        gradient[:, at] += found.seen_rest[at] * slope + found.d_rest[:, at] * there
    return height, gradient
