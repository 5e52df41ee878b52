"""Grids of questions about clear air, for any planet: cameras from the ground to far out, suns, views.

Earth's altitudes are scaled: inside the air with its thickness, outside with the planet's radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..reference.air_medium import AirParameters, Floats
from ..reference.air_rays import make_rays

EARTH_THICKNESS_M, EARTH_RADIUS_M = 60_000.0, 6_360_000.0
ALTITUDES_M = (0.0, 10.0, 1000.0, 10_000.0, 50_000.0)
NEAR_SPACE_M = 100_000.0
SPACE_M = (1_000_000.0, 36_000_000.0)
SUNS_DEG = (0.0, 30.0, 60.0, 75.0, 80.0, 85.0, 88.0, 90.0, 91.0, 92.0, 94.0, 96.0, 98.0)
SPACE_SUNS_DEG = (0.0, 60.0, 90.0, 110.0, 120.0, 150.0, 165.0, 175.0)
AERIAL_SUNS_DEG = (0.0, 30.0, 60.0, 75.0, 85.0, 90.0, 93.0, 97.0)
AZIMUTHS_DEG = (0.0, 90.0, 180.0)


@dataclass(frozen=True)
class AirQueries:
    """N questions: a camera over +Z, a view, a sun in the plane of X and Z; and what they are to be counted as."""

    altitude_m: Floats
    sun_zenith_deg: Floats
    view_zenith_deg: Floats
    azimuth_deg: Floats
    distance_m: Floats
    """(N,) how far along the view; infinite: to space or the ground."""
    hits_ground: NDArray[np.bool_]
    in_space: NDArray[np.bool_]
    radius_m: float

    def __len__(self) -> int:
        return len(self.altitude_m)

    @property
    def positions_m(self) -> Floats:
        zero = np.zeros(len(self))
        return np.stack([zero, zero, self.radius_m + self.altitude_m], axis=1)

    @property
    def directions(self) -> Floats:
        return _towards(self.view_zenith_deg, self.azimuth_deg)

    @property
    def sun_directions(self) -> Floats:
        return _towards(self.sun_zenith_deg, np.zeros(len(self)))

    @property
    def points_m(self) -> Floats:
        """(N, 3) ends of the views with a distance."""
        return self.positions_m + self.directions * self.distance_m[:, None]

    def chosen(self, at: NDArray[np.bool_] | NDArray[np.intp]) -> AirQueries:
        """Some of them, by mask or numbers."""
        return AirQueries(
            self.altitude_m[at], self.sun_zenith_deg[at], self.view_zenith_deg[at], self.azimuth_deg[at],
            self.distance_m[at], self.hits_ground[at], self.in_space[at], self.radius_m,
        )  # fmt: skip

    def thinned(self, most: int, seed: int = 0) -> AirQueries:
        """At most so many, drawn without order but kept in order: for answers that take long."""
        at = np.random.default_rng(seed).permutation(len(self))[:most]
        return self.chosen(np.sort(at))


def _towards(zenith_deg: Floats, azimuth_deg: Floats) -> Floats:
    z, a = np.radians(zenith_deg), np.radians(azimuth_deg)
    return np.stack([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)], axis=1)


def air_altitudes(air: AirParameters) -> list[float]:
    """Altitudes inside the air: 0 m to 50 km on Earth."""
    return [h * air.thickness_m / EARTH_THICKNESS_M for h in ALTITUDES_M]


def space_altitudes(air: AirParameters) -> list[float]:
    """Altitudes outside: 100 km, 1000 km and 36 000 km on Earth."""
    # Around a planet whose air is as thick as itself, that would still be inside.
    far = [max(h * air.radius_m / EARTH_RADIUS_M, 3.0 * air.thickness_m) for h in SPACE_M]
    return [NEAR_SPACE_M * air.thickness_m / EARTH_THICKNESS_M, *far]


def horizon_zenith_deg(air: AirParameters, altitude_m: float) -> float:
    """The zenith angle of the horizon, from its dip: tan(dip) = sqrt(h (2 R + h)) / R."""
    return 90.0 + float(np.degrees(np.arctan2(np.sqrt(air.level(altitude_m)), air.radius_m)))


def sky_queries(air: AirParameters) -> AirQueries:
    """Whole views in every class: 2300 on Earth."""
    rows: list[tuple[float, float, float, float]] = []
    for h in air_altitudes(air):
        horizon = horizon_zenith_deg(air, h)
        below = (horizon + 0.1, horizon + 1.0, horizon + 30.0, 180.0) if h > 0.0 else ()
        for sun in SUNS_DEG:
            # Five degrees above the sun: dust's glow.
            views = {0.0, 40.0, 70.0, 85.0, horizon - 2.0, horizon - 0.1, max(sun - 5.0, 0.0), *below}
            rows += [(h, sun, view, azimuth) for view in sorted(views) for azimuth in _azimuths(sun, view)]
    for h in space_altitudes(air):
        for sun in SPACE_SUNS_DEG:
            for view in space_views(air, h):
                rows += [(h, sun, view, azimuth) for azimuth in _azimuths(sun, view)]
    return _queries(air, rows)


def space_views(air: AirParameters, altitude_m: float) -> list[float]:
    """Zenith angles of views from outside the air: the disc from its middle to its edge, and the limb."""
    r, top = air.radius_m + altitude_m, air.radius_m + air.thickness_m
    limb = air.radius_m + air.thickness_m * np.array([0.02, 0.1, 0.3, 0.7])
    disc = air.radius_m * np.array([0.0, 0.5, 0.9, 0.99, 0.999])
    views = list(180.0 - np.degrees(np.arcsin(np.concatenate([disc, limb]) / r)))
    edge = 180.0 - np.degrees(np.arcsin(air.radius_m / r))
    outer = 180.0 - np.degrees(np.arcsin(top / r))
    return sorted({*views, *(v for v in (edge - 0.1, edge + 0.1) if v > outer)})


def _azimuths(sun: float, view: float) -> tuple[float, ...]:
    return (0.0,) if sun in (0.0, 180.0) or view in (0.0, 180.0) else AZIMUTHS_DEG


def _queries(
    air: AirParameters, rows: list[tuple[float, float, float, float]], distances: list[float] | None = None
) -> AirQueries:
    h, sun, view, azimuth = np.array(rows, dtype=float).T
    horizon = np.array([horizon_zenith_deg(air, float(a)) for a in h])
    distance = np.full(len(h), np.inf) if distances is None else np.array(distances, dtype=float)
    hits = (view > horizon) if distances is None else np.zeros(len(h), dtype=bool)
    return AirQueries(h, sun, view, azimuth, distance, hits, h > air.thickness_m, air.radius_m)


def transmittance_queries(air: AirParameters) -> AirQueries:
    """Views to space, the last 0.01 degree above the horizon."""
    rows: list[tuple[float, float, float, float]] = []
    for h in (*air_altitudes(air), 0.3 * air.thickness_m, 0.999 * air.thickness_m):
        horizon = horizon_zenith_deg(air, h)
        views = {0.0, 30.0, 60.0, 75.0, 80.0, 85.0, 87.0, 88.0, 89.0, 89.5, 89.9}
        views |= {horizon - d for d in (0.01, 0.1, 0.5, 1.0)}
        rows += [(h, 0.0, view, 0.0) for view in sorted(views) if view < horizon]
    return _queries(air, rows)


def aerial_queries(air: AirParameters) -> AirQueries:
    """Views that end in mid-air or just above the ground, from inside the air and from space."""
    squeeze = air.thickness_m / EARTH_THICKNESS_M
    ways = [
        (2.0, 0.0, 1e3), (2.0, 200.0, 1e3), (2.0, 1e3, 1e4), (100.0, 0.0, 1e4), (2.0, 3e3, 5e4), (1e3, 0.0, 5e4),
        (3e3, 4e3, 2e5), (1e4, 0.0, 1e4), (1e4, 0.0, 5e4), (5e4, 0.0, 2e5), (4e5, 0.0, 4e5), (4e5, 0.0, 1e6),
    ]  # fmt: skip
    rows: list[tuple[float, float, float, float]] = []
    distances: list[float] = []
    for camera, target, distance in ways:
        h, end, d = camera * squeeze, target * squeeze, distance * squeeze
        r, q = air.radius_m + h, air.radius_m + end
        # q^2 = r^2 + d^2 + 2 r d mu, as differences; straight down, rounding may leave the cosine beyond -1.
        mu = float(np.clip(((q - r) * (q + r) - d * d) / (2.0 * r * d), -1.0, 1.0))
        view = float(np.degrees(np.arccos(mu)))
        line = make_rays(air, [[0.0, 0.0, r]], _towards(np.array([view]), np.zeros(1)))
        if line.hits_ground[0] and line.end_m[0] - r * mu < d * (1.0 - 1e-6):
            continue  # on a smaller planet the ground may be in the way
        for sun in AERIAL_SUNS_DEG:
            for azimuth in _azimuths(sun, view):
                rows.append((h, sun, view, azimuth))
                distances.append(d)
    return _queries(air, rows, distances)


def irradiance_queries(air: AirParameters) -> AirQueries:
    """Level surfaces on the ground and above it (views straight up)."""
    squeeze = air.thickness_m / EARTH_THICKNESS_M
    suns = (0.0, 30.0, 60.0, 75.0, 85.0, 88.0, 90.0, 91.0, 92.0, 94.0)
    return _queries(air, [(h * squeeze, sun, 0.0, 0.0) for h in (0.0, 2000.0, 10_000.0) for sun in suns])
