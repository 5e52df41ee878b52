"""The height function's noises on ground with gullies (`TerrainParams.erosion`): as height_octaves has them, but some
layers of relief follow the slope of those before, so heights need slopes, and gradients how these turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Kernels
from ...engine.surface.noise import Corners, Scratch
from .gullies import END_GULLY, FALLING_LAYERS, FIRST_GULLY, GullyLayers, crest_slopes, gully_layers
from .height_added import added_gradients, added_heights
from .height_model import FIELDS, WARPED_LAYERS, Model, continent_weights
from .height_steps import layer_weight, ridge, ridge_slope
from .height_surface import (
    carve_slopes,
    falling_slopes,
    hypsometry_slope,
    side_rough,
    side_rough_slopes,
    surface_slopes,
)
from .rivers.valleys import Valleys, shown_slopes, valleys

__all__ = ["eroded_gradients", "eroded_noises"]

Floats = NDArray[np.float64]

_COMPILED = Kernels(__package__, "eroded_kernels")

_WEIGHTS = np.stack(continent_weights())
_SCRATCH, _WARPED_SCRATCH = Scratch(), Scratch()
_DOWN = slice(FIELDS, FIELDS + FALLING_LAYERS)
LEAST_CUT = 1e-6
"""Of a height's share: less than that is none."""


@dataclass(frozen=True)
class _Octaves:
    """What the noises are at N places."""

    unwarped: Corners
    warped: Corners
    w: Floats
    """(3, 2, N) warps"""
    jacobian: Floats | None
    """(3, 3, 2, N) of them by the lattice coordinate"""
    noise: Floats
    """(FIELDS + layers, N)"""
    slope: Floats
    """(3, FIELDS + layers, N) by metre, where it was asked for, else (3, FALLING_LAYERS, N)"""


def eroded_noises(points: Floats, model: Model) -> tuple[Any, Floats, Floats, Valleys | None, tuple[Any, Any]]:
    """At points (3, N): height without the relief, roughness, 0..1 where ranges stand, and metres that heights change
    by a unit of x, four of (N,); z (N,); what of it is gullies (N,); valleys of rivers; and `added_heights`."""
    cut = None if model.params.rivers is None else valleys(model.params.rivers, points, "open")
    added = added_heights(points, model)
    if (compiled := _COMPILED()) is not None:
        parts, z, furrows = compiled.eroded(points, model, added, cut)
        return tuple(parts), z, furrows, cut, added
    octaves = _octaves(points, model, False)
    v, found, (*parts, x) = _layers(points, model, octaves, added, cut, None)
    furrows = model.amplitude_m[_own(found)] @ (found.share * found.wave)
    return (*parts, hypsometry_slope(model.constants, x)), model.sums[2] @ v, furrows, cut, added


