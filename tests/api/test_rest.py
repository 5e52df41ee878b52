"""A paused scene under a still camera costs a copy of the finished picture."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import planetfall as pf
from planetfall import extend

pytestmark = pytest.mark.gpu

SIZE = (96, 54)
PRESENT = "outputs.present"
_FRAMES = 2000
"""The air's tables take as many as the time of a frame allows: on a busy machine hundreds."""


class Stage:
    """A renderer that draws into a host's framebuffer."""

    def __init__(self, **overrides):
        self.scene = pf.load_scene("earth")
        self.renderer = pf.Renderer(self.scene, SIZE, "low", overrides)
        self.target = self.renderer.ctx.simple_framebuffer(SIZE)
        self.camera = pf.view("near")

    def show(self, **moment) -> np.ndarray:
        self.target.clear()
        moment = {"time_s": 0.0, **moment}
        self.renderer.render_to(self.target, moment.pop("camera", self.camera), **moment)
        return np.frombuffer(self.target.read(), np.uint8).copy()

    def ran(self) -> list[str]:
        return [p.name for p in self.renderer.passes() if p.ran]

    def rest(self) -> np.ndarray:
        """Frames until nothing but the copy is made; the last picture that was made in full."""
        full = self.show()
        for _ in range(_FRAMES):
            picture = self.show()
            if self.ran() == [PRESENT]:
                return full
            full = picture
        raise AssertionError(f"no rest after {_FRAMES} frames: {self.ran()}")


@pytest.fixture(scope="module")
def stage():
    made = Stage()
    yield made
    made.renderer.release()


def test_a_still_scene_comes_to_rest_and_shows_the_same_picture(stage):
    full = stage.rest()
    work = stage.renderer.gpu.work
    work.reset()
    np.testing.assert_array_equal(stage.show(), full)
    assert work.draws == 0 and work.dispatches == 0 and work.programs_built == 0
    skipped = [p for p in stage.renderer.passes() if not p.ran and "culled" not in (p.skipped_why or "")]
    assert skipped and all("nothing has changed" in (p.skipped_why or "") for p in skipped if p.name != PRESENT)
    np.testing.assert_array_equal(stage.show(), full, "and again")


def test_another_target_gets_the_picture_too(stage):
    full = stage.rest()
    other = stage.renderer.ctx.simple_framebuffer(SIZE)
    stage.renderer.render_to(other, stage.camera, time_s=0.0)
    assert stage.ran() == [PRESENT]
    np.testing.assert_array_equal(np.frombuffer(other.read(), np.uint8), full)
    stage.renderer.gpu.leave(other)
    other.release()


def brighter(stage):
    stage.scene.environment[pf.Exposure].compensation_ev += 1.0


def windier(stage):
    stage.scene.planet[pf.Ocean].wind_speed_m_s += 1.0


def debug(stage):
    stage.scene.environment.add(pf.DebugView("normals"))


def no_debug(stage):
    stage.scene.environment.remove(pf.DebugView)


def a_stone(stage):
    up = pf.direction(9.9, 38.1)
    stage.scene.add(pf.Transform(tuple(up * 6.4e6)), pf.Shape("box"), name="stone")


def a_material(stage):
    extend.register_material("moss", (0.3, 0.1, 0.1), "0.5")


def no_material(stage):
    extend.unregister_material("moss")


@pytest.mark.parametrize("change", [brighter, windier, debug, no_debug, a_material, no_material, a_stone])
def test_any_change_is_shown_at_once(stage, change):
    stage.rest()
    change(stage)
    stage.show()
    assert len(stage.ran()) > 5


def test_camera_sun_and_time_end_it(stage):
    noon = pf.Sun(elevation_deg=60.0, azimuth_deg=180.0, latitude_deg=9.9, longitude_deg=38.1)
    turned = pf.Camera.at(9.90788, 38.10899, 100.0, heading_deg=20.0, above="ground")
    for moment in ({"camera": turned}, {"sun": noon}, {"time_s": 0.1}):
        stage.rest()
        stage.show(**moment)
        assert len(stage.ran()) > 5, moment
    dimmer = dataclasses.replace(noon, irradiance=tuple(0.5 * v for v in noon.irradiance))
    stage.rest()
    stage.show(sun=noon)
    stage.show(sun=dimmer)
    assert len(stage.ran()) > 5


