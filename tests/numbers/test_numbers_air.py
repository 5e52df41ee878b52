"""Numbers that the project promises for the air: AtmosphereProbe against the float64 reference and printed truth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from air_tables import Floats, over_the_pole, table, towards

import planetfall as pf
from planetfall.benchmarks.measure import air

pytestmark = pytest.mark.gpu

UP = [[0.0, 0.0, 1.0]]
DETERMINISTIC = ("transmittance", "single", "mie", "aerial")
"""Quantities whose reference is quadrature: a second each. The others follow paths for minutes."""


@pytest.fixture(scope="module")
def earth() -> Iterator[pf.AtmosphereProbe]:
    with pf.AtmosphereProbe(air.scene_of(air.PLANETS["earth"])) as made:
        yield made


@pytest.fixture(scope="module")
def small() -> Iterator[pf.AtmosphereProbe]:
    with pf.AtmosphereProbe(air.scene_of(air.PLANETS["small"])) as made:
        yield made


def _name(promise: air.Promise) -> str:
    return f"{promise.name}, {promise.statistic}".replace(" ", "_")


def _held(probe: pf.AtmosphereProbe, planet: str, promise: air.Promise, count: int, paths: int = 1) -> None:
    truth = air.truth_of(planet, promise.quantity, count, paths)
    errors = air.errors(truth, air.answers(probe, truth), promise.groups)
    assert errors.count > 0
    assert errors.values["bad"] == 0
    assert errors.values[promise.statistic] <= promise.limit


QUICK = [p for p in air.PROMISES if p.quantity in DETERMINISTIC]
ALL_ORDERS = [p for p in air.PROMISES if p.quantity not in DETERMINISTIC]


@pytest.mark.parametrize("promise", QUICK, ids=_name)
def test_earth(earth: pf.AtmosphereProbe, promise: air.Promise) -> None:
    _held(earth, "earth", promise, 300)


def test_nothing_glows_on_the_night_side(earth: pf.AtmosphereProbe) -> None:
    truth = air.truth_of("earth", "single", 300)
    assert air.glow(truth, air.answers(earth, truth)) <= 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("promise", QUICK, ids=_name)
def test_small_planet(small: pf.AtmosphereProbe, promise: air.Promise) -> None:
    _held(small, "small", promise, 300)


@pytest.mark.slow
@pytest.mark.parametrize("planet", ["earth", "small"])
@pytest.mark.parametrize("promise", ALL_ORDERS, ids=_name)
def test_all_orders(request: pytest.FixtureRequest, planet: str, promise: air.Promise) -> None:
    # With these paths the reference's noise is a fifth of the limits and adds little to a 95th percentile.
    most = 12 if promise.quantity == "irradiance" else 60
    _held(request.getfixturevalue(planet), planet, promise, most, 16_384)


@pytest.mark.slow
def test_finer_quality_is_not_worse(earth: pf.AtmosphereProbe) -> None:
    """Each promise's error shrinks, or is far below what is promised, from low to ultra."""
    truth = air.truth_of("earth", "single", 300)
    errors = []
    for quality in ("low", "medium", "high", "ultra"):
        with pf.AtmosphereProbe(air.scene_of(air.PLANETS["earth"]), quality=quality) as probe:
            found = air.errors(truth, air.answers(probe, truth), ("sky day", "sky low", "space sun<=90"))
        errors.append(found.values["rel p95"])
    assert errors == sorted(errors, reverse=True), errors


# -- tables of independent truth: tests/data --------------------------------------------------------------------------


def _relative(found: Floats, truth: Floats, floor: float = 1e-7) -> Floats:
    counted = truth > floor
    assert counted.any() and np.isfinite(found).all() and (found >= 0.0).all()
    return np.abs(found[counted] / truth[counted] - 1.0)


