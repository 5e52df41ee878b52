"""Evaluates a model's octaves in numpy: noises of all octaves in two batches, then the point-wise surface."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Kernels
from ...engine.surface.noise import Scratch
from .height_added import added_gradients, added_heights
from .height_eroded import eroded_gradients, eroded_noises
from .height_map import map_values, slopes_at
from .height_model import FIELDS, SHAPE_LAYERS, Model, build_model, continent_weights
from .height_params import TerrainParams, forget_with_tiles
from .height_steps import layer_weight, ridge, ridge_slope
from .height_surface import (
    carve,
    carve_slopes,
    hypsometry_slope,
    limit,
    side_rough,
    surface,
    surface_parts,
    surface_slopes,
)
from .real_heights import real_gradients, real_heights, real_slopes
from .rivers.valleys import Valleys, shown_slopes, valleys

Floats = NDArray[np.float64]

BLOCK = 1000
"""Points evaluated at once: fewer leave numpy idle between calls, more leave the second-level cache."""

_SCRATCH = Scratch()
_COMPILED = Kernels(__package__, "height_kernels")


@lru_cache(maxsize=16)
def model_of(params: TerrainParams) -> Model:
    """Octaves and constants of `params` (about 20 ms, then cached): the sea's level is found by sampling."""
    return calibrate(build_model(params))


forget_with_tiles(model_of.cache_clear)


def heights(points: Floats, model: Model) -> Floats:
    return real_heights(points, model, _procedural)


def _procedural(points: Floats, model: Model) -> Floats:
    found, furrows, cut = _uncarved(points, model)
    if cut is None:
        return found
    return carved(found, cut.base_m, cut.open, cut.raised, furrows)


def carved(h: Floats, base: Floats, left: Floats, raised: Floats, furrows: Floats | float) -> Floats:
    """Heights h (N,) cut by rivers, with gullies on the sides of their valleys; furrows: as `broad_parts` has them."""
    found = carve(h, base, left, raised)
    return found + side_rough(h, base, left) * furrows


def _uncarved(points: Floats, model: Model) -> tuple[Floats, Floats | float, Valleys | None]:
    k, table = model.constants, model.params.rivers
    if model.gullied:
        (base, rough, _, _), z, furrows, cut, (added, rougher) = eroded_noises(points, model)
        return limit(k, base + (rough + rougher) * z + added), furrows, cut
    cut = None if table is None else valleys(table, points)
    added, rougher = added_heights(points, model)
    if (compiled := _COMPILED()) is not None:
        return compiled.heights(points, model, added, rougher), 0.0, cut
    w1, c, b, shapes, z = _noises(points, model)
    if 0 < points.shape[1] <= FEW_POINTS:  # plain floats are ten times faster than arrays of one
        parts = (*w1, c, b, *shapes, z, added, rougher)
        rows = [v.tolist() if isinstance(v, np.ndarray) else [v] * points.shape[1] for v in parts]
        return np.array([surface(k, *values) for values in zip(*rows, strict=True)]), 0.0, cut
    return surface(k, w1[0], w1[1], w1[2], c, b, shapes[0], shapes[1], z, added, rougher), 0.0, cut


def anchor_ground(
    point: Floats, w1: Floats, warped: Floats, model: Model
) -> tuple[Floats, Floats, float, float, float, Floats, float]:
    """(c, b), both parts of s, metres of z that ranges make, metres that wide craters and the map add, the map's share,
    metres of each octave of wide craters, and the height of a ground of just these, at a point (3,) with w1 (3,) and
    the noise of the warped octaves. The map's metres are those of the GPU's table, in float32."""
    fields = _FIELD_WEIGHTS @ warped[:FIELDS]
    ridges = warped[FIELDS : FIELDS + SHAPE_LAYERS, None].copy()
    *shapes, ranges_m = model.sums[:, : len(ridges)] @ ridge_layers(ridges, model.ridge_column[: len(ridges)])[:, 0]
    here, found, craters = point[:, None], model.params.height_map, model.craters
    craters_m = craters.octave_heights(here)[: craters.coarse, 0] if craters else np.zeros(0)
    map_m = float(np.float32(map_values(found, here)[0][0])) if found else 0.0
    added_m = float(craters_m.sum()) + map_m
    parts = np.array([*w1, *fields, *shapes, ranges_m, added_m]).tolist()
    ground_m = surface(model.constants, *parts)
    return fields, np.array(shapes), float(ranges_m), added_m, map_m, craters_m, ground_m


def heights_slopes(points: Floats, model: Model) -> tuple[Floats, Floats]:
    """Heights (N,) at points (3, N), and slopes (N,) that the ground about there hardly ever exceeds."""
    return real_slopes(points, model, _procedural_slopes)


