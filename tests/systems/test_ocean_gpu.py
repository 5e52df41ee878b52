"""The waves as shaders compute them against float64; normals against differences of the displacement."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.benchmarks.measure.waves import around as directions_around
from planetfall.benchmarks.measure.waves import degrees_between, true_normals
from planetfall.components import Ocean, Wave
from planetfall.engine.space import direction
from planetfall.engine.waves import displacement, waves_of
from planetfall.systems.ocean.wave_probe import WaveQuestions

pytestmark = pytest.mark.gpu

RADII = (6.371e6, 7.0e7)
TIMES = (0.0, 1e5, 1e8)
REACH_M = 1000.0
ORIGINS = ((20.0, 30.0), (-50.0, 140.0))


def open_sea(**more):
    return Ocean(wave_count=20, wind_speed_m_s=10.0, fetch_m=4e5, **more)


def rings(amplitude=1.0):
    """Waves whose origins one can stand at, and others that pass there."""
    return Ocean(
        waves=(
            Wave(ORIGINS[0], amplitude, 60.0, 0.6),
            Wave(ORIGINS[1], 0.6 * amplitude, 25.0, 0.5, 1.7),
            Wave((-80.0, -60.0), 0.3 * amplitude, 11.0, 0.4),
        )
    )


PLACES = {
    "open": (24.0, -78.0),
    "pole": (90.0, 0.0),
    "date line": (-31.0, 180.0),
    "cube corner": (35.264389682754654, 45.0),
    "at an origin": ORIGINS[0],
    "300 m from an origin": (20.0, 30.0 + 300.0 / (6.371e6 * np.cos(np.radians(20.0))) * 180.0 / np.pi),
    "antipode": (-ORIGINS[0][0], ORIGINS[0][1] - 180.0),
    "near another antipode": (-ORIGINS[1][0] + 0.004, ORIGINS[1][1] - 180.0),
}


def around(anchor, radius_m, count=1500, seed=3):
    return directions_around(anchor, radius_m, np.random.default_rng(seed), count, REACH_M)


@pytest.fixture
def ask(gpu):
    scopes = []

    def make(ocean, radius_m):
        scope = gpu.scope("waves under test")
        scopes.append(scope)
        waves = waves_of(ocean, radius_m)
        return waves, WaveQuestions(scope, waves, radius_m)

    yield make
    for scope in scopes:
        scope.release()


@pytest.mark.parametrize("radius_m", RADII)
@pytest.mark.parametrize("place", PLACES)
def test_within_a_millimetre_and_a_twentieth_of_a_degree(ask, place, radius_m):
    anchor = direction(*PLACES[place])
    for ocean in (open_sea(), rings()):
        waves, questions = ask(ocean, radius_m)
        v = around(anchor, waves.radius_m)
        for time_s in TIMES:
            found = questions.ask(anchor, v, time_s)
            off = np.linalg.norm(found.displacement_m - displacement(waves, v, time_s), axis=1)
            assert off.max() <= 1e-3
            assert degrees_between(found.normal, true_normals(waves, v, time_s)).max() <= 0.05


def test_shallow_water_and_coarse_samples_as_in_float64(ask):
    anchor = direction(10.0, 20.0)
    waves, questions = ask(open_sea(), RADII[0])
    v = around(anchor, waves.radius_m)
    rng = np.random.default_rng(5)
    depth, spacing = 10.0 ** rng.uniform(-2.0, 3.0, len(v)), 10.0 ** rng.uniform(-1.0, 2.0, len(v))
    depth[:50] = 0.0
    found = questions.ask(anchor, v, 77.0, depth, spacing)
    off = np.linalg.norm(found.displacement_m - displacement(waves, v, 77.0, depth, spacing), axis=1)
    assert off.max() <= 1e-3
    assert np.abs(found.displacement_m[:50]).max() <= 1e-6, "at the shore nothing moves"


def test_the_anchor_does_not_matter(ask):
    """A snap changes nothing: two anchors a kilometre apart agree on the points between them."""
    for place in ("open", "300 m from an origin"):
        waves, questions = ask(rings(), RADII[0])
        here = direction(*PLACES[place])
        there = around(here, waves.radius_m, 1, seed=8)[0]
        v = around(here, waves.radius_m)
        a, b = questions.ask(here, v, 1e5), questions.ask(there, v, 1e5)
        assert np.linalg.norm(a.displacement_m - b.displacement_m, axis=1).max() <= 1e-3
        assert degrees_between(a.normal, b.normal).max() <= 0.05


@pytest.mark.parametrize(
    ("first", "last"),
    [
        ((10.0, 179.999), (10.0, -179.999)),
        ((89.999, 20.0), (89.999, -160.0)),
        ((44.9995, 0.0), (45.0005, 0.0)),
        ((35.2635, 44.9985), (35.2655, 45.0015)),
        ((20.0 - 0.002, 30.0), (20.0 + 0.002, 30.0)),
        ((-20.0 - 0.002, -150.0), (-20.0 + 0.002, -150.0)),
    ],
    ids=["date line", "pole", "edge of cube faces", "corner", "origin", "antipode"],
)
def test_no_seam(ask, first, last):
    """Along a line over a place where a map would tear, each step is as long as its neighbours."""
    _, questions = ask(rings(), RADII[0])
    a, b = direction(*first), direction(*last)
    line = a + np.linspace(0.0, 1.0, 2001)[:, None] * (b - a)
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    middle = line[1000]
    found = questions.ask(middle, line, 1e5)
    for values in (found.displacement_m, found.normal):
        steps = np.linalg.norm(np.diff(values, axis=0), axis=1)
        around_it = np.delete(steps[950:1050], slice(45, 55))
        assert steps[995:1005].max() <= 1.5 * around_it.max() + 1e-4


def test_printed_formulas_in_float32_are_lost(ask):
    """What the float64 anchors are for: arcs in float32 are off by wavelengths, and at late times phases are noise."""
    waves, questions = ask(rings(), RADII[0])
    anchor = direction(*PLACES["open"])
    v = around(anchor, waves.radius_m)
    truth = displacement(waves, v, 1e8)
    for method in ("paper_2018", "paper_2019"):
        off = np.linalg.norm(questions.ask(anchor, v, 1e8, method=method).displacement_m - truth, axis=1)
        assert np.median(off) > 0.1
    assert np.linalg.norm(questions.ask(anchor, v, 1e8).displacement_m - truth, axis=1).max() <= 1e-3
