"""A ray of clouds for every second block while something moves (clouds.march_every): still pictures have them all, and
pictures in flight are nearly as close to these."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import cloud_flown
from planetfall.benchmarks.measure.motion import turned
from planetfall.benchmarks.scenes import preset_scene
from planetfall.systems.clouds.history import MOVING, NONE, STILL, History

pytestmark = pytest.mark.gpu

SIZE = (159, 91)  # blocks stand over two of its edges


def rendered(scene: pf.Scene, name: str, every: int) -> list[np.ndarray]:
    """Settled, the first of a turn by itself, the last frame of the turn, and settled once more."""
    view = pf.view(name, "earth")
    scene.environment[pf.Exposure].mode = "fixed"
    scene.environment[pf.Exposure].ev100 = view.ev100
    moment = {"sun": view.sun, "time_s": view.time_s}
    with pf.Renderer(scene, SIZE, "medium", {"clouds.march_every": every}) as renderer:
        renderer.settle(view)
        found = [renderer.render(view)["color"]]
        cameras = turned(renderer.camera_state(view), 0.2, 11)
        found.append(renderer.render(cameras[1], **moment)["color"])
        for camera in cameras:
            moving = renderer.render(camera, dt_s=1.0 / 60.0, **moment)["color"]
        renderer.settle(view)
        return [*found, moving, renderer.render(view)["color"]]


@pytest.mark.parametrize("name", ["clouds", pytest.param("orbit", marks=pytest.mark.slow)])
def test_only_pictures_in_motion_change(name):
    with preset_scene("earth", True) as scene:
        each, half = (rendered(scene, name, every) for every in (1, 2))
    for k, what in ((0, "settled"), (1, "by itself"), (3, "settled after a flight")):
        assert np.array_equal(each[k], half[k]), what
    assert not np.array_equal(each[2], half[2]), "the knob does nothing"


@pytest.mark.parametrize(
    "name", ["10 km", *(pytest.param(far, marks=pytest.mark.slow) for far in ("ground", "2000 km"))]
)
def test_pictures_in_flight_are_nearly_as_close(name):
    """Half of the rays bring at most sqrt 2 of the error, if nothing but their number tells."""
    found = cloud_flown.errors(name, 0.1, SIZE)
    assert 0.0 < found[2] < np.sqrt(2.0) * found[1], found


def test_no_dots_are_left_where_there_is_no_past():
    """In the strip that a fast turn brings into the picture pixels of followed rays stand out no more than others."""
    with preset_scene("earth", True) as scene, pf.Renderer(scene, (320, 180), "medium") as renderer:
        view = pf.view("clouds", "earth")
        renderer.settle(view)
        for camera in turned(renderer.camera_state(view), 3.0, 10):
            shown = renderer.render(
                camera, outputs=("clouds.full", "debug.cloud_history"), dt_s=1.0 / 60.0, sun=view.sun,
                time_s=view.time_s,
            )  # fmt: skip
    left, history = shown["clouds.full"][..., 3], shown["debug.cloud_history"].astype(np.int64)[1:-1, 1:-1]
    around = 0.25 * (left[:-2, 1:-1] + left[2:, 1:-1] + left[1:-1, :-2] + left[1:-1, 2:])
    off = np.abs(left[1:-1, 1:-1] - around)
    new = history[..., 0] > history[..., 1] + 60
    followed = new & (history[..., 2] > 60)  # paler in the debug view
    # A block of 4 aside: where nothing was followed, but light is spread from, too.
    between = np.roll(followed, 4, axis=1) & new & ~followed
    assert min(followed.sum(), between.sum()) > 30
    assert off[followed].mean() < 1.5 * off[between].mean()


@pytest.mark.parametrize("size", [(320, 180), (40, 3), (5, 3), (4, 4), (1, 1)])
def test_every_ray_and_every_step_is_known(size):
    """Odd numbers of rows, and pictures of hardly a block."""
    with preset_scene("earth", True) as scene, pf.Renderer(scene, size, "medium") as renderer:
        view = pf.view("clouds", "earth")
        renderer.render(view)
        for camera in turned(renderer.camera_state(view), 0.3, 6):
            shown = renderer.render(
                camera, outputs=("clouds.rays", "clouds.full", "debug.cloud_steps"), dt_s=1.0 / 60.0, sun=view.sun,
                time_s=view.time_s,
            )  # fmt: skip
            assert np.isfinite(shown["clouds.rays"]).all() and np.isfinite(shown["clouds.full"]).all()
            assert (shown["debug.cloud_steps"] >= 0.0).all()
            if size[1] == 180:  # 45 rows of rays, all of them among clouds
                steps = shown["debug.cloud_steps"][[0, -1]]
                assert all((row > 0.0).mean() > 0.9 for row in (steps[:, ::2], steps[:, 1::2]))


def test_blocks_without_cloud_stay_without():
    """In a checkerboard's frame, too, what meets no layer is nothing: no light, nothing taken, to the bit."""
    scene = cloud_flown.scene_of_weather()
    with pf.Renderer(scene, SIZE, "medium", {"clouds.march_every": 2}) as renderer:
        camera = pf.Camera.at(48.0, -30.0, 36e6, pitch_deg=-90.0)
        renderer.settle(camera)
        for each in turned(renderer.camera_state(camera), 0.1, 5):
            rays = renderer.render(each, outputs=("clouds.rays",), dt_s=1.0 / 60.0)["clouds.rays"]
    corner = rays[:2, :2]
    assert np.array_equal(corner, np.broadcast_to(np.float32([0, 0, 0, 1]), corner.shape))


class _Frame:
    cut = settling = one_shot = still = False
    jitter_px = (0.0, 0.0)

    def __init__(self, camera, time_s):
        self.camera, self.time_s, self.size = camera, time_s, SIZE
        self.sun = type("Sun", (), {"direction": np.float64([0.0, 0.0, 1.0])})()


def test_blocks_take_turns_at_each_place():
    """Over 64 frames each of a block's 16 places has a ray on both squares, and a still picture counts from anew."""
    scene = cloud_flown.scene_of_weather()
    with pf.Renderer(scene, (32, 18), "low") as renderer:
        state = renderer.camera_state(pf.Camera.at(0.0, 0.0, 1e4))
    past = History(4, 16, 6.36e6, every=2)
    seen = set()
    for k in range(65):
        past.begin(_Frame(state, k / 60.0), 0)
        assert past.mode == (NONE if k == 0 else MOVING) and (past.checkerboard < 0) == (k == 0)
        seen.add((past.place, past.checkerboard))
    assert {(place, squares) for place, squares in seen if squares >= 0} == {
        ((x, y), squares) for x in range(4) for y in range(4) for squares in (0, 1)
    }
    for gathered in range(1, 17):
        past.begin(_Frame(state, 64 / 60.0), 0)
        assert past.mode == STILL and past.checkerboard == -1 and past.complete == (gathered == 16)