def test_a_picture_by_itself_and_arrays_are_made(stage):
    stage.rest()
    alone = stage.renderer.render(stage.camera, time_s=0.0, outputs=("color", "distance"))
    assert np.isfinite(alone["distance"]).any() and len(stage.ran()) > 5
    stage.show()
    assert len(stage.ran()) > 5, "the plan is another one"


def test_a_resize_ends_it(stage):
    stage.rest()
    stage.renderer.render_to(stage.target, stage.camera, time_s=0.0, viewport=(0, 0, 64, 36))
    assert len(stage.ran()) > 5
    stage.rest()


def test_a_frame_that_raised_is_not_repeated(stage, monkeypatch):
    stage.rest()
    plan = stage.renderer.graph
    monkeypatch.setattr(plan, "_unsettled", True)
    assert plan.repeat() is False


def test_each_of_several_views_rests_on_its_own(stage):
    above = pf.Camera.at(9.9, 38.1, 3.0e5, pitch_deg=-90.0)
    view = stage.renderer.add_view((48, 48))
    other = stage.renderer.ctx.simple_framebuffer((48, 48))

    def ran(of) -> list[str]:
        return [p.name for p in of.passes() if p.ran]

    def both(camera=above) -> tuple[np.ndarray, np.ndarray]:
        first = stage.show()
        view.render_to(other, camera, time_s=0.0)
        return first, np.frombuffer(other.read(), np.uint8).copy()

    try:
        full = both()
        for _ in range(_FRAMES):
            now = both()
            if stage.ran() == [PRESENT] == ran(view):
                break
            full = now
        else:
            raise AssertionError(f"no rest: {stage.ran()}, {ran(view)}")
        for wanted, found in zip(full, both(), strict=True):
            np.testing.assert_array_equal(found, wanted)
        # One view moves: the other one goes on showing its picture, which is the same.
        turned = pf.Camera.at(9.9, 38.1, 3.0e5, heading_deg=20.0, pitch_deg=-90.0)
        first, second = both(turned)
        assert stage.ran() == [PRESENT] and len(ran(view)) > 5
        np.testing.assert_array_equal(first, full[0])
        assert (second != full[1]).any()
        # The scene changes: both are made anew.
        stage.scene.planet[pf.Ocean].wind_speed_m_s += 1.0
        both(turned)
        assert len(stage.ran()) > 5 and len(ran(view)) > 5
    finally:
        view.release()
        stage.renderer.gpu.leave(other)
        other.release()
    stage.rest()


def test_a_view_at_rest_is_shown_by_its_own_hosts_depth(stage):
    """Each view stands among the objects of its host, and the hosts' depth buffers hold distances differently."""
    near, reversed_z = pf.HostDepth(1.0, -0.1), pf.HostDepth(0.0, 0.1)
    gpu, size = stage.renderer.gpu, (48, 48)
    view, present = stage.renderer.add_view(size), "outputs.present_depth"
    targets = [gpu.ctx.simple_framebuffer(s) for s in (SIZE, size)]

    def show(of, target, depth) -> np.ndarray:
        target.clear(depth=0.0 if depth is reversed_z else 1.0)
        of.render_to(target, stage.camera, time_s=0.0, depth=depth)
        return np.frombuffer(target.read(), np.uint8).copy()

    def ran() -> list[str]:
        return [p.name for p in stage.renderer.passes() if p.ran]

    try:
        for depth in (reversed_z, None):
            show(view, targets[1], depth)  # its first frame ends every rest
            full = show(stage.renderer, targets[0], near)
            for _ in range(_FRAMES):
                now = show(stage.renderer, targets[0], near)
                if ran() == [present]:
                    break
                full = now
            else:
                raise AssertionError(f"no rest: {ran()}")
            assert show(view, targets[1], depth).any()
            shown = show(stage.renderer, targets[0], near)
            assert ran() == [present]
            np.testing.assert_array_equal(shown, full)
    finally:
        view.release()
        for target in targets:
            gpu.leave(target)
            target.release()
