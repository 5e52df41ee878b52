"""Errors of the air's answers against the float64 reference, by the rows of the project's table of promises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import Atmosphere, Planet, Scene, load_scene
from ..reference import air as reference
from ..reference.air_medium import AirParameters, Floats
from ..reference.air_single import aerial_single, sky_single
from .air_queries import AirQueries, aerial_queries, irradiance_queries, sky_queries, transmittance_queries
from .air_random import joined, random_sky
from .air_score import RADIANCE_FLOOR, TRANSMITTANCE_FLOOR, Kind, classes, reference_brightness

Quantity = Literal["transmittance", "single", "mie", "aerial", "total", "aerial total", "irradiance"]

KINDS: Mapping[Quantity, Kind] = {
    "transmittance": "transmittance", "single": "single", "mie": "single", "aerial": "aerial", "total": "total",
    "aerial total": "aerial", "irradiance": "irradiance",
}  # fmt: skip

PLANETS: Mapping[str, AirParameters] = {"earth": reference.EARTH_BRUNETON, "small": reference.SMALL_PLANET}
"""Earth with the air of Bruneton's demo of 2017, and the small planet under the same air, squeezed."""

SEED = 2017
_RTOL = 1e-6
"""Of the deterministic references: a hundredth of the smallest error that is promised."""


class Air(Protocol):
    """What is asked: AtmosphereProbe's calls."""

    def transmittance(self, positions_m: ArrayLike, directions: ArrayLike) -> Floats:
        """See AtmosphereProbe."""
        ...

    def sky_radiance(
        self, positions_m: ArrayLike, directions: ArrayLike, sun_directions: ArrayLike,
        orders: int | None = None, part: str | None = None,
    ) -> Floats:  # fmt: skip
        """See AtmosphereProbe."""
        ...

    def in_scattering(
        self, positions_m: ArrayLike, points_m: ArrayLike, sun_directions: ArrayLike, orders: int | None = None
    ) -> tuple[Floats, Floats]:
        """See AtmosphereProbe."""
        ...

    def irradiance(
        self, positions_m: ArrayLike, normals: ArrayLike, sun_directions: ArrayLike
    ) -> tuple[Floats, Floats]:
        """See AtmosphereProbe."""
        ...


@dataclass(frozen=True)
class Promise:
    """One row of the table: a quantity, in classes, by a statistic. anchor: Bruneton 2017 at full table size in float64
    with a Mie texture of its own, measured on Earth; NaN where it is not known."""

    name: str
    quantity: Quantity
    groups: tuple[str, ...]
    statistic: str
    limit: float
    anchor: float = float("nan")


PROMISES = (
    Promise("transmittance to space, zenith <= 80", "transmittance", ("z<=80",), "rel p95", 2e-4, 2.4e-4),
    Promise("transmittance to space, zenith > 80", "transmittance", ("80<z<=89", "z>89"), "abs max", 4e-4, 4.1e-4),
    Promise("single scattering, sky, sun <= 75", "single", ("sky day",), "rel median", 2e-3, 4.7e-3),
    Promise("single scattering, sky, sun <= 75", "single", ("sky day",), "rel p95", 1e-2, 3.6e-2),
    Promise("single scattering, ground, sun <= 75", "single", ("ground day",), "rel p95", 1e-2),
    Promise("Mie alone, sky, sun <= 75", "mie", ("sky day",), "rel p95", 2e-2, 0.27),
    Promise("single scattering, sky, sun 80-88", "single", ("sky low",), "rel median", 2e-3, 3.0e-3),
    Promise("single scattering, sky, sun 80-88", "single", ("sky low",), "rel p95", 1.5e-2, 4.1e-2),
    Promise("single scattering, ground, sun 80-88", "single", ("ground low",), "rel p95", 1.5e-2),
    Promise("single scattering, sun 90-91", "single", ("sky set",), "wrel p95", 5e-2, 8.4e-2),
    Promise("single scattering, sun 92-98", "single", ("sky twilight",), "wrel p95", 0.1, 0.57),
    Promise("single scattering, from space, sun <= 90", "single", ("space sun<=90",), "rel p95", 1e-2, 1.6e-2),
    Promise("single scattering, from space, sun > 90", "single", ("space sun>90",), "wrel max", 0.1, 56.0),
    Promise("aerial perspective, sun <= 85", "aerial", ("sun<=85",), "rel p95", 2e-2, 3.5e-2),
    Promise("aerial perspective, sun >= 90", "aerial", ("sun 90", "sun>90"), "wrel p95", 0.2),
    Promise("aerial perspective, sun >= 90", "aerial", ("sun 90", "sun>90"), "bad", 0.0),
    Promise(
        "all orders, sun <= 88", "total", ("in atmosphere sun<=75", "in atmosphere sun 80-88"), "rel median", 1e-2,
        1.2e-2,
    ),
    Promise(
        "all orders, sun <= 88", "total", ("in atmosphere sun<=75", "in atmosphere sun 80-88"), "rel p95", 3e-2, 4.5e-2
    ),
    Promise("all orders, from space, sun <= 60", "total", ("space sun<=90",), "rel p95", 3e-2),
    Promise("all orders, aerial, sun <= 85", "aerial total", ("sun<=85",), "rel p95", 3e-2),
    Promise("sky irradiance, sun <= 88", "irradiance", ("sun<=75", "sun 85-88"), "rel p95", 2e-2, 0.10),
    Promise("sky irradiance, sun 90-94", "irradiance", ("sun 90-91", "sun>91"), "rel p95", 0.1, 0.79),
)  # fmt: skip
"""Errors of single scattering count for the light of the air alone; classes and statistics are those of air_score."""


