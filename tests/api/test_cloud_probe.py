"""The renderer's march through homogeneous clouds against tables of independent truth.

Limits are the ones that are promised for the qualities; what is reached is far below (docs/clouds.md).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from air_tables import over_the_pole, towards
from cloud_tables import clouds_of, column, configs, even, geometry, planet_of, radius_of, rows_of, triple

import planetfall as pf

FLOOR = 1e-7
"""Radiance, of a unit sun, below which relative errors say nothing: a thousandth of the darkest cloud by day."""


def _relative(found: Any, truth: Any) -> Any:
    seen = truth > FLOOR
    return np.abs(found - truth)[seen] / truth[seen]


@pytest.mark.parametrize(("quality", "median", "p95"), [("reference", 1e-2, 5e-2), ("high", 3e-2, 0.1)])
def test_shells_in_vacuum(quality: str, median: float, p95: float) -> None:
    errors = []
    for config in configs("clouds_shell"):
        rows = rows_of("clouds_shell", config=config)
        with pf.CloudProbe(planet_of(clouds_of(rows[0]), radius_of(rows)), quality=quality) as probe:
            light, through = probe.march(*geometry(rows, radius_of(rows)), orders=1, sun_visibility="point")
        assert np.isfinite(light).all()
        assert (light >= 0.0).all()
        np.testing.assert_allclose(through[:, 0], column(rows, "transmittance"), rtol=0.0, atol=1e-4)
        errors.append(_relative(light[:, 0], column(rows, "L1")))
    found = np.concatenate(errors)
    assert np.median(found) < median
    assert np.percentile(found, 95) < p95


def test_shells_in_the_air_of_earth() -> None:
    errors = []
    for config in configs("clouds_in_air"):
        rows = rows_of("clouds_in_air", config=config)
        with pf.CloudProbe(planet_of(clouds_of(rows[0]), air=pf.Atmosphere()), quality="reference") as probe:
            light, through = probe.march(*geometry(rows, 6.36e6), orders=1, sun_visibility="point")
            alone, _ = probe.march(*geometry(rows, 6.36e6), orders=1, sun_visibility="point", air=False)
        np.testing.assert_allclose(through, triple(rows, "T"), rtol=0.0, atol=1e-4)
        errors.append(_relative(light, triple(rows, "L_total")).ravel())
        # Without air it is another question, asked of the same probe.
        assert np.ptp(alone, axis=1).max() == 0.0
        assert not np.allclose(alone, light, rtol=1e-2)
    found = np.concatenate(errors)
    assert np.median(found) < 2e-2
    assert np.percentile(found, 95) < 0.1


# Of this radius a slab is flat: over 60 km, where a ray of 88 degrees goes through 1 km, the ground falls by 18 m.
FLAT_M = 1e8


@pytest.mark.parametrize("quality", ["low", "high"])
def test_slabs_of_all_orders(quality: str) -> None:
    errors = []
    for row in rows_of("clouds_slab_multiple"):
        depth, view = float(row["optical_depth"]), float(row["view_zenith_deg"])
        clouds = even(1000.0, 2000.0, depth / 1000.0, float(row["albedo"]), float(row["hg_g"]))
        with pf.CloudProbe(planet_of(clouds, FLAT_M), quality=quality) as probe:
            place = over_the_pole([2001.0 if view > 90.0 else 999.0], FLAT_M)
            ways = towards([view], [float(row["azimuth_deg"])]), towards([float(row["sun_zenith_deg"])])
            found = probe.march(place, *ways)[0][0, 0]
        errors.append(abs(found / float(row["L_total"]) - 1.0))
    assert max(errors) < 0.3
    assert np.median(errors) < 0.1


def test_two_layers_are_each_alone_where_they_are_thin() -> None:
    # Light that both take is the product of what each takes: at a depth of 1e-4 nothing that shows.
    low, high = even(1000.0, 2000.0, 1e-7), even(8000.0, 9000.0, 1e-7)
    both = even(1000.0, 2000.0, 1e-7)
    both.layers = [high]
    place, way, sun = over_the_pole([0.0]), towards([30.0]), towards([50.0])
    found = []
    for clouds in (low, high, both):
        with pf.CloudProbe(planet_of(clouds), quality="high") as probe:
            found.append(probe.march(place, way, sun, orders=1)[0][0, 0])
    assert found[2] == pytest.approx(found[0] + found[1], rel=1e-3)


def test_no_clouds_is_the_air_alone() -> None:
    scene = planet_of(even(1000.0, 2000.0, 0.0), air=pf.Atmosphere())
    place, way, sun = over_the_pole([10.0, 10.0, 4e5]), towards([20.0, 85.0, 180.0]), towards([40.0])
    with pf.CloudProbe(scene, overrides={"clouds.air_steps": 48}) as probe:
        light, through = probe.march(place, way, sun, orders=1)
        empty, clear = probe.march(place, way, sun, air=False)
    with pf.AtmosphereProbe(scene) as air:
        np.testing.assert_allclose(light, air.sky_radiance(place, way, sun, orders=1), rtol=2e-3)
        np.testing.assert_allclose(through[:2], air.transmittance(place[:2], way[:2]), atol=2e-4)
    assert not empty.any()
    assert (clear == 1.0).all()


def test_a_ray_may_end_anywhere() -> None:
    with pf.CloudProbe(planet_of(even(1000.0, 2000.0, 1e-3))) as probe:
        ends = [0.0, 999.0, 1000.0, 1500.0, 2000.0, 5000.0]
        place = over_the_pole(np.zeros(len(ends)))
        light, through = probe.march(place, [0, 0, 1], [0, 0, 1], max_distance_m=ends)
    depths = np.array([0.0, 0.0, 0.0, 0.5, 1.0, 1.0])
    np.testing.assert_allclose(through[:, 0], np.exp(-depths), atol=1e-6)
    assert (light[:3] == 0.0).all()
    assert (np.diff(light[2:, 0]) >= 0.0).all()


def test_bad_questions_are_told_of() -> None:
    with pytest.raises(ValueError, match="no Clouds component"):
        pf.CloudProbe(pf.Scene("bare", {"planet": pf.Planet()}))
    with pytest.raises(pf.SettingError, match="has to be below top_m"):
        pf.CloudProbe(planet_of(even(2000.0, 1000.0, 1e-3)))
    with pf.CloudProbe(planet_of(even(1000.0, 2000.0, 1e-3))) as probe:
        question = ([0, 0, 6.4e6], [0, 0, 1], [0, 0, 1])
        with pytest.raises(ValueError, match=r"sun_visibility: expected one of .* found 'soft'"):
            probe.march(*question, sun_visibility="soft")
        with pytest.raises(ValueError, match=r"orders: expected None \(all\) or 1, found 3"):
            probe.march(*question, orders=3)
        with pytest.raises(ValueError, match=r"directions\[0\]: expected finite numbers"):
            probe.march([0, 0, 6.4e6], [0, np.nan, 1], [0, 0, 1])
        with pytest.raises(ValueError, match=r"max_distance_m"):
            probe.march(*question, max_distance_m=-1.0)
    with pytest.raises(ValueError, match="released"):
        probe.march(*question)
