"""Rivers that a thread has solved for one ground change no picture of another."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.components import Terrain
from planetfall.systems.terrain.drainage.climate import climate_params
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.rivers.source import RiverKey, source

pytestmark = pytest.mark.gpu

FEWEST_CELLS = 1536


def test_rivers_of_another_ground_change_nothing() -> None:
    """Else the ground would be cut into cells anew, from where the camera is by then, and look different."""
    other = Terrain(seed=4021)
    key = RiverKey(TerrainParams.from_component(other, 1.0e6), climate_params(other, True), FEWEST_CELLS, 1.0)
    with pf.Renderer(pf.load_scene("earth"), (96, 54), "low") as renderer:
        renderer.settle(pf.view("space"))

        def picture() -> np.ndarray:
            return renderer.render(pf.view("coast"), dt_s=0.03, outputs=("radiance",))["radiance"]

        picture()
        picture()
        before = picture()
        solved = source.finished
        assert source.soon(key, None) is None
        while source.pending():
            source.progress(1.0)
        assert source.finished > solved
        np.testing.assert_array_equal(picture(), before)
