"""The camera proxy: it is held, it is deterministic, it stands for the cameras it claims, on planets of all sizes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from planetfall.engine.space import direction
from planetfall.engine.surface.lattice import FULL_BITS, canonical_lattice, direction_of
from planetfall.engine.surface.proxy import snap_proxy

RADII = (1e3, 6.371e6, 7e7)
ALTITUDES = (0.01, 2.0, 500.0, 1e5, 3.6e7, 1e9)


def flat(directions):
    return np.zeros(len(directions))


def hills(directions):
    return 5.0 * np.sin(directions @ np.array([911.0, -953.0, 887.0]))


class Counted:
    def __init__(self, function):
        self.function, self.calls = function, 0

    def __call__(self, directions):
        self.calls += 1
        return self.function(directions)


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("altitude", ALTITUDES)
def test_a_still_camera_keeps_its_proxy_and_asks_nothing(radius, altitude):
    ground = Counted(flat)
    position = direction(31.0, 11.0) * (radius + altitude)
    first = snap_proxy(position, radius, ground, None)
    calls = ground.calls
    assert snap_proxy(position, radius, ground, first) is first
    assert ground.calls == calls
    assert first.generation == 0
    assert first.snap_distance_m == 0.0
    assert first.contains(position)
    assert first.lowest_altitude_m <= altitude + 1e-6 * radius * 1e-6
    assert first.highest_altitude_m >= altitude


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("altitude", ALTITUDES)
def test_where_it_is(radius, altitude):
    rng = np.random.default_rng(1)
    for _ in range(20):
        away = rng.normal(size=3)
        position = away / np.linalg.norm(away) * (radius + altitude)
        proxy = snap_proxy(position, radius, hills, None)
        again = snap_proxy(position, radius, hills, None)
        assert (proxy.face, proxy.i, proxy.j, proxy.altitude_above_ground_m) == (
            again.face, again.i, again.j, again.altitude_above_ground_m)  # fmt: skip
        named = canonical_lattice(proxy.face, proxy.i, proxy.j)
        assert (int(named[0]), int(named[1]), int(named[2])) == (proxy.face, proxy.i, proxy.j)
        assert proxy.i % (1 << (FULL_BITS - proxy.level)) == 0
        np.testing.assert_array_equal(proxy.direction, direction_of(proxy.face, proxy.i, proxy.j))
        anchor = proxy.anchor()
        assert (anchor.face, anchor.i, anchor.j) == (proxy.face, proxy.i, proxy.j)
        assert proxy.ground_height_m == float(hills(proxy.direction[None])[0])
        steps = np.log(proxy.altitude_above_ground_m / 0.01) / np.log(1.25)
        assert steps == pytest.approx(round(steps), abs=1e-6)
        clearance = altitude - float(hills(position[None] / np.linalg.norm(position))[0])
        if clearance > 0.01:
            assert 1 / 1.13 < proxy.altitude_above_ground_m / clearance < 1.13
            # Cells are no larger than a quarter of the altitude, unless the finest step or coarsest level binds.
            size = radius * np.pi / 2 * 2.0**-proxy.level
            assert size <= max(0.25 * proxy.altitude_above_ground_m, 0.05) or proxy.level == FULL_BITS


def test_it_moves_when_the_camera_leaves():
    radius = 6.371e6
    proxy = None
    seen = []
    for step in range(2000):
        position = direction(10.0, 20.0 + step * 1e-8) * (radius + 2.0)  # 1 mm steps along 2 m
        new = snap_proxy(position, radius, flat, proxy)
        assert new.contains(position)
        if new is not proxy:
            seen.append(new)
        proxy = new
    assert 2 <= len(seen) <= 8
    assert [p.generation for p in seen] == list(range(len(seen)))
    for a, b in pairwise(seen):
        assert b.snap_distance_m == pytest.approx(np.linalg.norm(b.position_m - a.position_m))
        assert 0.1 < b.snap_distance_m < 1.5


def test_it_does_not_flicker_on_a_border():
    radius = 6.371e6
    proxy, snaps = None, 0
    centre = snap_proxy(direction(10.0, 20.0) * (radius + 2.0), radius, flat, None)
    size = np.pi / 2 * 2.0**-centre.level
    for step in range(200):
        side = 0.5 + 0.05 * (-1) ** step
        place = centre.direction + np.array([0, 0, 1.0]) * size * side
        position = place / np.linalg.norm(place) * (radius + 2.0)
        new = snap_proxy(position, radius, flat, proxy)
        snaps += new is not proxy
        proxy = new
    assert snaps == 1
    proxy, snaps = None, 0
    for step in range(200):  # the same for altitudes at the limit between two steps
        new = snap_proxy(direction(10.0, 20.0) * (radius + 2.0 * 1.25 ** (0.05 * (-1) ** step)), radius, flat, proxy)
        snaps += new is not proxy
        proxy = new
    assert snaps == 1


def test_early_update_recentres():
    radius = 6.371e6
    start = snap_proxy(direction(10.0, 20.0) * (radius + 2.0), radius, flat, None)
    place = start.direction + np.array([0, 0, 1.0]) * start.max_sideways_rad * 0.9
    position = place / np.linalg.norm(place) * (radius + 2.0)
    assert snap_proxy(position, radius, flat, start) is start
    early = snap_proxy(position, radius, flat, start, may_update_early=True)
    assert early is not start
    assert np.linalg.norm(early.direction - place) < np.linalg.norm(start.direction - place)
    # Where nothing better is to be had, nothing changes.
    assert snap_proxy(start.direction * (radius + 2.0), radius, flat, start, may_update_early=True) is start


@pytest.mark.parametrize("radius", RADII)
def test_whole_descents(radius):
    proxy = None
    count = 0
    for altitude in np.geomspace(1e8, 0.02, 3000):
        position = direction(46.0 + 1e-9 * altitude, 7.0) * (radius + altitude)
        new = snap_proxy(position, radius, flat, proxy)
        assert new.contains(position)
        count += new is not proxy
        proxy = new
    assert count < 250  # 100 altitude steps and the lattice's refinements


def test_camera_in_the_ground_and_nonsense():
    inside = snap_proxy(direction(0, 0) * (6.371e6 - 30.0), 6.371e6, flat, None)
    assert inside.altitude_above_ground_m == 0.01
    assert inside.contains(direction(0, 0) * (6.371e6 - 30.0))
    for bad in ((0, 0, 0), (np.nan, 0, 0)):
        with pytest.raises(ValueError, match="position_m"):
            snap_proxy(bad, 6.371e6, flat, None)
    with pytest.raises(ValueError, match="radius_m"):
        snap_proxy((1, 0, 0), -1.0, flat, None)
    with pytest.raises(ValueError, match="fraction"):
        snap_proxy((1, 0, 0), 1.0, flat, None, fraction=0.0)
