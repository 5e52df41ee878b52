"""Tiles of cloud without cirrus are marched by a program that has none of its code: to the same bits."""

from __future__ import annotations

import numpy as np
import pytest
from cloud_kit import texture
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.systems.clouds import view_march

pytestmark = pytest.mark.gpu


def rays(name: str) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """What the rays found, and what their tiles meet."""
    with preset_scene("earth", True) as scene, pf.Renderer(scene, (320, 180), "medium") as renderer:
        renderer.render(pf.view(name))
        found = texture(renderer, "clouds.rays")
        with renderer.current():
            return found, np.frombuffer(renderer.graph.resource("clouds.tile_flags").read(), np.uint32)


@pytest.mark.parametrize("name", ["clouds", "high"])
def test_tiles_without_ice_are_as_the_whole_program_has_them(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found, kinds = rays(name)
    assert (kinds == 2).any(), "no tile without cirrus"
    monkeypatch.setattr(view_march, "NO_CIRRUS", {})
    whole, _ = rays(name)
    assert np.array_equal(found, whole)
