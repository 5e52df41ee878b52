"""How much of the sphere is covered: against the table, against extended precision, and for every camera of a proxy."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from planetfall.engine.space import direction
from planetfall.engine.surface.coverage import coverage, proxy_coverage
from planetfall.engine.surface.proxy import snap_proxy

LONG = np.longdouble
TABLE = Path(__file__).parents[1] / "data" / "terrain_zs.csv"
RADII = (1e3, 1e5, 1737.4e3, 6.371e6, 6.9911e7)
ALTITUDES = (0.0, 1e-6, 1e-2, 1.7, 100.0, 1e4, 1e6, 1e9)


def exact_angle(altitude, radius, highest, lowest=0.0):
    inner = LONG(radius) + LONG(min(lowest, 0.0))
    total = LONG(0)
    for above in (LONG(altitude) + (radius - inner), LONG(highest) + (radius - inner)):
        a = max(above, LONG(0))
        total += np.arctan2(np.sqrt(a * (2 * inner + a)), inner)
    return total


def arc_error(found, exact) -> float:
    """Error of the arc that z_s covers, as a multiple of the radius."""
    return abs(float(np.arctan2(LONG(1), LONG(found.z_s)) - exact))


def test_table():
    rows = list(csv.DictReader(TABLE.open()))
    assert len(rows) > 70
    for row in rows:
        r, peak, alt = (float(row[k]) for k in ("r", "H", "alt"))
        found = coverage(alt, r, peak)
        assert found.z_s == pytest.approx(float(row["zs"]), rel=1e-12, abs=1e-15)
        assert found.half_angle_rad == pytest.approx(float(row["theta_cover"]), rel=1e-14)
        assert found.arc_m == pytest.approx(float(row["arc_cover_m"]), abs=1e-9 * r)
        assert abs(np.arctan2(1.0, found.z_s) - float(row["theta_cover"])) < 1e-9
        if row["below_peak"] == "1":
            assert alt < peak


@pytest.mark.parametrize("radius", RADII)
def test_arc_everywhere(radius):
    worst = 0.0
    for altitude in ALTITUDES:
        for peak in (0.0, 1e-6, 1e-4, 1e-3, 0.01, 0.1):
            for low in (0.0, -1e-5, -1e-3, -0.05):
                found = coverage(altitude, radius, peak * radius, low * radius)
                assert np.isfinite(found.z_s)
                assert np.isfinite(found.half_angle_rad)
                worst = max(worst, arc_error(found, exact_angle(altitude, radius, peak * radius, low * radius)))
                for sideways in (1e-9, 1e-3, 0.3):
                    wide = proxy_coverage(altitude, sideways, radius, peak * radius, low * radius)
                    exact = exact_angle(altitude, radius, peak * radius, low * radius) + LONG(sideways)
                    if exact < np.pi - 1e-6:
                        worst = max(worst, arc_error(wide, exact))
    assert worst <= 1e-9


def test_low_ground_is_measured_from_the_low_sphere():
    # 500 m below the reference sphere an observer at 2 m sees 80 km farther than the reference sphere says.
    without = coverage(2.0, 6.371e6, 0.0).half_angle_rad
    with_low = coverage(2.0, 6.371e6, 0.0, -500.0).half_angle_rad
    assert (with_low - without) * 6.371e6 > 80e3
    # Camera below the reference sphere, above its ground.
    below = coverage(-499.0, 6.371e6, 0.0, -500.0)
    assert below.arc_m == pytest.approx(np.sqrt(2 * 6.371e6) + np.sqrt(1000 * 6.371e6), rel=1e-3)


def test_whole_sphere_and_grid_offset():
    whole = coverage(1e9, 1e3, 1e12)
    assert whole.half_angle_rad <= np.pi
    assert np.isfinite(whole.z_s)
    assert proxy_coverage(1e9, 2.0, 1e3, 2e4).half_angle_rad == np.pi
    tall = coverage(5000.0, 1e3, 2e4)
    assert tall.z_s < 0
    assert tall.grid_offset == pytest.approx(np.sqrt(2) * tall.z_s)
    flat = coverage(5000.0, 1e3, 0.0)
    assert flat.grid_offset == flat.z_s


def test_nonsense_is_refused():
    for bad in ((np.nan, 1e3, 0.0), (1.0, -5.0, 0.0), (1.0, 1e3, 0.0, -1e3), (1.0, 1e3, np.inf)):
        with pytest.raises(ValueError, match="coverage: expected finite"):
            coverage(*bad)


@pytest.mark.parametrize("radius", [1e3, 6.371e6, 7e7])
@pytest.mark.parametrize("altitude", [0.01, 2.0, 3e3, 1e6, 1e9])
def test_the_farthest_peak_is_inside_for_every_camera_of_a_proxy(radius, altitude):
    rng = np.random.default_rng(int(altitude * 100) % 1000)
    for peak, low in ((0.0, 0.0), (0.001 * radius, -1e-4 * radius), (0.1 * radius, -0.05 * radius)):
        ground = rng.uniform(low, peak)

        def height(d, ground=ground):
            return np.full(len(d), ground)

        start = direction(rng.uniform(-90, 90), rng.uniform(-180, 180)) * (radius + ground + altitude)
        proxy = snap_proxy(start, radius, height, None)
        found = proxy_coverage(proxy.highest_altitude_m, proxy.max_sideways_rad, radius, peak, low)
        held = 0
        for _ in range(40):
            away = rng.normal(size=3)
            away /= np.linalg.norm(away)
            place = proxy.direction + away * proxy.max_sideways_rad * rng.uniform(0, 1.05)
            place /= np.linalg.norm(place)
            alt = rng.uniform(max(proxy.lowest_altitude_m, ground), proxy.highest_altitude_m)
            camera = place * (radius + alt)
            if not proxy.contains(camera):
                continue
            held += 1
            sideways = 2 * np.arctan2(np.linalg.norm(place - proxy.direction), np.linalg.norm(place + proxy.direction))
            altitude_now = np.linalg.norm(camera) - radius
            needed = float(exact_angle(altitude_now, radius, peak, low)) + sideways
            assert min(needed, np.pi) <= found.half_angle_rad * (1 + 1e-13) + 1e-13
        assert held > 5
