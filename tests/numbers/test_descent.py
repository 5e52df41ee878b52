"""The descent: pops and steps of brightness between frames, work a frame; measures that see what they look for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import descent
from planetfall.benchmarks.scenes import preset_scene

pytestmark = pytest.mark.gpu

SIZE = (96, 54)
LARGER = (320, 180)
"""Blocks of 2 x 2 pixels of `low`, which step with the mesh, are small in it, and beside the sea there is ground."""


def flight_of(scene: pf.Scene, frames: int, first_s: float, last_s: float) -> descent.Flight:
    return descent.descent(scene, frames, first_s, last_s)


@pytest.mark.parametrize(
    "first_s", [48.0, *(pytest.param(second, marks=pytest.mark.slow) for second in (8.0, 30.0, 38.0, 54.0, 59.0))]
)
def test_neither_ground_nor_light_jumps(first_s: float):
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, LARGER, "low") as renderer:
        flight = flight_of(scene, 6, first_s, first_s + 0.5)
        steps = descent.pops(renderer, flight)
        assert sum(s.pixels for s in steps) > 300
        assert max(s.p999_px for s in steps) <= 1.0 and max(s.worst_px for s in steps) <= 4.0
        light = descent.brightness_steps(renderer, flight)
        assert np.isfinite(light).all()
        assert np.abs(light - descent.trend(light)).max() <= 0.01


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("clouds", [False, True])
def test_the_whole_descent(clouds: bool):
    scene = preset_scene("earth", clouds)
    # In tiny pictures the nearest pixel of the one before is another place: noise of several percent.
    with pf.Renderer(scene, (320, 180), "high") as renderer:
        flight = descent.descent(scene, 600)
        light = descent.brightness_steps(renderer, flight)
        beyond = descent.beyond(renderer, flight, light, 0.01) if clouds else np.abs(light - descent.trend(light))
        assert np.nanmax(beyond) <= 0.01


def test_what_the_true_pictures_do_too_is_no_fault():
    """In the same frame or in one beside it; what is more than that is."""
    steps = np.array([0.0, 0.3, 0.0, 0.0, -0.5, -0.1, 0.0])
    truth = np.array([0.0, 0.0, 0.0, np.nan, -0.45, -0.2, np.nan])
    found = descent.beyond_truth(steps, truth)
    assert found == pytest.approx([0.0, 0.3, 0.0, 0.0, 0.05, 0.1, 0.2])
    assert np.isnan(descent.beyond_truth(steps, np.full(7, np.nan))).all()


def test_a_step_of_brightness_is_seen():
    scene = pf.load_scene("moon")
    flight = flight_of(scene, 8, 30.0, 30.7)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        assert flight.sun is not None
        dim = replace(flight, cameras=flight.cameras[:5])
        renderer.settle(dim.cameras[0], sun=flight.sun)
        before = descent.shown_of(renderer, flight.cameras[3], flight)
        brighter = {**descent.shown_of(renderer, flight.cameras[4], flight)}
        brighter["radiance"] = 1.03 * brighter["radiance"]
        states = [renderer.camera_state(c) for c in flight.cameras[3:5]]
        plain = descent.brighter(states[0], before, states[1], descent.shown_of(renderer, flight.cameras[4], flight))
        found = descent.brighter(states[0], before, states[1], brighter)
    assert found - plain == pytest.approx(np.log(1.03), abs=1e-3)
    steps = np.array([0.001] * 5 + [0.03] + [0.001] * 5)
    assert np.abs(steps - descent.trend(steps)).argmax() == 5
    assert descent.trend(np.array([np.nan, 0.1, 0.1])) == pytest.approx(0.1)


@pytest.mark.slow
def test_work_a_frame_is_bounded():
    """No shader is compiled in flight, and no frame asks for much more than the others."""
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, SIZE, "low") as renderer:
        frames = descent.fly_timed(renderer, descent.descent(scene, 60))
        most = descent.most(frames[1:])
        assert renderer.ctx.error == "GL_NO_ERROR"
    assert most["programs_built"] == 0, [t for t, f in enumerate(frames) if f.programs_built]
    assert most["draws"] <= 60 and most["dispatches"] <= 120
    assert most["upload_bytes"] <= 2**20


def test_percentiles_leave_out_the_first_second():
    frames = [descent.FrameWork(ms, ms, 0, 0, 0, 0, 0) for ms in (100.0, *[1.0] * 98, 3.0)]
    found = descent.percentiles(frames, 1.0)
    assert (found.p50_ms, found.worst_ms) == (1.0, 3.0) and found.worst_over_median == 3.0
    with pytest.raises(ValueError, match="two frames or more"):
        descent.descent(pf.load_scene("moon"), 1)
