"""Named views as the sources draw them: no picture by day is black or flat, and those without a high sun are lit where
ours are."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from golden_compare import read_picture
from golden_pictures import FOLDER, PAPER
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene

pytestmark = pytest.mark.gpu

SIZE, BLOCKS = (160, 90), (9, 16)
BY_DAY = (
    "space", "orbit", "high", "coast", "near", "valley", "beach", "sea", "clouds", "ground", "noon", "fair",
)  # fmt: skip
LOW_SUN = ("night", "dusk", "dawn", "limb", "terminator", "day_edge")
LIT = 12.0
"""Mean of 8-bit values: clearly not black."""


@pytest.fixture(scope="module")
def printed(gpu) -> Iterator[dict[str, NDArray[np.float64]]]:
    """Grey pictures (rows, columns) of the views, 0 to 255."""
    scene, found = preset_scene("earth", clouds=True), {}
    with pf.Renderer(scene, SIZE, "paper", PAPER) as renderer:
        for name in BY_DAY + LOW_SUN:
            view = pf.view(name, scene.planet)
            renderer.settle(view)
            found[name] = renderer.render(view)["color"].mean(axis=-1)
    yield found
    gpu.ctx.__enter__()


@pytest.mark.parametrize("view", BY_DAY)
def test_no_picture_by_day_is_black_or_flat(printed, view):
    assert printed[view].mean() > LIT
    assert printed[view].std() > 8.0


@pytest.mark.parametrize("view", LOW_SUN)
def test_low_suns_light_what_they_light_in_ours(printed, view):
    """Against the golden picture, block by block. The printed ground has skylines of its own: nine in ten."""
    ours, theirs = (_lit(picture) for picture in (read_picture(FOLDER / f"earth/{view}.png").mean(-1), printed[view]))
    assert ours.any()
    assert theirs[ours].mean() > 0.9


def _lit(picture: NDArray[np.float64]) -> NDArray[np.bool_]:
    rows, columns = BLOCKS
    height, width = picture.shape
    return picture.reshape(rows, height // rows, columns, width // columns).mean(axis=(1, 3)) > LIT