@dataclass(frozen=True)
class Truth:
    """Questions about one quantity and the reference's answers."""

    quantity: Quantity
    queries: AirQueries
    value: Floats
    """(N, 3)"""
    noise: Floats
    """(N, 3) one standard error of Monte-Carlo; 0 where nothing is random."""
    brightness: Floats
    """(N, 3) `ref` of air_score, from the whole of the grid if the queries are a sample of it."""


@dataclass(frozen=True)
class Errors:
    """One quantity's errors in some classes, all wavelengths pooled: see air_score."""

    count: int
    values: Mapping[str, float]
    """ "rel median", "rel p95", "rel max", "wrel median", "wrel p95", "wrel max", "abs max", "bad"."""
    noise_p95: float
    """Of the reference's standard errors, relative, where `rel` counts: errors below it mean nothing."""


def scene_of(air: AirParameters) -> Scene:
    """The preset Earth with the reference's planet, air and unit sun."""
    scene = load_scene("earth")
    handle = scene.planet
    handle[Planet].radius_m = air.radius_m
    component: Any = handle[Atmosphere]
    for name in AirParameters.__dataclass_fields__:
        if hasattr(component, name):
            setattr(component, name, getattr(air, name))
    scene.sun.irradiance = (1.0, 1.0, 1.0)
    scene.sun.angular_radius_rad = air.sun_angular_radius_rad
    return scene


@lru_cache(maxsize=32)
def truth_of(planet: str, quantity: Quantity, count: int = 2000, paths: int = 32_768) -> Truth:
    """Questions and the reference's answers; kept, as several variants are held against them.

    count: random views beside the grid's, for single scattering; elsewhere how many questions are asked at most. Those
    about all orders are followed by `paths` paths each: a tenth of a second, as much again for irradiance.
    """
    air = PLANETS[planet]
    if quantity == "transmittance":
        q = transmittance_queries(air)
        return _truth(quantity, q, reference.transmittance(air, q.positions_m, q.directions))
    if quantity in ("single", "mie"):
        q = joined(sky_queries(air), random_sky(air, count, SEED)) if count else sky_queries(air)
        found = _single(planet, count)
        return _truth(quantity, q, found.radiance if quantity == "single" else found.mie)
    if quantity == "aerial":
        q = aerial_queries(air)
        found = aerial_single(air, q.positions_m, q.points_m, q.sun_directions, rtol=_RTOL)
        return _truth(quantity, q, found.radiance)
    if quantity == "aerial total":
        q = aerial_queries(air)
        q = q.chosen(q.sun_zenith_deg <= 85.0).thinned(count, SEED)
        estimate = reference.in_scattering(air, q.positions_m, q.points_m, q.sun_directions, paths=paths, seed=SEED)
        return _truth(quantity, q, estimate.radiance, estimate.standard_error)
    if quantity == "total":
        q = joined(sky_queries(air), random_sky(air, 1000, SEED + 1))
        # Where next to nothing is left, paths find nothing: twilight's statistic is on the first order.
        q = q.chosen(q.sun_zenith_deg <= np.where(q.in_space, 60.0, 88.0)).thinned(count, SEED)
        estimate = reference.sky_radiance(air, q.positions_m, q.directions, q.sun_directions, paths=paths, seed=SEED)
        return _truth(quantity, q, estimate.radiance, estimate.standard_error)
    q = irradiance_queries(air).thinned(count, SEED)
    light = reference.irradiance(air, q.positions_m, [[0.0, 0.0, 1.0]], q.sun_directions, paths=paths, seed=SEED)
    return _truth(quantity, q, light.sky, light.sky_standard_error)


