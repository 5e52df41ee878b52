"""Which kinds of trees stand where: flat-topped ones in savanna, palms along warm coasts, dead ones among all."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.systems.cover.stand import Species
from planetfall.systems.cover.trunks import Trunks


@pytest.fixture(scope="module")
def scene():
    with pf.load_scene("woods") as found:
        yield found


def around(scene, name, radius_m=150.0, **changes):
    """Plants around a view's place, and heights of the ground that they stand on over the sea's level."""
    cover = scene.planet[pf.Cover]
    before = {key: getattr(cover, key) for key in changes}
    try:
        for key, value in changes.items():
            setattr(cover, key, value)
        eye = pf.view(name, scene.planet).camera.resolve(scene).position_m
        found = pf.CoverSampler(scene).within(eye, radius_m)
    finally:
        for key, value in before.items():
            setattr(cover, key, value)
    trees = found.only(~np.isin(found.forms, (Species.SHRUB, Species.ROSETTE)))
    return trees, pf.TerrainSampler(scene).height(trees.positions_m) - scene.planet[pf.Ocean].sea_level_m


def share(plants, species):
    return float((plants.species == species).mean())


def test_savanna_has_few_trees_and_they_are_flat(scene):
    trees, _ = around(scene, "savanna")
    wood, _ = around(scene, "canopy")
    assert 0.02 * len(wood) < len(trees) < 0.25 * len(wood)
    assert share(trees, Species.ACACIA) > 0.8 and share(wood, Species.ACACIA) == 0.0
    flat = trees.only(trees.species == Species.ACACIA)
    assert (flat.radii_m > 0.4 * flat.heights_m).all()
    assert len(around(scene, "savanna", savanna=0.0)[0]) == 0


def test_palms_stand_along_warm_coasts_alone(scene):
    trees, height = around(scene, "palms", 400.0)
    palm = trees.species == Species.PALM
    assert palm.sum() > 100
    beach_m = scene.planet[pf.Terrain].beach_height_m
    # On the beach nothing else stands, and nothing at its foot; mangroves stand in the sea.
    in_sea = trees.species >= 8
    assert in_sea.any() and height[in_sea].max() < 0.1 * beach_m
    low = (height < beach_m) & ~in_sea
    assert low.sum() > 20 and palm[low].all() and height[low].min() > 0.2 * beach_m
    assert share(around(scene, "palms", 400.0, palms=0.0)[0], Species.PALM) == 0.0
    for inland in ("canopy", "treeline", "savanna"):
        assert share(around(scene, inland)[0], Species.PALM) == 0.0


def test_some_are_dead(scene):
    trees, _ = around(scene, "canopy", 300.0)
    count = len(trees)
    assert abs(share(trees, Species.DEAD) - 0.015) < 3.0 * np.sqrt(0.015 / count)
    assert share(around(scene, "canopy", 100.0, dead=0.0)[0], Species.DEAD) == 0.0
    assert share(around(scene, "canopy", 100.0, dead=1.0)[0], Species.DEAD) == 1.0


def test_other_species_leave_places_as_they_are(scene):
    """A game's names of trees hold, whichever of these is switched off."""
    one, _ = around(scene, "canopy", 100.0)
    two, _ = around(scene, "canopy", 100.0, dead=0.0, palms=0.0, savanna=0.0)
    np.testing.assert_array_equal(one.names, two.names)
    np.testing.assert_array_equal(one.positions_m, two.positions_m)


@pytest.mark.gpu
@pytest.mark.parametrize(("name", "species"), [("savanna", Species.ACACIA), ("palms", Species.PALM)])
def test_trunks_are_where_they_are_drawn(scene, name, species):
    """The pixel in which a trunk's middle at 0.3 of its height lies shows bark at the cone's distance."""
    view = pf.view(name, scene.planet)
    camera = view.camera.resolve(scene)
    plants = pf.CoverSampler(scene).within(camera.position_m, 60.0)
    plants = plants.only(plants.species == species)
    with pf.Renderer(scene, (640, 360), "low", {"composite.antialiasing": "none"}) as renderer:
        renderer.settle(view)
        distance = renderer.render(view, outputs=("distance",))["distance"].copy()
    trunks, seen = Trunks.of(plants), 0
    for k in range(len(plants)):
        place = trunks.feet_m[k] + 0.3 * plants.heights_m[k] * trunks.axes[k] - camera.position_m
        z = float(place @ camera.forward)
        x = (place @ camera.right / z - camera.tan_left) / (camera.tan_right - camera.tan_left) * 640.0
        y = (camera.tan_top - place @ camera.up / z) / (camera.tan_top - camera.tan_bottom) * 360.0
        if z < 5.0 or not (2.0 < x < 638.0 and 2.0 < y < 358.0):
            continue
        away = float(np.linalg.norm(place))
        pixel_m = away * (camera.tan_top - camera.tan_bottom) / 360.0
        if 1.4 * trunks.foot_radii_m[k] < 1.5 * pixel_m:  # the pixel's middle may lie beside it
            continue
        found = distance[int(y), int(x)]
        if found < away - 2.0:  # another stands in front
            continue
        seen += abs(found - away) < 1.0
        assert abs(found - away) < 1.0 or plants.heights_m[k] < 4.0, (k, found, away)
    assert seen >= 3
