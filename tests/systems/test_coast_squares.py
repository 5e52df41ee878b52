"""Coasts of frames that shade every second pixel, as the squares of a checkerboard: of two pixels the white one is
asked about only where the black one shows something else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.measure.motion import turned

pytestmark = pytest.mark.gpu

SIZE = (320, 180)
TERRAIN, SEA = 1, 2


def flown(name: str, ocean_shade_every: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8], int | None]:
    """Surfaces of a still picture and of a frame in a turn, and which squares that one shades."""
    view = pf.view(name, "earth")
    overrides = {"terrain.shade_every": 2, "ocean.shade_every": ocean_shade_every}
    with pf.load_scene("earth") as scene, pf.Renderer(scene, SIZE, "medium", overrides) as renderer:
        renderer.settle(view)
        found = [surfaces(renderer)]
        for camera in turned(renderer.camera_state(view), 0.2, 6):
            renderer.render(camera, sun=view.sun, time_s=view.time_s, dt_s=1.0 / 60.0)
        found.append(surfaces(renderer))
        return found[0], found[1], renderer.views[0].frame.checkerboard


def surfaces(renderer: pf.Renderer) -> NDArray[np.uint8]:
    held = renderer.graph.resource("gbuffer.surface")
    with renderer.current():
        return np.frombuffer(held.read(), np.uint8).reshape(SIZE[1], SIZE[0])


@pytest.mark.parametrize("name", ["cloud_shadows", "orbit", "space", "coast"])
def test_what_is_shaded_is_as_each_pixel_has_it(name: str) -> None:
    """And what is filled in shows what its black square shows, or is as each pixel has it."""
    still, flight, squares = flown(name, 2)
    each_still, each, _ = flown(name, 1)
    assert np.array_equal(still, each_still), "still pictures"
    assert squares in (0, 1)
    assert {TERRAIN, SEA} <= set(np.unique(each))
    rows, columns = np.indices(each.shape)
    black = (rows + columns + squares) % 2 == 0
    assert np.array_equal(flight[black], each[black])
    beside = flight.reshape(SIZE[1], -1, 2)[..., ::-1].reshape(flight.shape)
    differs = flight != each
    assert (flight[differs] == beside[differs]).all()
    if name in ("cloud_shadows", "orbit"):
        assert 0 < differs.sum() < 0.02 * differs.size
    if name == "coast":  # from near by heights are in double, and all are asked
        assert not differs.any()
