"""Debug views of what is taken over from the last frame, by anti-aliasing and by clouds, and of the picture's tiles."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf

pytestmark = pytest.mark.gpu

SIZE = (96, 54)
PLACE = (37.664, 140.624)


def camera(heading_deg: float) -> pf.Camera:
    return pf.Camera.at(*PLACE, 800.0, heading_deg=heading_deg, pitch_deg=-4.0, above="ground")


def red(picture: np.ndarray) -> np.ndarray:
    pixels = picture.astype(int)
    return (pixels[..., 0] > 1.6 * pixels[..., 1]) & (pixels[..., 0] > 90)


def green(picture: np.ndarray) -> np.ndarray:
    pixels = picture.astype(int)
    return (pixels[..., 1] > 1.25 * pixels[..., 0]) & (pixels[..., 1] > 90)


@pytest.mark.parametrize("name", ["history", "cloud_history"])
def test_what_comes_into_view_has_no_history(name: str) -> None:
    with pf.load_scene("earth") as scene:
        scene.environment.add(pf.DebugView(name))
        scene.planet.add(pf.Clouds(density_model="uniform", extinction_per_m=1e-3))  # cloud everywhere
        overrides = {"exposure.mode": "fixed", "composite.antialiasing": "temporal"}
        with pf.Renderer(scene, SIZE, "low", overrides) as renderer:
            first = renderer.render(camera(30.0), 0.0, dt_s=0.02)["color"]
            assert red(first).mean() > 0.95, "nothing has a past in the first frame"
            for _ in range(20):
                still = renderer.render(camera(30.0), 0.0, dt_s=0.02)["color"]
            # Jitter shows now one side of an outline and now the other: clouds before one are not those before both.
            outlines = 0.04 if name == "cloud_history" else 0.01
            assert green(still).mean() > 0.7 and red(still).mean() < outlines
            turned = renderer.render(camera(45.0), 0.0, dt_s=0.02)["color"]
            # Turned to the right by 15 of 92 degrees: what comes in is at the right edge.
            assert red(turned[:, -8:]).mean() > 0.9
            assert red(turned[:, :60]).mean() < 0.15


def test_tiles_show_what_they_hold() -> None:
    with pf.load_scene("earth") as scene, pf.Renderer(scene, SIZE, "low") as renderer:
        view = pf.view("coast")
        renderer.settle(view)
        surface = renderer.render(view, outputs=("surface",))["surface"][::-1]  # rows from below, as tiles count
        scene.environment.add(pf.DebugView("tiles"))
        tiles = renderer.render(view)["color"][::-1].astype(int)
    seen, coasts = set(), set()
    for y in range(0, SIZE[1], 8):
        for x in range(0, SIZE[0], 16):
            kinds = frozenset(np.unique(surface[y : y + 8, x : x + 16]).tolist()) - {0}
            around = set(np.unique(surface[max(y - 8, 0) : y + 16, max(x - 16, 0) : x + 32]).tolist())
            color = tiles[min(y + 3, SIZE[1] - 1), x + 5]
            seen.add(kinds)
            land = color[1] == color.max() and color.max() >= 40
            sea = color[2] == color.max() and color[2] > 100
            both = color[0] == color.max() and color[0] > color[1] + 20
            if kinds and {1, 2} <= around:
                # Tiles are sorted by what meshes have drawn: beside a coast pixels have changed sides since.
                assert land or sea or both
                coasts.add((kinds, both))
            elif kinds == {1}:
                assert land
            elif kinds == {2}:
                assert sea
            else:
                assert color.max() < 40
    assert (frozenset({1, 2}), True) in coasts
    assert {frozenset({1}), frozenset({2}), frozenset({1, 2})} <= seen
