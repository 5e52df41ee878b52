"""The printed march against its own recurrences in float64, and beside what it approximates."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from air_tables import over_the_pole, towards
from cloud_tables import even, planet_of

import planetfall as pf
from planetfall.benchmarks.reference.cloud_slab import henyey_greenstein, slab_single

STEPS, SAMPLES = 40, 6


def _printed(depth: float, asymmetry: float) -> tuple[float, float]:
    """(light, transmittance) straight down through an even layer under the sun: equations 15 and 16."""
    through, light = 1.0, 0.0
    # Segments of a quarter of the thickness, each a quarter longer than the last, in steps of at most a fortieth.
    edges, length = [0.0], 0.25
    while edges[-1] < 1.0:
        edges.append(min(edges[-1] + length, 1.0))
        length *= 1.25
    for start, end in itertools.pairwise(edges):
        steps = int(np.ceil((end - start) * STEPS * (1.0 - 1e-6)))
        for i in range(steps):
            place = start + (end - start) * (i + 0.5) / steps
            taken = depth * (end - start) / steps
            through *= np.exp(-taken)
            light += float(henyey_greenstein(-1.0, asymmetry)) * taken * np.exp(-depth * place) * through
    return light, through


@pytest.mark.parametrize("method", ["paper_2018", "paper_2019"])
@pytest.mark.parametrize("depth", [0.5, 5.0, 50.0])
def test_one_layer_under_the_sun(method: str, depth: float) -> None:
    clouds = even(1000.0, 2000.0, depth / 1000.0, 1.0, 0.5)
    clouds.method = method
    with pf.CloudProbe(planet_of(clouds, 1e8)) as probe:
        light, through = probe.march(over_the_pole([5000.0], 1e8), towards([180.0]), towards([0.0]), orders=1)
    wanted = _printed(depth, 0.5)
    # A layer of 1000 m on this planet has its steps to 1e-5 of their length in single precision.
    assert light[0, 0] == pytest.approx(wanted[0], rel=1e-3)
    # Where less than 1e-7 comes through the march ends.
    assert through[0, 0] == pytest.approx(wanted[1], rel=1e-3, abs=1e-7)


def test_its_light_is_too_dark_where_steps_are_deep() -> None:
    # Each step's light is dimmed by the whole of it: x / (e^x - 1) of what leaves it.
    clouds = even(1000.0, 2000.0, 0.05, 1.0, 0.0)
    clouds.method = "paper_2018"
    truth = float(slab_single(50.0, 1.0, 0.0, 0.0, 180.0, 0.0)[0])
    with pf.CloudProbe(planet_of(clouds, 1e8)) as probe:
        light, _ = probe.march(over_the_pole([5000.0], 1e8), towards([180.0]), towards([0.0]), orders=1)
    assert light[0, 0] < 0.6 * truth


def test_both_ways_to_put_air_and_clouds_together_agree_without_clouds() -> None:
    found = []
    for method in ("ours", "paper_2018", "paper_2019"):
        clouds = even(1000.0, 2000.0, 1e-9)
        clouds.method = method
        with pf.CloudProbe(planet_of(clouds, air=pf.Atmosphere()), overrides={"clouds.air_steps": 48}) as probe:
            found.append(probe.march(over_the_pole([10.0, 4e5]), towards([60.0, 170.0]), towards([40.0]), orders=1)[0])
    np.testing.assert_allclose(found[1], found[2], rtol=1e-5)
    # Eight slices of the air in each of its three parts.
    np.testing.assert_allclose(found[0], found[1], rtol=1e-2)
