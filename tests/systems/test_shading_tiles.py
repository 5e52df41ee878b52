"""Variants of shading by tile: pictures are those of the variant that does everything."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planetfall as pf
from planetfall.systems.terrain.shading import GroundShading

SIZE = (160, 90)
PLAIN = {"composite.antialiasing": "none"}


def picture(planet: str, name: str) -> tuple[np.ndarray[Any, Any], list[str]]:
    """Radiance of a view, and the passes that ran for it."""
    with pf.Renderer(pf.load_scene(planet), SIZE, "medium", PLAIN) as renderer:
        radiance = renderer.render(pf.view(name, planet), outputs=("radiance",))["radiance"]
        return np.asarray(radiance), [p.name for p in renderer.passes() if p.ran]


@pytest.mark.parametrize("name", ["beach", "coast", "under", "orbit", "near"])
def test_ground_that_no_water_reaches_is_shaded_without_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sorted into dry and wet tiles, the picture is the same: no wet pixel lies in a dry tile."""
    sorted_, passes = picture("earth", name)
    assert "terrain.wet" in passes
    assert "terrain.land_water" in passes
    monkeypatch.setattr(GroundShading, "sorts_wet", lambda self: False)
    monkeypatch.setattr(GroundShading, "shows_rivers", lambda self: True)  # else this picture would have none
    whole, passes = picture("earth", name)
    assert "terrain.wet" not in passes and "terrain.land_water" in passes
    # Two shaders: compilers round the same statements in other orders.
    np.testing.assert_allclose(sorted_, whole, rtol=1e-5, atol=1e-6 * whole.max())  # of red grass throws back little


def test_a_dry_planet_sorts_no_tiles() -> None:
    _, passes = picture("moon", "near")
    assert "terrain.shade" in passes
    assert "terrain.wet" not in passes