def _procedural_slopes(points: Floats, model: Model) -> tuple[Floats, Floats]:
    """Heights (N,) at points (3, N), and slopes (N,) that the ground about there hardly ever exceeds.

    The bound is three standard deviations of the relief layers times the roughness there, and the largest slopes of
    ranges, continents, craters and map.
    """
    k = model.constants
    (base, rough, on_land, by_x), z, furrows, cut = broad_parts(points, model)
    added, rougher = added_heights(points, model)
    rough = rough + rougher
    slope = model.broad_slope(by_x) + model.range_slope * on_land + model.relief_slope * rough
    if model.craters:
        slope += model.craters.slope
    if model.params.height_map:
        slope += slopes_at(model.params.height_map, points, model.params.radius_m)
    height = limit(k, base + rough * z + added)
    table = model.params.rivers
    if table is None or cut is None:
        return height, slope
    there = (cut.open < 1.0) | (cut.raised > 0.0)
    if model.gullied:
        slope += model.relief_slope * side_rough(height, cut.base_m, cut.open)
    # The ground's own slope shrinks in a valley, and its height above the river turns into one.
    return carved(height, cut.base_m, cut.open, cut.raised, furrows), slope + there * (
        table.steepest_per_m * np.abs(height - cut.base_m) + STEEPEST_BANK
    )


STEEPEST_BANK = 0.6
"""Slope of river beds and banks that hardly any exceeds: twice the depth by half the width."""


def broad_parts(
    points: Floats, model: Model
) -> tuple[tuple[Floats, Floats, Floats, Floats], Floats, Floats | float, Valleys | None]:
    """Height without the relief, roughness, 0..1 where ranges stand, and metres that heights change by a unit of x,
    four of (N,), at points (3, N); z (N,); what of it is gullies (N,), and valleys of rivers."""
    k, table = model.constants, model.params.rivers
    if model.gullied:
        return eroded_noises(points, model)[:4]
    cut = None if table is None else valleys(table, points)
    if (compiled := _COMPILED()) is not None:
        parts, z = compiled.parts(points, model)
        return tuple(parts), z, 0.0, cut
    w1, c, b, shapes, z = _noises(points, model)
    *parts, x = surface_parts(k, w1[0], w1[1], w1[2], c, b, shapes[0], shapes[1])
    return (*parts, hypsometry_slope(k, x)), z, 0.0, cut


def widest_noise(points: Floats, model: Model) -> Floats:
    """w1 (3, N) at points (3, N): where belts, hills and moisture are."""
    return _noises(points, model)[0].copy()


def _noises(points: Floats, model: Model) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    corners = model.unwarped.cells(points, _SCRATCH)
    w = corners.part(_WARPS).vector()
    count, layers = points.shape[1], model.warped_layers
    v = np.empty((model.layers, count))
    if model.layers > layers:  # before the scratch memory is used again
        v[layers:] = corners.part(_FINE).noise()
    near = w[:, 1] * model.warp_m[1]
    near += points
    far = w[:, 0] * model.warp_m[0]
    far += near
    where = _SCRATCH.array("where", (3, len(model.warped), count))
    where[:, :FIELDS] = far[:, None]
    where[:, FIELDS:] = near[:, None]
    n = model.warped.cells(where, _SCRATCH).noise()
    v[:layers] = n[FIELDS:]
    c, b = _weighted(_FIELD_WEIGHTS, n[:FIELDS])
    sums = _weighted(model.sums, ridge_layers(v, model.ridge_column))
    return w[:, 0], c, b, sums[:2], sums[2]


_FIELD_WEIGHTS = np.stack(continent_weights())
_WARPS, _FINE = slice(0, 2), slice(2, None)


def _weighted(weights: Floats, values: Floats) -> Floats:
    """weights (R, K) @ values (K, N), each point for itself: a BLAS product's last bits depend on where in the batch a
    point stands, and neighbouring patches of ground would not meet. A few points are faster the other way."""
    count = values.shape[1]
    if 0 < count <= FEW_POINTS:
        return np.array([weights @ point for point in np.ascontiguousarray(values.T)]).T
    if count <= _FEW:
        return weights @ values
    out = np.empty((len(weights), count))
    term = np.empty(count)
    for row, total in zip(weights.tolist(), out, strict=True):
        total[:] = 0.0
        for weight, value in zip(row, values, strict=True):
            if weight != 0.0:
                np.multiply(value, weight, out=term)
                np.add(total, term, out=total)
    return out


_FEW = 32

FEW_POINTS = 2
"""So many points have the bits that each of them has alone."""


def ridge_layers(n: Floats, shares: Floats) -> Floats:
    """The layers' values from their noise `n` (layers, N), in place. shares: of ridges in the layers that have any
    (column), which come first."""
    part = n[: len(shares)]
    part[...] = ridge(part, shares)
    return n


def heights_gradients(points: Floats, model: Model, footprint_m: Floats | None) -> tuple[Floats, Floats]:
    """Heights (N,) and 3D gradients (3, N) of the field at points (3, N), forward by the chain rule."""
    return real_gradients(points, model, footprint_m, _procedural_gradients)


