"""One of two or four pixels shaded (terrain.shade_every, ocean.shade_every): the same outlines, no pixel without light,
and light as close as that of a picture half as fine; one of two only while something moves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from golden_compare import likeness

import planetfall as pf
from planetfall.benchmarks.measure.motion import turned

pytestmark = pytest.mark.gpu

SIZE = (319, 181)  # blocks stand over two of its edges
KNOBS = ("terrain.shade_every", "ocean.shade_every")
EACH = dict.fromkeys(KNOBS, 1)
TERRAIN, SEA = 1, 2


@pytest.fixture(scope="module")
def pair() -> Iterator[tuple[pf.Renderer, pf.Renderer]]:
    """Each pixel shaded, and one of four."""
    with pf.load_scene("earth") as scene:
        scene.environment[pf.Exposure].mode = "fixed"
        with (
            pf.Renderer(scene, SIZE, "low", overrides=EACH) as each,
            pf.Renderer(scene, SIZE, "low", overrides=dict.fromkeys(KNOBS, 4)) as blocks,
        ):
            yield each, blocks


def taken(renderer: pf.Renderer, name: str) -> dict[str, np.ndarray]:
    view = pf.view(name, "earth")
    renderer.scene.environment[pf.Exposure].ev100 = view.ev100
    renderer.settle(view)
    return renderer.render(view, outputs=("color", "radiance", "distance", "surface"))


@pytest.mark.parametrize("name", ["near", "coast", "orbit", "beach", "under"])
def test_outlines_are_the_same_and_every_pixel_has_light(pair, name):
    each, blocks = (taken(renderer, name) for renderer in pair)
    assert np.array_equal(each["surface"], blocks["surface"]) and np.array_equal(each["distance"], blocks["distance"])
    assert np.isfinite(blocks["radiance"]).all() and (blocks["radiance"] >= 0.0).all()
    ground = np.isin(blocks["surface"], (TERRAIN, SEA))
    assert ground.any() and (blocks["radiance"][ground].sum(axis=-1) > 0.0).all()
    if name != "under":  # water before the lens is another pass
        assert np.array_equal(each["radiance"][~ground], blocks["radiance"][~ground])


@pytest.mark.parametrize("name", ["sea", "under"])
def test_an_array_of_normals_has_every_pixel(pair, name):
    each, blocks = (renderer.render(pf.view(name, "earth"), outputs=("normal", "surface")) for renderer in pair)
    assert (each["surface"] == SEA).any()
    assert np.array_equal(each["normal"], blocks["normal"])


def tiled(values: np.ndarray, side: int) -> np.ndarray:
    """By tiles of 8 x 8 pixels of the full picture, whatever one of them is."""
    rows, columns = 22 * side, 39 * side
    return values[:rows, :columns].reshape(22, side, 39, side, *values.shape[2:])


@pytest.mark.parametrize("name", ["near", "coast", "orbit"])
def test_the_light_is_as_good_as_that_of_a_picture_half_as_fine(pair, name):
    """Means over tiles that show one surface, against those of a picture with each pixel shaded."""
    each, blocks = (taken(renderer, name) for renderer in pair)
    half_size = (160, 91)
    with pf.Renderer(pair[0].scene, half_size, "low", overrides=EACH) as renderer:
        half = taken(renderer, name)
    surface = tiled(each["surface"], 8)
    inside = (surface == surface[:, :1, :, :1]).all(axis=(1, 3)) & np.isin(surface[:, 0, :, 0], (TERRAIN, SEA))
    sought, found, coarse = (
        tiled(picture["radiance"], side).mean(axis=(1, 3))[inside]
        for picture, side in ((each, 8), (blocks, 8), (half, 4))
    )
    off, allowed = (np.abs(values / sought - 1.0) for values in (found, coarse))
    assert np.median(off) < 1.1 * np.median(allowed) and np.quantile(off, 0.9) < 1.1 * np.quantile(allowed, 0.9)
    # Of each colour by itself: one that is too bright must not make up for another.
    drift, drift_allowed = (np.abs(v.mean(axis=0) / sought.mean(axis=0) - 1.0).mean() for v in (found, coarse))
    assert drift < 1.1 * drift_allowed + 0.003
    assert likeness(each["color"], blocks["color"]).mean > 0.0, "the knob does nothing"


def test_no_blocks_are_left_between(pair):
    """Steps from pixel to pixel within a block and between two are as large: light is interpolated, not repeated."""
    _, blocks = (taken(renderer, "near") for renderer in pair)
    light, surface = blocks["radiance"][..., 1], blocks["surface"]
    steps = np.abs(np.diff(light[80:, :318], axis=1))
    same = (surface[80:, :317] == TERRAIN) & (surface[80:, 1:318] == TERRAIN)
    within, between = (steps[:, k::2][same[:, k::2]].mean() for k in (0, 1))
    assert 0.8 < within / between < 1.25


@pytest.fixture(
    scope="module", params=["beach", *(pytest.param(name, marks=pytest.mark.slow) for name in ("near", "under"))]
)
def flights(request) -> dict[int, list[np.ndarray]]:
    """By shade_every, at `medium`: pictures that keep still before and after a turn, the last one of the turn, and the
    light that an array of it has."""
    with pf.load_scene("earth") as scene:
        scene.environment[pf.Exposure].mode = "fixed"
        return {every: flown(scene, request.param, every) for every in (1, 2, 4)}


def flown(scene: pf.Scene, name: str, every: int) -> list[np.ndarray]:
    view = pf.view(name, "earth")
    scene.environment[pf.Exposure].ev100 = view.ev100
    moment = {"sun": view.sun, "time_s": view.time_s}
    with pf.Renderer(scene, SIZE, "medium", dict.fromkeys(KNOBS, every)) as renderer:
        renderer.settle(view)
        found = [renderer.render(view)["color"]]
        cameras = turned(renderer.camera_state(view), 0.2, 12)
        for camera in cameras:
            moving = renderer.render(camera, dt_s=1.0 / 60.0, **moment)["color"]
        light = renderer.render(cameras[-2], outputs=("radiance",), dt_s=1.0 / 60.0, **moment)["radiance"]
        renderer.settle(view)
        return [*found, renderer.render(view)["color"], moving, light]


def test_every_second_pixel_is_shaded_only_in_flight(flights):
    each, half = flights[1], flights[2]
    assert np.array_equal(each[0], half[0]) and np.array_equal(each[1], half[1]), "still pictures"
    assert np.array_equal(each[3], half[3]), "arrays are of each pixel"


def test_arrays_in_flight_are_not_blurred_as_a_chessboard_is():
    """What one frame leaves out is forgotten by the next."""
    view = pf.view("near", "earth")
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (64, 36), "medium") as renderer:
        renderer.settle(view)
        for camera in turned(renderer.camera_state(view), 0.2, 6):
            renderer.render(camera, dt_s=1.0 / 60.0)
            shaded = {"terrain", "ocean"} if renderer.frame.checkerboard is not None else set()
            assert renderer.frame.checkered == shaded
        assert renderer.frame.checkered
        renderer.render(camera, outputs=("color", "distance"), dt_s=1.0 / 60.0)
        assert renderer.frame.checkerboard is None and not renderer.frame.checkered


def test_in_flight_every_second_pixel_does(flights):
    """Frames take turns, so far less is lost than with one of four, which are always the same."""
    half, quarter = (likeness(flights[1][2], flights[every][2]) for every in (2, 4))
    assert 0.0 < half.mean < 0.6 * quarter.mean and half.p999 < quarter.p999, (str(half), str(quarter))


@pytest.mark.parametrize("samples", [1, 17])
def test_squares_take_turns_whatever_the_samples(samples):
    found = []
    with (
        pf.load_scene("earth") as scene,
        pf.Renderer(scene, (64, 36), "medium", {"composite.samples": samples}) as renderer,
    ):
        view = pf.view("space", "earth")
        renderer.settle(view)
        for camera in turned(renderer.camera_state(view), 0.2, 16):
            renderer.render(camera, dt_s=1.0 / 60.0)
            found.append(renderer.views[0].frame.checkerboard)
    flown = [squares for squares in found if squares is not None]
    assert len(flown) > 12 and 0.3 < sum(flown) / len(flown) < 0.7
