"""Gallery woods: banks of rivers and lakes count as wetter, in float64 and on the GPU, and no tree goes for it."""

from __future__ import annotations

import numpy as np
import pytest
from cover_kit import names_of

import planetfall as pf
from planetfall.engine.frame.gbuffer import Surface
from planetfall.systems.cover.growth import Growing
from planetfall.systems.terrain.ground_params import ground_params
from planetfall.systems.terrain.height import TerrainField

BANK = pf.direction(-15.79452, 150.4181)
"""Of a river 40 m wide in a warm desert."""


@pytest.fixture(scope="module")
def scene():
    with pf.load_scene("woods") as found:
        found.planet.remove(pf.Clouds)
        yield found


@pytest.fixture(scope="module")
def field(scene):
    return TerrainField(ground_params(scene.planet[pf.Terrain], scene.planet.radius_m, True))


def around(direction: np.ndarray, away_m: float, radius_m: float, count: int = 4000) -> np.ndarray:
    rng = np.random.default_rng(3)
    found = direction + rng.uniform(-1.0, 1.0, (count, 3)) * (away_m / radius_m)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_banks_are_wetter_and_it_ends_100_m_away(scene, field):
    places = around(BANK, 400.0, field.radius_m)
    near = field.beside_water(places)
    assert ((near >= 0.0) & (near <= 1.0)).all() and (near == 1.0).any() and (near == 0.0).any()
    height = field.height(places)
    wet = field.is_wet(places, height)
    assert wet.any() and (near[wet] == 1.0).all()
    terrain = scene.planet[pf.Terrain]
    dry, half, full = (
        Growing.of(terrain, 0.0, 0.12, riparian).climate(field, places, height).humidity for riparian in (0.0, 0.5, 1.0)
    )
    np.testing.assert_array_equal(full[near == 0.0], dry[near == 0.0])
    np.testing.assert_allclose(full - dry, 0.36 * near, atol=1e-12)
    np.testing.assert_allclose(half - dry, 0.18 * near, atol=1e-12)


def test_it_changes_gradually(field):
    way = np.cross(BANK, [0.0, 0.0, 1.0])
    places = BANK + np.linspace(-500.0, 500.0, 4001)[:, None] / field.radius_m * way / np.linalg.norm(way)
    near = field.beside_water(places / np.linalg.norm(places, axis=1, keepdims=True))
    # A quarter of a metre apart, of a ramp 100 m long; lines' widths change along them.
    assert np.abs(np.diff(near)).max() < 0.02 and near.max() > 0.5


def test_trees_come_and_none_goes(scene):
    found = {}
    cover = scene.planet[pf.Cover]
    # Its agaves are the desert's own, and do leave what is wet.
    own, cover.species = cover.species, ()
    for riparian in (0.0, 1.0):
        cover.riparian = riparian
        found[riparian] = pf.CoverSampler(scene).within(BANK, 400.0)
    cover.species = own
    before, after = names_of(found[0.0]), names_of(found[1.0])
    assert before <= after and len(after) > len(before) + 100
    # All that came stand on banks.
    sampler = TerrainField(ground_params(scene.planet[pf.Terrain], scene.planet.radius_m, True))
    came = [tuple(name) not in before for name in found[1.0].names.tolist()]
    assert (sampler.beside_water(found[1.0].up[came]) > 0.0).mean() > 0.7


def test_the_ground_is_as_green_where_trees_end(scene):
    """Beyond the trees the ground's own colour has them: greener along the river alone, with the knob."""
    cover, shown = scene.planet[pf.Cover], {}
    latitude, longitude = (float(v) for v in pf.latitude_longitude(BANK))
    camera = pf.Camera.at(latitude, longitude, 900.0, pitch_deg=-90.0, above="ground")
    sun = pf.Sun(elevation_deg=50.0, azimuth_deg=180.0, latitude_deg=latitude, longitude_deg=longitude)
    overrides = {"cover.reach_m": 100.0, "composite.antialiasing": "none"}
    with pf.Renderer(scene, (160, 90), "low", overrides) as renderer:
        for riparian in (0.0, 1.0):
            cover.riparian = riparian
            renderer.settle(camera)
            out = renderer.render(camera, sun=sun, outputs=("albedo", "position", "surface"))
            shown[riparian] = {name: value.copy() for name, value in out.items()}
        eye = renderer.camera_state(camera).position_m
    # Water narrower than a pixel throws nothing back.
    land = (shown[0.0]["surface"] == Surface.TERRAIN) & (shown[0.0]["albedo"].min(axis=-1) > 0.02)
    place = shown[0.0]["position"][land] + eye
    field = TerrainField(ground_params(scene.planet[pf.Terrain], scene.planet.radius_m, True))
    near = field.beside_water(place / np.linalg.norm(place, axis=1, keepdims=True))
    dry, wet = (shown[k]["albedo"][land].sum(axis=-1) for k in (0.0, 1.0))
    assert (near > 0.6).sum() > 50 and np.median(wet[near > 0.6] / dry[near > 0.6]) < 0.9
    assert np.median(np.abs(wet / dry - 1.0)[near == 0.0]) < 0.01