def eroded_gradients(points: Floats, model: Model, footprint_m: Floats | None) -> tuple[Floats, Floats]:
    """Heights (N,) and 3D gradients (3, N) at points (3, N), band-limited to the footprint (N,)."""
    octaves = _octaves(points, model, True)
    metres, d_added, rougher, d_rougher = added_gradients(points, model, footprint_m)
    cut = None if model.params.rivers is None else valleys(model.params.rivers, points, "all")
    assert octaves.jacobian is not None
    jacobian = octaves.jacobian * model.unwarped.frequency[:2, None]
    bent_near = jacobian[:, :, 1] * model.warp_m[1]
    for axis in range(3):
        bent_near[axis, axis] += 1.0
    v, found, _ = _layers(points, model, octaves, (metres, rougher), cut, bent_near)
    assert found.d_share is not None and found.d_wave is not None
    bent_far = bent_near + jacobian[:, :, 0] * model.warp_m[0]
    dc, db = (np.einsum("f,afn,abn->bn", w, octaves.slope[:, :FIELDS], bent_far) for w in _WEIGHTS)

    own = _own(found)
    plain = octaves.noise[FIELDS:][own].copy()
    ridged = model.ridge[own, None]
    d_layers = octaves.slope[:, FIELDS:] * ridge_slope(octaves.noise[FIELDS:], model.ridge[:, None])
    d_layers[:, own] *= 1.0 - found.share
    layers = model.warped_layers
    d_layers[:, :layers] = np.einsum("akn,abn->bkn", d_layers[:, :layers], bent_near)
    # Waves are functions of the place itself, whatever lattice their cells are of.
    d_layers[:, own] += found.share * found.d_wave + found.d_share * (found.wave - ridge(plain, ridged))
    shown = np.ones((model.layers, points.shape[1]))
    if footprint_m is not None:
        shown = layer_weight(model.wavelength_m[:, None], np.maximum(footprint_m, 1e-9)[None])
    d_sums = np.einsum("sk,akn->san", model.sums, d_layers * shown)
    w1, sums = octaves.w[:, 0], model.sums @ v
    c, b = _WEIGHTS @ octaves.noise[:FIELDS]
    seen = model.amplitude_m @ (shown * v)
    height, *by, _ = surface_slopes(model.constants, *w1, c, b, *sums, metres, rougher, seen)
    total = np.zeros_like(dc)
    for slope, change in zip(by, (*jacobian[:, :, 0], dc, db, *d_sums, d_added, d_rougher), strict=True):
        total = total + slope * change
    if cut is None:
        return height, total
    carved, *by = carve_slopes(height, cut.base_m, cut.open, cut.raised)
    rough, *by_side = side_rough_slopes(height, cut.base_m, cut.open)
    amplitude_m = model.amplitude_m[own]
    furrows, seen = (amplitude_m @ (w * found.share * found.wave) for w in (1.0, shown[own]))
    d_furrows = np.einsum(
        "k,akn->an", amplitude_m, shown[own] * (found.share * found.d_wave + found.d_share * found.wave)
    )
    by = [a + seen * b for a, b in zip(by, (*by_side, 0.0), strict=True)]
    total = by[0] * total + rough * d_furrows
    for slope, change in zip(by[1:], shown_slopes(cut, footprint_m), strict=True):
        total = total + slope * change
    return carved + rough * furrows, total


def _own(found: GullyLayers) -> slice:
    return slice(FIRST_GULLY, FIRST_GULLY + len(found.share))


def _octaves(points: Floats, model: Model, slopes: bool) -> _Octaves:
    unwarped = model.unwarped.cells(points, _SCRATCH)
    warps = unwarped.part(slice(0, 2))
    w, jacobian = warps.vector_derivative() if slopes else (warps.vector(), None)
    near = points + w[:, 1] * model.warp_m[1]
    far = near + w[:, 0] * model.warp_m[0]
    layers = model.warped_layers
    where = _WARPED_SCRATCH.array("where", (3, len(model.warped), points.shape[1]))
    where[:, :FIELDS] = far[:, None]
    where[:, FIELDS:] = near[:, None]
    warped = model.warped.cells(where, _WARPED_SCRATCH)
    fine = unwarped.part(slice(2, None))
    end = FIELDS + layers
    noise = np.empty((FIELDS + model.layers, points.shape[1]))
    slope = np.empty((3, *noise.shape)) if slopes else np.empty((3, FALLING_LAYERS, points.shape[1]))
    if slopes:
        noise[:end], slope[:, :end] = warped.noise_derivative()
        if model.layers > layers:
            noise[end:], slope[:, end:] = fine.noise_derivative()
        slope[:, :end] *= model.warped.frequency[:, None]
        slope[:, end:] *= model.unwarped.frequency[2:, None]
    else:
        noise[:FIELDS] = warped.part(slice(0, FIELDS)).noise()
        noise[_DOWN], slope[...] = warped.part(_DOWN).noise_derivative()
        slope *= model.warped.frequency[_DOWN, None]
        noise[_DOWN.stop : end] = warped.part(slice(_DOWN.stop, None)).noise()
        if model.layers > layers:
            noise[end:] = fine.noise()
    return _Octaves(unwarped, warped, w, jacobian, noise, slope)


