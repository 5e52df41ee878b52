"""Coasts asked once for a block of pixels, or at every fourth (terrain.coast_px 2, 4): along the line that each pixel
by itself draws."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, minimum_filter

import planetfall as pf

pytestmark = pytest.mark.gpu

SIZE = (321, 181)  # blocks stand over two of its edges
LAND, SEA = 1, 2


@pytest.fixture(scope="module")
def pictures() -> Iterator[dict[int, pf.Renderer]]:
    with pf.load_scene("earth") as scene:
        made = {px: pf.Renderer(scene, SIZE, "low", overrides={"terrain.coast_px": px}) for px in (1, 2, 4)}
        yield made
        for renderer in made.values():
            renderer.release()


def sea_of(renderer: pf.Renderer, name: str) -> np.ndarray:
    view = pf.view(name)
    renderer.settle(view)
    surface = renderer.render(view, outputs=("surface",))["surface"]
    return np.where(np.isin(surface, (LAND, SEA)), surface == SEA, False)


@pytest.mark.parametrize("name", ["beach", "shallows", "coast", "cloud_shadows", "orbit"])
@pytest.mark.parametrize("px", [2, 4])
def test_the_line_is_where_each_pixel_has_it(pictures, name, px):
    """Pixels that change sides lie beside the line, as far as a block is wide; from orbit, where lakes and islands are
    single pixels, few more."""
    truth, found = (sea_of(pictures[n], name) for n in (1, px))
    assert truth.any() and not truth.all()
    line = binary_dilation(truth, iterations=1) & ~truth
    # A coast is the line between two surfaces, both within this of it.
    near = binary_dilation(line, np.ones((3, 3), bool), iterations=px)
    apart = truth != found
    assert apart.sum() < 0.5 * px * line.sum(), f"{apart.sum()} pixels beside a line of {line.sum()}"
    far = (apart & ~near).sum()
    assert far <= 1e-3 * truth.size, f"{far} of {apart.sum()} pixels are far from the line"


def test_no_fringe_of_land_grows_over_water_behind_a_shore(pictures):
    """Heights of a shore are not those of the water that is seen beside it, farther away. Of the named views at a shore
    only the beach has such land: the others look down over theirs."""
    truth = sea_of(pictures[1], "beach")
    distance = pictures[1].render(pf.view("beach"), outputs=("distance",))["distance"]
    # Nearer water is none: at flat angles the sea before a far coast is half as far away a few rows below.
    shore = np.where(np.isfinite(distance) & ~truth, distance, 1e12)
    beside = truth & (minimum_filter(shore, 9) < 0.5 * distance)
    assert beside.any()
    taken = {px: int((beside & ~sea_of(pictures[px], "beach")).sum()) for px in (2, 4)}
    assert max(taken.values()) < 0.05 * beside.sum(), f"{taken} of {beside.sum()}"
