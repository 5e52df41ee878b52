"""Clouds seen from space don't show where their noise repeats; the printed texture, one tile beside the other, does."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("scipy")

from planetfall.benchmarks.measure.cloud_paper import TILE_M, renderer_of, repeats, seen_from_space
from planetfall.systems.clouds.layers import frames_at

LIMIT = 0.1


def test_what_repeats_is_found_and_what_is_large_or_random_is_not() -> None:
    rng = np.random.default_rng(1)
    tile = rng.random((6, 6))
    noise = rng.random((96, 96))
    assert repeats(np.tile(tile, (16, 16)), 6)[0] > 0.9
    assert repeats(np.tile(tile, (16, 16)) + 2.0 * noise, 6)[0] > LIMIT
    assert abs(repeats(noise, 6)[0]) < 0.05
    # Blobs of the shift's own size and a disc's brightness: alike at every small shift.
    y, x = np.mgrid[:96, :96] / 48.0 - 1.0
    blobs = np.cumsum(np.cumsum(noise - 0.5, 0), 1)
    assert repeats(blobs + 50.0 * np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0)), 6)[0] < LIMIT


@pytest.mark.gpu
def test_ours_don_t_show_and_the_printed_ones_do() -> None:
    straight, tilted = frames_at(0.0, 1.0, 0.0)
    found = {}
    with renderer_of((192, 192), "ours", tiled=False, stride=1, samples=1, map_texels=512) as renderer:
        for width, axes in ((TILE_M, straight), (6.871 * TILE_M, tilted)):
            found[width] = repeats(seen_from_space(renderer, width / 6, axes), 6)[0]
    assert max(found.values()) <= LIMIT, found
    with renderer_of((192, 192), "paper_2018", tiled=False, shape_texels=64) as renderer:
        assert repeats(seen_from_space(renderer, TILE_M / 6, straight), 6)[0] > 2.0 * LIMIT