def _layers(
    points: Floats, model: Model, octaves: _Octaves, added: tuple[Any, Any], cut: Valleys | None, bent: Floats | None
) -> tuple[Floats, GullyLayers, Any]:
    """The layers' values (layers, N), the gullies among them, and what `surface_parts` gives. bent (3, 3, N): how the
    narrow warp moves places, for derivatives."""
    v = octaves.noise[FIELDS:].copy()
    ridged = len(model.ridge_column)
    v[:ridged] = ridge(v[:ridged], model.ridge_column)
    found, parts = _gullies(points, model, octaves, v, added, cut, bent)
    own = _own(found)
    v[own] += found.share * (found.wave - v[own])
    return v, found, parts


def _gullies(
    points: Floats,
    model: Model,
    octaves: _Octaves,
    v: Floats,
    added: tuple[Any, Any],
    cut: Valleys | None,
    bent: Floats | None,
) -> tuple[GullyLayers, Any]:
    """And what `surface_parts` gives, which no gully changes. Which way is down is said by ranges, the longest relief
    and valleys of rivers, as if the narrow warp bent nothing."""
    k, w1, first = model.constants, octaves.w[:, 0], slice(0, FALLING_LAYERS)
    c, b = _WEIGHTS @ octaves.noise[:FIELDS]
    sums = model.sums[:, first]
    sa, sb, z = sums @ v[first]
    height, *by, base, rough, on_land, x = falling_slopes(k, *w1, c, b, sa, sb, z, *added)
    parts, by_sums, rough = (base, rough, on_land, x), np.stack(by), by[2]
    weights = np.einsum("sk,sn->kn", sums, by_sums)
    crest, bend = crest_slopes(octaves.noise[_DOWN], model.ridge[first, None])
    gradient = octaves.slope[:, _DOWN] if octaves.slope.shape[1] > FALLING_LAYERS else octaves.slope
    falls = uncarved = np.einsum("kn,akn->an", weights * crest, gradient)
    open_m: Any = 0.0
    if cut is not None:
        _, by_h, _, open_m, _ = carve_slopes(height, cut.base_m, cut.open, cut.raised)
        weights, rough = by_h * weights, by_h * rough + side_rough(height, cut.base_m, cut.open)
        falls = by_h * uncarved + open_m * cut.d_open
    d_falls = None
    if bent is not None:
        frequency = model.warped.frequency[_DOWN]
        second = octaves.warped.part(_DOWN).noise_hessian() * (frequency * frequency)[:, None]
        d_falls = np.einsum("kn,akn,bkn->abn", weights * bend, gradient, gradient)
        d_falls += np.einsum("kn,abkn->abn", weights * crest, second)
        d_falls = np.einsum("acn,cbn->abn", d_falls, bent)
        if cut is not None and cut.d_open is not None and cut.d_base is not None:
            # A valley's side is a parabola: open'' = -open'^2 / (2 (1 - open)).
            bow = (0.5 * open_m / np.maximum(1.0 - cut.open, LEAST_CUT)) * cut.d_open
            over = (open_m > 0.0) * (uncarved - cut.d_base) - bow
            d_falls += np.einsum("an,bn->abn", uncarved, cut.d_open) + np.einsum("an,bn->abn", cut.d_open, over)
    end = min(END_GULLY, model.layers)

    def corners(number: int) -> Corners:
        layer = FIRST_GULLY + number
        if layer < WARPED_LAYERS:
            return octaves.warped.part(slice(FIELDS + layer, FIELDS + layer + 1))
        return octaves.unwarped.part(slice(2 + layer - WARPED_LAYERS, 3 + layer - WARPED_LAYERS))

    frequency, amplitude_m = 1.0 / model.wavelength_m[FIRST_GULLY:end], model.amplitude_m[FIRST_GULLY:end]
    up = points * (1.0 / model.params.radius_m)
    found = gully_layers(corners, frequency, amplitude_m, falls, up, rough, model.params.erosion, d_falls, bent)
    return found, parts