@lru_cache(maxsize=4)
def _single(planet: str, count: int) -> Any:
    air = PLANETS[planet]
    q = joined(sky_queries(air), random_sky(air, count, SEED)) if count else sky_queries(air)
    return sky_single(air, q.positions_m, q.directions, q.sun_directions, rtol=_RTOL)


def _truth(quantity: Quantity, q: AirQueries, value: Floats, noise: Floats | None = None) -> Truth:
    brightness = reference_brightness(KINDS[quantity], q, value)
    return Truth(quantity, q, value, np.zeros_like(value) if noise is None else noise, brightness)


def answers(air: Air, truth: Truth) -> Floats:
    """(N, 3): what the air says to the questions of `truth`."""
    q = truth.queries
    if truth.quantity == "transmittance":
        return air.transmittance(q.positions_m, q.directions)
    if truth.quantity == "irradiance":
        return air.irradiance(q.positions_m, [[0.0, 0.0, 1.0]], q.sun_directions)[1]
    if truth.quantity in ("aerial", "aerial total"):
        orders = 1 if truth.quantity == "aerial" else None
        return air.in_scattering(q.positions_m, q.points_m, q.sun_directions, orders)[0]
    if truth.quantity == "mie":
        return air.sky_radiance(q.positions_m, q.directions, q.sun_directions, 1, "mie")
    orders = 1 if truth.quantity == "single" else None
    return air.sky_radiance(q.positions_m, q.directions, q.sun_directions, orders)


def errors(truth: Truth, found: Floats, groups: tuple[str, ...]) -> Errors:
    """Errors of answers (N, 3) in the union of classes; KeyError for a class that has no questions."""
    kind = KINDS[truth.quantity]
    known = classes(kind, truth.queries)
    rows: NDArray[np.bool_] = np.any([known[group] for group in groups], axis=0)
    value, got, noise = truth.value[rows], found[rows], truth.noise[rows]
    bad = ~np.isfinite(got) | (got < 0.0)
    error = np.abs(np.where(np.isfinite(got), got, 0.0) - value)
    size = np.abs(value)
    counted = size > (TRANSMITTANCE_FLOOR if kind == "transmittance" else RADIANCE_FLOOR)
    rel = error[counted] / size[counted]
    wrel = error / (size + 0.1 * truth.brightness[rows])
    values = {}
    for name, part in (("rel", rel), ("wrel", wrel.ravel())):
        values[f"{name} median"] = float(np.median(part)) if part.size else 0.0
        values[f"{name} p95"] = float(np.percentile(part, 95)) if part.size else 0.0
        values[f"{name} max"] = float(part.max(initial=0.0))
    values["abs max"], values["bad"] = float(error.max(initial=0.0)), float(bad.sum())
    grain = noise[counted] / size[counted]
    return Errors(int(counted.sum()), values, float(np.percentile(grain, 95)) if grain.size else 0.0)


def glow(truth: Truth, found: Floats) -> float:
    """The brightest answer, beside the day's sky, where the reference is black as seen from space: nothing may glow."""
    day = float(np.median(truth.brightness[truth.queries.in_space]))
    dark = truth.queries.in_space[:, None] & (truth.value < 1e-6 * day)
    return float(np.max(np.where(dark, found, 0.0))) / day
