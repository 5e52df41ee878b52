"""Clouds of a picture half as fine (clouds.picture_px): like those of each pixel, whole at the borders, and cut off by
the same outlines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from cloud_kit import cloudy, renderer_of, texture
from golden_compare import likeness
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene

pytestmark = pytest.mark.gpu

SIZE = (161, 91)  # pixels of the clouds' picture stand over two of its edges


@pytest.fixture(scope="module")
def pair() -> Iterator[tuple[pf.Renderer, pf.Renderer]]:
    """As fine as the frame, and half as fine, each pixel of its own with a ray of its own."""
    with preset_scene("earth", True) as scene:
        scene.environment[pf.Exposure].mode = "fixed"
        one, two = ({"clouds.picture_px": px, "clouds.stride": 1, "terrain.shade_every": 1} for px in (1, 2))
        with (
            pf.Renderer(scene, SIZE, "low", overrides=one) as each,
            pf.Renderer(scene, SIZE, "low", overrides=two) as blocks,
        ):
            yield each, blocks


def taken(renderer: pf.Renderer, name: str) -> dict[str, NDArray]:
    view = pf.view(name)
    renderer.scene.environment[pf.Exposure].ev100 = view.ev100
    renderer.settle(view)
    return renderer.render(view, outputs=("color", "radiance", "distance"))


@pytest.mark.parametrize("name", ["near", "clouds", "orbit"])
def test_it_looks_like_that_of_each_pixel(pair, name):
    """Nearer to it than the sky without clouds is by far; as far as what one pixel can't show allows."""
    each, blocks = (taken(renderer, name) for renderer in pair)
    assert np.isfinite(blocks["radiance"]).all() and (blocks["radiance"] >= 0.0).all()
    assert np.array_equal(each["distance"], blocks["distance"])
    a, b = (np.log2(p["radiance"].sum(axis=-1) + 1e-4) for p in (each, blocks))
    # Means over 8 x 8 pixels: detail is lost, light is not.
    rows, columns = 88, 160
    means = (x[:rows, :columns].reshape(11, 8, 20, 8).mean(axis=(1, 3)) for x in (a, b))
    first, second = means
    assert np.percentile(np.abs(first - second), 90) < 0.1
    # The last row and column, where pixels of the clouds' picture stand over the edge.
    assert np.median(np.abs(a[0] - b[0])) < 0.1 and np.median(np.abs(a[:, -1] - b[:, -1])) < 0.1
    assert likeness(each["color"], blocks["color"]).mean < 0.05


def test_no_chessboard_where_ground_slopes_away(pair):
    """From orbit a pixel's ground is tens of kilometres deep and clouds hang lower: rays that end at a block's nearest
    point would miss them in every other pixel."""
    taken(pair[1], "orbit")
    left = texture(pair[1], "clouds.full")[..., 3]
    sign = (-1.0) ** np.add.outer(*(np.arange(n) for n in left.shape))
    inner = (left[1:-1, 1:-1] < 0.9) & (left[1:-1, 1:-1] > 0.1)
    around = 0.25 * (left[:-2, 1:-1] + left[2:, 1:-1] + left[1:-1, :-2] + left[1:-1, 2:])
    board = ((left[1:-1, 1:-1] - around) * sign[1:-1, 1:-1])[inner]
    assert inner.sum() > 300
    assert abs(board.mean()) < 0.02


def test_ground_before_a_cloud_keeps_its_outline(pair):
    """Along ridges before clouds the coarse picture is as near to the fine one as it is elsewhere: pixels take clouds
    that end where they do."""
    each, blocks = (taken(renderer, "near") for renderer in pair)
    sky = ~(each["distance"] < 1e30)
    edge = np.zeros_like(sky)
    edge[1:] |= sky[1:] != sky[:-1]
    edge[:-1] |= sky[1:] != sky[:-1]
    off = np.abs(np.log2(each["radiance"].sum(-1) + 1e-4) - np.log2(blocks["radiance"].sum(-1) + 1e-4))
    assert edge.sum() > 100 and (~edge & sky).sum() > 1000
    assert off[edge].mean() < 1.5 * off[~edge & sky].mean() + 0.01


@pytest.mark.parametrize("size", [(31, 17), (32, 18), (1, 1), (2, 1)])
def test_any_size(size):
    """Pictures of odd sizes have a row and a column more, and flight over them reads none beside them."""
    with renderer_of(cloudy(coverage=0.8), size, picture_px=2, stride=2) as renderer:
        for k in range(4):
            shown = renderer.render(pf.Camera.at(20.0 + 1e-3 * k, 10.0, 800.0, pitch_deg=15.0), dt_s=0.05)
        assert shown["color"].shape[:2] == (size[1], size[0])
        full = texture(renderer, "clouds.full")
    assert full.shape[:2] == (-(-size[1] // 2), -(-size[0] // 2))
    assert np.isfinite(full).all() and (full[..., 3] >= 0.0).all() and (full[..., 3] <= 1.0).all()