def test_table_of_transmittance(earth: pf.AtmosphereProbe) -> None:
    for name in ("air_transmittance_top", "air_transmittance_points"):
        truth = table(name)
        p, d = over_the_pole(truth["altitude_m"]), towards(truth["view_zenith_deg"])
        distance = truth["distance_m"] if name.endswith("points") else None
        found = earth.transmittance(p, d, distance)
        steep = truth["view_zenith_deg"] <= 80.0
        assert np.percentile(_relative(found[steep], truth.triple("T")[steep], 1e-6), 95) <= 2e-4
        # To space it comes from a table of its own; between points from the camera's rows, and the promise is on their
        # light: level rays over hundreds of kilometres are coarser.
        error = np.abs(found - truth.triple("T"))
        assert (error.max() if distance is None else np.percentile(error, 95)) <= 4e-4


def test_table_of_single_scattering(earth: pf.AtmosphereProbe) -> None:
    truth = table("air_single_scattering")
    p, sun = over_the_pole(truth["altitude_m"]), towards(truth["sun_zenith_deg"])
    d = towards(truth["view_zenith_deg"], truth["azimuth_deg"])
    kind = np.array([row["sun_class"] for row in truth.rows])
    found, value = earth.sky_radiance(p, d, sun, orders=1), truth.triple("L1_disc")
    mie = earth.sky_radiance(p, d, sun, orders=1, part="mie")
    for suns, median, p95 in (("day", 2e-3, 1e-2), ("low", 2e-3, 1.5e-2)):
        rel = _relative(found[kind == suns], value[kind == suns])
        assert np.median(rel) <= median and np.percentile(rel, 95) <= p95
    assert np.percentile(_relative(mie[kind == "day"], truth.triple("SM_disc")[kind == "day"]), 95) <= 2e-2
    lit = (kind == "space") & (truth["sun_zenith_deg"] <= 90.0)
    assert np.percentile(_relative(found[lit], value[lit]), 95) <= 1e-2


def test_table_of_all_orders(earth: pf.AtmosphereProbe) -> None:
    truth = table("air_total_radiance")
    p, sun = over_the_pole(truth["altitude_m"]), towards(truth["sun_zenith_deg"])
    found = earth.sky_radiance(p, towards(truth["view_zenith_deg"], truth["azimuth_deg"]), sun)
    day = truth["sun_zenith_deg"] <= 88.0
    rel = _relative(found[day], truth.triple("Ltot")[day])
    assert np.median(rel) <= 1e-2 and np.percentile(rel, 95) <= 3e-2


def test_table_of_aerial_perspective(earth: pf.AtmosphereProbe) -> None:
    for name, stem, orders in (("air_aerial_single", "L1_disc", 1), ("air_aerial_total", "Ltot", None)):
        truth = table(name)
        p = over_the_pole(truth["camera_altitude_m"])
        points = p + truth.directions() * truth["distance_m"][:, None]
        sun = towards(truth["sun_zenith_at_camera_deg"])
        found, transmittance = earth.in_scattering(p, points, sun, orders)
        assert np.percentile(np.abs(transmittance - truth.triple("T")), 95) <= 4e-4
        day = truth["sun_zenith_at_camera_deg"] <= 85.0
        rel = _relative(found[day], truth.triple(stem)[day])
        assert np.percentile(rel, 95) <= (2e-2 if orders == 1 else 3e-2)
        assert (found >= 0.0).all()


def test_table_of_irradiance(earth: pf.AtmosphereProbe) -> None:
    truth = table("air_irradiance")
    p, sun = over_the_pole(truth["altitude_m"]), towards(truth["sun_zenith_deg"])
    direct, sky = earth.irradiance(p, UP, sun)
    high = truth["sun_zenith_deg"] <= 88.0
    assert np.percentile(_relative(sky[high], truth.triple("Esky_total")[high]), 95) <= 2e-2
    assert np.percentile(_relative(sky[~high], truth.triple("Esky_total")[~high]), 95) <= 0.1
    assert np.percentile(_relative(direct[high], truth.triple("Edirect_disccos")[high]), 95) <= 2e-3
