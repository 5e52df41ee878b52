"""Waterfalls: short steep lines that leave levels, ways and all other nodes as they were, and are drawn white."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from river_kit import walks

import planetfall as pf
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.rivers.falls import STEEPNESS, with_falls
from planetfall.systems.terrain.rivers.node_arrays import RiverNodes

EARTH = TerrainParams(mountains=0.4)


@pytest.fixture(scope="module")
def steep() -> RiverNodes:
    nodes = walks(EARTH, 60)
    left = np.maximum(6 - np.arange(len(nodes)) % 8, 0)
    return replace(nodes, level_m=(nodes.level_m[7::8].repeat(8) + 120.0 * left).astype(np.float32))


def test_falls_are_steep_and_no_level_climbs(steep: RiverNodes) -> None:
    found = with_falls(steep, EARTH.radius_m)
    count, many = len(steep), (len(found) - len(steep)) // 2
    assert 40 < many < 300
    lip, foot = count + np.arange(many), count + many + np.arange(many)
    assert np.array_equal(found.to[lip], foot)
    upper = np.flatnonzero(found.to >= 0)
    assert (found.level_m[upper] >= found.level_m[found.to[upper]]).all()
    height_m = found.level_m[lip] - found.level_m[foot]
    length_m = np.linalg.norm(found.direction[lip] - found.direction[foot], axis=1) * EARTH.radius_m
    assert height_m / length_m == pytest.approx(STEEPNESS, rel=1e-3)
    assert height_m.min() > 0.17 * 120.0 and height_m.max() <= 0.46 * 120.0
    # All other nodes are as they were, and go on to the same ones.
    line = np.flatnonzero(found.to[:count] != steep.to)
    assert np.array_equal(found.to[line], lip) and np.array_equal(found.to[foot], steep.to[line])
    for field in fields(RiverNodes):
        if field.name != "to":
            assert np.array_equal(getattr(found, field.name)[:count], getattr(steep, field.name)), field.name


def test_how_much_water_there_is_moves_no_fall(steep: RiverNodes) -> None:
    whole = with_falls(steep, EARTH.radius_m)
    part = with_falls(replace(steep, discharge_m3_s=steep.discharge_m3_s * np.float32(0.3)), EARTH.radius_m, 0.3)
    assert np.array_equal(whole.to, part.to) and np.array_equal(whole.direction, part.direction)
    flat = replace(steep, level_m=np.zeros_like(steep.level_m))
    assert len(with_falls(flat, EARTH.radius_m)) == len(steep)
    trickles = replace(steep, discharge_m3_s=np.full_like(steep.discharge_m3_s, 0.5))
    assert len(with_falls(trickles, EARTH.radius_m)) == len(steep)


@pytest.mark.gpu
def test_falling_water_is_white() -> None:
    """In the view `waterfall`: a part of the picture, brighter than all water around."""
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (320, 180), "medium") as renderer:
        camera = pf.view("waterfall", "earth")
        renderer.settle(camera)
        picture = renderer.render(camera, outputs=("color", "surface", "normal", "position"))
        state = renderer.camera_state(camera)
    water = picture["surface"] == 2
    up = np.nan_to_num(picture["position"]) + state.position_m
    up /= np.linalg.norm(up, axis=2)[..., None]
    steep = water & ((picture["normal"] * up).sum(axis=2) < 0.9)
    level = water & ((picture["normal"] * up).sum(axis=2) > 0.999)
    assert steep.mean() > 0.04 and level.mean() > 0.1
    light = picture["color"].astype(float)
    bright = [np.median(light[part].mean(axis=1)) for part in (steep, level)]
    assert bright[0] > 190.0 and bright[1] < 130.0
    # White: as much blue as red.
    assert abs(np.median(light[steep][:, 0]) - np.median(light[steep][:, 2])) < 20.0


@pytest.mark.gpu
def test_still_water_mirrors_falling_water() -> None:
    """In the middle of the mirrored fall: whiter and brighter than the sky that is mirrored without it."""
    light = {}
    for turns in (0, 24):
        with (
            pf.load_scene("earth") as scene,
            pf.Renderer(scene, (320, 180), "medium", overrides={"ocean.reflections": turns}) as renderer,
        ):
            scene.planet[pf.Terrain].spray = 0.0
            camera = pf.view("waterfall", "earth")
            renderer.settle(camera)
            light[turns] = renderer.render(camera, outputs=("color",))["color"][128:146, 130:200].astype(float)
    with_falls, sky_alone = (np.median(light[turns], axis=(0, 1)) for turns in (24, 0))
    assert with_falls[0] > sky_alone[0] + 15.0
    assert abs(with_falls[0] - with_falls[2]) < abs(sky_alone[0] - sky_alone[2])
