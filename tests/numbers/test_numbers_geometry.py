"""Numbers that the project promises and that need no ground: vertex positions and coverage."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.benchmarks import exact
from planetfall.benchmarks.measure import coverage
from planetfall.benchmarks.measure.positions import PositionProbe
from planetfall.benchmarks.measure.positions_icosphere import IcospherePositions, special_places

needs_extended = pytest.mark.skipif(not exact.EXTENDED, reason="long double is no wider than double on this machine")


@needs_extended
@pytest.mark.gpu
@pytest.mark.parametrize("radius_m", [1e3, 6.371e6, 7e7])
def test_undisplaced_vertices_are_within_a_thousandth_of_a_pixel(gpu, radius_m):
    rng = np.random.default_rng(4)
    with PositionProbe(gpu) as probe:
        for altitude_m in (1.0, 2.0, 100.0, 1e4, 2e6, 1e9):
            found = probe.measure(radius_m, altitude_m, rng, most=6000)
            assert found.not_finite == 0
            assert found.worst_px <= 1e-3, f"altitude {altitude_m:g} m"


@pytest.mark.gpu
def test_no_nan_down_to_one_centimetre(gpu):
    rng = np.random.default_rng(5)
    with PositionProbe(gpu) as probe:
        for radius_m in (1e3, 6.371e6, 7e7):
            assert probe.measure(radius_m, 0.01, rng, most=6000).not_finite == 0


@pytest.mark.gpu
def test_planet_coordinates_in_f32_would_be_hundreds_of_pixels_off(gpu):
    """The measure is worth something: it sees what the anchors are for."""
    with PositionProbe(gpu) as probe:
        assert probe.measure(6.371e6, 2.0, np.random.default_rng(6), most=6000).baseline_px > 10.0


def test_the_covered_arc_is_exact():
    found = coverage.arc_errors(np.random.default_rng(7), 3000)
    assert found.not_finite == 0
    assert found.worst_arc_r <= 1e-9 and found.worst_short_r <= 1e-9


def test_every_camera_of_a_proxy_finds_its_farthest_peaks_in_the_grid():
    rng = np.random.default_rng(8)
    for _ in range(40):
        radius = 10.0 ** rng.uniform(3.0, np.log10(7e7))
        relief = 0.1 * radius * 10.0 ** rng.uniform(-6.0, 0.0)
        found = coverage.proxy_covers(radius, 10.0 ** rng.uniform(-2.0, 9.0), relief, -relief, rng, cameras=12)
        assert found.worst_missing_r <= 1e-9 and found.outside == 0


@needs_extended
@pytest.mark.gpu
@pytest.mark.parametrize("radius_m", [6.371e6, 7e7])
def test_the_icospheres_vertices_are_within_a_thousandth_of_a_pixel_on_all_levels(gpu, radius_m):
    rng = np.random.default_rng(9)
    with IcospherePositions(gpu) as probe:
        for level in range(25):
            for place in (*special_places(), *rng.normal(size=(3, 3))):
                assert probe.worst_px(radius_m, level, place) <= 1e-3, f"level {level}, {place}"
