"""Named views as a camera would show them: whites are white, shade isn't black, and the meter agrees with the view."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.systems.composite.photometry import LUMINANCE_WEIGHTS

pytestmark = pytest.mark.gpu

SIZE = (192, 108)
WHITE = ("fair", "cloud_sea", "high", "orbit", "pole", "noon")
"""Views with snow or clouds in the sun."""
OTHERS = ("space", "beach", "sea", "sunset", "dusk", "dawn", "terminator", "glint")
MEANS = {
    **dict.fromkeys(("fair", "noon", "coast", "valley", "near", "ground"), (95.0, 150.0)),
    **dict.fromkeys(("cloud_sea", "high"), (120.0, 180.0)),
}
"""Of 8-bit grey: daylight, and daylight on clouds or snow, as professionals print them."""


class Seen(NamedTuple):
    grey: NDArray[np.float64]
    """8-bit values weighted as luminance"""
    named_ev100: float | None
    metered_ev100: float


@pytest.fixture(scope="module")
def seen(gpu) -> Iterator[Callable[[str], Seen]]:
    """What a view shows, rendered once."""
    scene = preset_scene("earth", clouds=True)
    with pf.Renderer(scene, SIZE, "medium") as renderer:

        @cache
        def look(name: str) -> Seen:
            view = pf.view(name, scene.planet)
            renderer.settle(view)
            grey = renderer.render(view)["color"] @ LUMINANCE_WEIGHTS
            free = pf.Camera(view.position_m, view.forward, view.up, view.fov_y_deg, scene.planet)
            renderer.settle(free, time_s=view.time_s, sun=view.sun)
            renderer.render(free, time_s=view.time_s, sun=view.sun)
            return Seen(grey, view.ev100, renderer.exposure)

        yield look
    gpu.ctx.__enter__()


@pytest.mark.parametrize("view", WHITE)
def test_clouds_and_snow_in_the_sun_are_white_and_not_burnt(seen, view):
    grey = seen(view).grey
    assert 238.0 <= np.percentile(grey, 99.0) <= 248.0
    assert (grey > 252.0).mean() < 0.005


@pytest.mark.parametrize("view", MEANS)
def test_daylight_is_as_bright_as_it_is_printed(seen, view):
    low, high = MEANS[view]
    assert low <= seen(view).grey.mean() <= high


def test_ground_in_the_shade_of_clouds_is_not_black(seen):
    assert np.percentile(seen("fair").grey, 1.0) >= 24.0


@pytest.mark.parametrize("view", dict.fromkeys((*WHITE, *MEANS, *OTHERS)))
def test_the_meter_agrees_with_the_named_exposure(seen, view):
    assert seen(view).metered_ev100 == pytest.approx(seen(view).named_ev100, abs=0.3)