def _procedural_gradients(points: Floats, model: Model, footprint_m: Floats | None) -> tuple[Floats, Floats]:
    if model.gullied:
        return eroded_gradients(points, model, footprint_m)
    k = model.constants
    corners = model.unwarped.cells(points)
    w, jacobian = corners.part(slice(0, 2)).vector_derivative()
    jacobian = jacobian * model.unwarped.frequency[:2, None]
    near = points + w[:, 1] * model.warp_m[1]
    bent_near = jacobian[:, :, 1] * model.warp_m[1]
    for axis in range(3):
        bent_near[axis, axis] += 1.0
    bent_far = bent_near + jacobian[:, :, 0] * model.warp_m[0]
    far = near + w[:, 0] * model.warp_m[0]
    where = np.concatenate(
        [
            np.broadcast_to(far[:, None], (3, FIELDS, points.shape[1])),
            np.broadcast_to(near[:, None], (3, model.warped_layers, points.shape[1])),
        ],
        axis=1,
    )
    n, dn = model.warped.cells(where).noise_derivative()
    dn *= model.warped.frequency[:, None]
    c, b = _FIELD_WEIGHTS @ n[:FIELDS]
    dc, db = (np.einsum("f,afn,abn->bn", weights, dn[:, :FIELDS], bent_far) for weights in _FIELD_WEIGHTS)
    # all layers: the warped ones' derivatives through the warp, then the others'
    n_layers, dn_layers = n[FIELDS:], np.einsum("akn,abn->bkn", dn[:, FIELDS:], bent_near)
    if model.layers > model.warped_layers:
        fine, d_fine = corners.part(_FINE).noise_derivative()
        d_fine *= model.unwarped.frequency[2:, None]
        n_layers, dn_layers = np.concatenate([n_layers, fine]), np.concatenate([dn_layers, d_fine], axis=1)
    weight = _weights(model, footprint_m, points.shape[1])
    dn_layers *= ridge_slope(n_layers, model.ridge[:, None]) * weight
    v = ridge_layers(n_layers.copy(), model.ridge_column)
    sums = model.sums @ v
    z_seen = model.amplitude_m @ (weight * v)
    d_sums = np.einsum("sk,akn->san", model.sums, dn_layers)
    added, d_added, rougher, d_rougher = added_gradients(points, model, footprint_m)
    heights, *by, _ = surface_slopes(k, *w[:, 0], c, b, *sums, added, rougher, z_seen)
    changes = (*jacobian[:, :, 0], dc, db, *d_sums, d_added, d_rougher)
    total = np.zeros_like(d_added)
    for slope, change in zip(by, changes, strict=True):
        total = total + slope * change
    if model.params.rivers is None:
        return heights, total
    cut = valleys(model.params.rivers, points, "all")
    heights, *by = carve_slopes(heights, cut.base_m, cut.open, cut.raised)
    total = by[0] * total
    for slope, change in zip(by[1:], shown_slopes(cut, footprint_m), strict=True):
        total = total + slope * change
    return heights, total


def _weights(model: Model, footprint_m: Floats | None, count: int) -> Floats:
    if footprint_m is None:
        return np.ones((model.layers, count))
    return layer_weight(model.wavelength_m[:, None], np.maximum(footprint_m, 1e-9)[None])


def calibrate(model: Model) -> Model:
    """The model with the sea's level set so that `land_share` of the sphere lies above height 0.

    Where the bounds are on one side of 0 it is the middle height instead.
    """
    count = 4000
    i = np.arange(count) + 0.5
    z = 1.0 - 2.0 * i / count
    longitude = np.pi * (1.0 + 5.0**0.5) * i  # a Fibonacci lattice: equal areas
    flat = np.sqrt(1.0 - z * z)
    points = np.stack([np.cos(longitude) * flat, np.sin(longitude) * flat, z]) * model.params.radius_m
    parts = [_noises(points[:, a : a + BLOCK], model) for a in range(0, count, BLOCK)]
    _SCRATCH.clear()  # 8 MB, and most programs ask for single places from here on
    w1, c, b, shapes, relief = (np.concatenate(p, axis=-1) for p in zip(*parts, strict=True))
    share, deviation = model.params.land_share, float(c.std())
    low, high = float(c.min()) - deviation, float(c.max()) + deviation
    params = model.params
    lowest_m, highest_m = params.shaped_m
    level = 0.0 if lowest_m < 0.0 < highest_m else 0.5 * (lowest_m + highest_m)
    constants = replace(model.constants, inverse_deviation=1.0 / deviation)
    for _ in range(20):
        constants = replace(constants, sea_level=0.5 * (low + high))
        land = np.mean(surface(constants, w1[0], w1[1], w1[2], c, b, shapes[0], shapes[1], relief) > level)
        low, high = (constants.sea_level, high) if land > share else (low, constants.sea_level)
    return replace(model, constants=constants)
