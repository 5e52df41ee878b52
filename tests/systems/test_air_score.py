"""Scores of answers about clear air, and the grids of questions, against cases done by hand."""

from __future__ import annotations

import numpy as np
import pytest
from air_tables import table

from planetfall.benchmarks.measure.air_queries import (
    AirQueries,
    aerial_queries,
    horizon_zenith_deg,
    irradiance_queries,
    sky_queries,
    transmittance_queries,
)
from planetfall.benchmarks.measure.air_score import classes, reference_brightness, score
from planetfall.benchmarks.reference.air import EARTH_BRUNETON, SMALL_PLANET, transmittance
from planetfall.benchmarks.reference.air_rays import make_rays


def _rows(*rows: tuple[float, float, float, bool, bool]) -> AirQueries:
    """(altitude, sun, view, hits the ground, in space)."""
    h, sun, view, hits, space = (np.array(c) for c in zip(*rows, strict=True))
    return AirQueries(h, sun, view, 0.0 * h, np.inf + 0.0 * h, hits, space, 6.36e6)


QUERIES = _rows(
    (0.0, 30.0, 40.0, False, False),
    (0.0, 30.0, 70.0, False, False),
    (0.0, 30.0, 95.0, True, False),
    (0.0, 94.0, 40.0, False, False),
    (0.0, 98.0, 40.0, False, False),
    (1e6, 150.0, 170.0, True, True),
)
TRUTH = np.array([[0.1], [0.3], [0.05], [1e-3], [1e-9], [0.0]])


def test_classes_and_brightness_by_hand() -> None:
    found = {name: list(np.nonzero(rows)[0]) for name, rows in classes("single", QUERIES).items()}
    assert found == {
        "all": [0, 1, 2, 3, 4, 5],
        "sky day": [0, 1],
        "ground day": [2],
        "sky twilight": [3, 4],
        "space sun>90": [5],
    }
    # By day the median of 0.1 and 0.3, for the ground and for space too; dusk its own; night 1e-4 of the day.
    ref = reference_brightness("single", QUERIES, TRUTH)
    np.testing.assert_allclose(ref[:, 0], [0.2, 0.2, 0.2, 1e-3, 2e-5, 0.2])


def test_scores_by_hand() -> None:
    answers = np.array([[0.11], [0.3], [np.nan], [1e-3], [-1e-6], [0.02]])
    scores = {s.group: s for s in score("single", "L1", QUERIES, answers, TRUTH)}
    day = scores["sky day"]
    assert (day.count, day.bad) == (2, 0)
    np.testing.assert_allclose([day.rel_median, day.rel_max, day.abs_max], [0.05, 0.1, 0.01])
    np.testing.assert_allclose(day.wrel_max, 0.01 / (0.1 + 0.02))
    # A glow on the night side counts beside the day's brightness; nothing there is above the floor.
    night = scores["space sun>90"]
    assert night.count == 0 and np.isnan(night.rel_max)
    np.testing.assert_allclose(night.wrel_max, 0.02 / 0.02)
    assert scores["ground day"].bad == 1 and scores["ground day"].rel_max == 1.0
    assert scores["sky twilight"].bad == 1 and scores["all"].bad == 2
    # Of the two at dusk one is below the floor.
    assert scores["sky twilight"].count == 1


def test_misfits_are_named() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        score("single", "L1", QUERIES, TRUTH[:3], TRUTH)
    with pytest.raises(ValueError, match="not finite"):
        score("single", "L1", QUERIES, TRUTH, TRUTH * np.nan)


def test_classes_are_those_of_the_tables() -> None:
    truth = table("air_single_scattering")
    names = np.array([row["sun_class"] for row in truth.rows])
    space, hits = names == "space", truth["ray_hits_ground"] == 1
    h = truth["altitude_m"]
    queries = AirQueries(
        h,
        truth["sun_zenith_deg"],
        truth["view_zenith_deg"],
        truth["azimuth_deg"],
        np.inf + 0.0 * h,
        hits,
        space,
        6.36e6,
    )
    found = classes("single", queries)
    for name in ("day", "low", "set", "twilight"):
        np.testing.assert_array_equal(found[f"sky {name}"], (names == name) & ~hits)
        np.testing.assert_array_equal(found[f"ground {name}"], (names == name) & hits)


@pytest.mark.parametrize("air", [EARTH_BRUNETON, SMALL_PLANET], ids=["earth", "small"])
def test_grids_ask_in_every_class(air) -> None:
    sky = sky_queries(air)
    found = classes("single", sky)
    expected = {f"{what} {name}" for what in ("sky", "ground") for name in ("day", "low", "set", "twilight")}
    assert expected | {"all", "space sun<=90", "space sun>90"} == set(found)
    assert min(rows.sum() for rows in found.values()) >= 20
    rays = make_rays(air, sky.positions_m, sky.directions)
    np.testing.assert_array_equal(rays.hits_ground, sky.hits_ground)
    assert (rays.end_m > rays.start_m).all()
    # Down to 0.1 degree on both sides of the horizon.
    for height in (0.0, 10.0, 1000.0):
        h = height * air.thickness_m / 60_000.0
        at = (sky.altitude_m == h) & (sky.sun_zenith_deg == 0.0)
        off = sky.view_zenith_deg[at] - horizon_zenith_deg(air, h)
        assert np.isclose(off, -0.1, atol=1e-9).any() and (h == 0.0 or np.isclose(off, 0.1, atol=1e-9).any())
    above = transmittance_queries(air)
    assert set(classes("transmittance", above)) == {"all", "z<=80", "80<z<=89", "z>89"}
    assert (transmittance(air, above.positions_m, above.directions) > 0.0).any(axis=1).all()
    level = irradiance_queries(air)
    assert set(classes("irradiance", level)) == {"all", "sun<=75", "sun 85-88", "sun 90-91", "sun>91"}


@pytest.mark.parametrize(("air", "least"), [(EARTH_BRUNETON, 200), (SMALL_PLANET, 60)], ids=["earth", "small"])
def test_points_to_look_at_are_above_the_ground_and_in_sight(air, least: int) -> None:
    asked = aerial_queries(air)
    assert len(asked) >= least
    assert set(classes("aerial", asked)) == {"all", "sun<=85", "sun 90", "sun>90"}
    ends = np.linalg.norm(asked.points_m, axis=1) - air.radius_m
    assert (ends > -1e-4).all() and (ends < air.thickness_m).all()
    rays = make_rays(air, asked.positions_m, asked.directions)
    along = np.einsum("ij,ij->i", asked.positions_m, rays.direction)
    assert (asked.distance_m <= (rays.end_m - along) * (1.0 + 1e-5)).all()


def test_samples_keep_the_order() -> None:
    sky = sky_queries(EARTH_BRUNETON)
    few = sky.thinned(40, seed=1)
    assert len(few) == 40 and few.thinned(100).altitude_m.shape == (40,)
    rows = {tuple(r) for r in np.stack([sky.altitude_m, sky.sun_zenith_deg, sky.view_zenith_deg], axis=1)}
    assert all(tuple(r) in rows for r in np.stack([few.altitude_m, few.sun_zenith_deg, few.view_zenith_deg], axis=1))
