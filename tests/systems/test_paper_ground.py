"""The printed grid's ground: the scene's relief, named views with their subjects, and what each layer adds. No GPU."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure.paper_relief import relief_m, square_around
from planetfall.engine.space import direction, heading_pitch_axes
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.paper_ground import MOST_LAYERS, PaperField

RADIUS_M = 6.371e6
VIEWS = ("ground", "near", "coast", "valley", "beach", "high", "orbit", "space", "limb", "sea", "sunset", "pole")
PRINTED = ("ground", "near", "coast", "valley", "beach")
"""Views with a place of their own on this ground."""


@pytest.fixture(scope="module")
def scene():
    return pf.load_scene("earth")


@pytest.fixture(scope="module")
def params(scene):
    return TerrainParams.from_component(scene.planet[pf.Terrain], RADIUS_M)


@pytest.fixture(scope="module")
def field(params):
    return PaperField(params, 5)


def zenith_of(scene, name, printed=False):
    placed = pf.view(name).in_scene(scene)
    if printed:
        return direction(placed.printed_place.latitude_deg, placed.printed_place.longitude_deg)
    return placed.pose.position_m / np.linalg.norm(placed.pose.position_m)


def ahead(scene, name, distances_m, within_deg=30.0):
    """Directions (distances, 9, 3) in front of a view's camera on the printed ground."""
    place, up = pf.view(name).in_scene(scene).printed_place, zenith_of(scene, name, printed=True)
    turns = [heading_pitch_axes(up, place.heading_deg + off, 0.0)[0] for off in np.linspace(-within_deg, within_deg, 9)]
    angle = np.asarray(distances_m)[:, None, None] / RADIUS_M
    return np.cos(angle) * up + np.sin(angle) * np.array(turns)


def heights(field, directions):
    return field.height(directions.reshape(-1, 3)).reshape(directions.shape[:-1])


@pytest.mark.parametrize("name", VIEWS)
def test_relief_is_the_scenes(scene, field, name):
    there = zenith_of(scene, name)
    own = relief_m(scene.planet.height_field(), there, RADIUS_M)
    assert relief_m(field, there, RADIUS_M) == pytest.approx(own, rel=0.2)


def test_mountains_and_plains_are_where_the_scenes_are(scene, field):
    valley, plain = (zenith_of(scene, name) for name in ("valley", "space"))
    assert relief_m(field, valley, RADIUS_M) > 8.0 * relief_m(field, plain, RADIUS_M)


def test_each_layer_adds_what_is_narrower(scene, params):
    """Layer k is 2^k times narrower than the first: ground without it is smooth there, ground with it is not."""
    there = square_around(zenith_of(scene, "valley"), 100e3, RADIUS_M, 24)
    drawn = [PaperField(params, layers).height(there) for layers in range(MOST_LAYERS + 1)]
    added = [float(np.std(b - a)) for a, b in pairwise(drawn)]
    assert added[0] > 2.0 * float(drawn[0].std()), "the continents alone are smooth"
    for before, after in pairwise(added):
        assert 0.4 < after / before < 0.75
    assert added[-1] > 1.0


@pytest.mark.parametrize("name", PRINTED)
def test_a_view_of_its_own_lies_near_the_scenes(scene, name):
    off = np.linalg.norm(zenith_of(scene, name) - zenith_of(scene, name, printed=True)) * RADIUS_M
    assert off < 100e3, "so that sun and hour stay"


def test_the_coast_is_one(scene, field):
    found = heights(field, ahead(scene, "coast", np.geomspace(500.0, 15e3, 20)))
    assert 0.2 < np.mean(found > 0.0) < 0.8


def test_the_valley_has_mountains_around(scene, field):
    floor = float(field.height(zenith_of(scene, "valley", printed=True)[None])[0])
    found = heights(field, ahead(scene, "valley", np.geomspace(2e3, 40e3, 30)))
    assert 0.0 < floor < 1000.0
    assert np.median(found.max(axis=0)) > floor + 1000.0


def test_the_beach_has_the_sea_in_front(scene, field):
    here = float(field.height(zenith_of(scene, "beach", printed=True)[None])[0])
    assert 0.5 < here < 3.0
    assert np.mean(heights(field, ahead(scene, "beach", np.geomspace(200.0, 5e3, 20))) < 0.0) > 0.4
