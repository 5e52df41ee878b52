"""Kinds of cloud by name: their heights, what sets each apart, and what is refused."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components import Atmosphere, Clouds, Ocean, Terrain
from planetfall.components.clouds import KIND_LAYERS
from planetfall.systems.clouds.kinds import finer_of, shape_of
from planetfall.systems.clouds.layers import kind_of
from planetfall.systems.clouds.view_block import CloudKind

KNOBS = {"clouds.map_texels": 256, "clouds.fibre_texels": 64}
WIDTH_M, SIDE = 60e3, 48


def filled(kind: str, share: float, **fields: float) -> NDArray[np.float64]:
    """(4 SIDE^2,): whether there is cloud at a share of the height, over squares of 60 km."""
    scene = preset_scene("earth", True)
    clouds = scene.planet[Clouds]
    layer = pf.CloudLayer.of(kind, **{"extinction_per_m": 0.1, "coverage": 0.5, **fields})
    clouds.layers = ()
    for name in ("kind", "base_m", "top_m", "extinction_per_m", "coverage"):
        setattr(clouds, name, getattr(layer, name))
    for part in (Terrain, Ocean, Atmosphere):
        scene.planet.remove(part)
    radius_m = scene.planet.radius_m
    thick_m = 0.02 * (layer.top_m - layer.base_m)
    height_m = layer.base_m + share * (layer.top_m - layer.base_m) + 0.5 * thick_m
    found = []
    with pf.CloudProbe(scene, quality="medium", overrides=KNOBS) as probe:
        for latitude, longitude in ((48.0, -30.0), (5.0, 30.0), (-52.0, 100.0), (35.0, 150.0)):
            up = np.asarray(pf.direction(latitude, longitude))
            east = np.cross([0.0, 0.0, 1.0], up)
            east /= np.linalg.norm(east)
            aside = ((np.arange(SIDE) + 0.5) / SIDE - 0.5) * WIDTH_M / radius_m
            ways = up + aside[None, :, None] * east + aside[:, None, None] * np.cross(up, east)
            ways = (ways / np.linalg.norm(ways, axis=2, keepdims=True)).reshape(-1, 3)
            _, through = probe.march(ways * (radius_m + height_m), -ways, up, max_distance_m=thick_m)
            found.append(1.0 - through[:, 0])
    return np.concatenate(found)


@pytest.mark.parametrize("kind", KIND_LAYERS)
def test_a_kind_has_heights_of_its_own_that_fields_replace(kind: str) -> None:
    layer = pf.CloudLayer.of(kind)
    assert {name: getattr(layer, name) for name in KIND_LAYERS[kind]} == KIND_LAYERS[kind]
    assert (layer.kind, kind_of(layer)) == (kind, CloudKind.CUMULUS)
    assert layer.top_m > layer.base_m
    assert pf.CloudLayer.of(kind, base_m=10.0).base_m == 10.0
    assert isinstance(pf.Clouds.of(kind), pf.Clouds)
    assert shape_of(layer).follows == 0.0


def test_kinds_that_are_not_there_are_refused_with_what_was_meant() -> None:
    with pytest.raises(pf.SettingError, match=r"kind: .*did you mean 'stratocumulus'"):
        pf.CloudLayer.of("stratocumulos")


def test_noise_is_finer_by_whole_numbers_and_never_coarser() -> None:
    altocumulus = pf.CloudLayer.of("altocumulus")
    assert finer_of(altocumulus, 19200.0) == 6  # 8 thicknesses of 400 m
    assert finer_of(altocumulus, 1000.0) == 1
    assert finer_of(pf.CloudLayer(), 19200.0) == 1


@pytest.mark.gpu
def test_each_kind_is_drawn_as_no_other_in_the_same_layer() -> None:
    """At 0.5 and at 0.85 of one layer's height, of one cover and extinction."""
    same = {"base_m": 1000.0, "top_m": 3000.0}
    kinds = ("cumulus", *KIND_LAYERS)
    seen = {kind: np.stack([filled(kind, share, **same) for share in (0.5, 0.85)]) for kind in kinds}
    for one, other in combinations(seen, 2):
        assert np.abs(seen[one] - seen[other]).mean() > 0.02, (one, other)


@pytest.mark.gpu
def test_anvils_are_wider_than_the_towers_below_them_and_towers_taper() -> None:
    low, waist, anvil = (filled("cumulonimbus", share).mean() for share in (0.1, 0.65, 0.88))
    assert anvil > 1.5 * waist
    assert low > waist
    congestus = [filled("congestus", share).mean() for share in (0.1, 0.5, 0.85)]
    assert congestus[0] > congestus[1] > congestus[2] > 0.0
