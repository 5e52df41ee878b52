"""DebugView.freeze: what is drawn stays, whatever the camera does, and goes on when it is let go."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planetfall as pf

pytestmark = pytest.mark.gpu

SIZE = (160, 90)


def test_the_grid_is_frozen_and_let_go(gpu: Any) -> None:
    with pf.load_scene("earth") as scene, pf.Renderer(scene, SIZE, "low", ctx=gpu.ctx) as renderer:
        here = pf.Camera.at(12.0, 20.0, 3000.0, 30.0, -25.0, planet=scene.planet)
        away = pf.Camera.at(12.0, 20.0, 60_000.0, 210.0, -80.0, planet=scene.planet)
        renderer.settle(here)
        renderer.render(here)
        proxy = renderer.views[0].proxy
        drawn = renderer.stats
        scene.environment.add(pf.DebugView(freeze=True))
        renderer.render(here)
        for _ in range(3):
            outputs = renderer.render(away, dt_s=0.1, outputs=("surface",))
        assert renderer.stats == drawn and renderer.views[0].proxy.generation == proxy.generation
        ran = {report.name for report in renderer.passes() if report.ran}
        assert not ran & {"terrain.vertices", "terrain.cull", "ocean.vertices", "ocean.cull"}
        # From above only the wedge that `here` looked along is there.
        frozen_share = float((outputs["surface"] > 0).mean())
        scene.environment[pf.DebugView].view = "wireframe"  # the graph is compiled again
        renderer.render(away, dt_s=0.1)
        assert renderer.stats == drawn
        scene.environment[pf.DebugView].freeze = False
        free = renderer.render(away, dt_s=0.1, outputs=("surface",))["surface"]
        assert renderer.views[0].proxy.generation != proxy.generation
        assert 0.0 < frozen_share < 0.7 * float((free > 0).mean())
        assert np.isfinite(frozen_share)


@pytest.mark.parametrize("method", ["ours", "paper"])
@pytest.mark.parametrize("backend", ["grid", "quadtree", "icosphere"])
def test_every_ground_is_frozen_and_let_go(gpu: Any, backend: str, method: str) -> None:
    sea = "ours" if method == "ours" else "paper_2019"
    knobs = {"terrain.backend": backend, "terrain.method": method, "ocean.method": sea}
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (96, 54), "low", knobs, ctx=gpu.ctx) as renderer:
        here = pf.Camera.at(37.7, 140.6, 900.0, 30.0, -25.0, planet=scene.planet)
        forward, side = here.forward, np.cross(here.forward, here.up)
        up = here.position_m / np.linalg.norm(here.position_m)
        places = (here.position_m + 500.0 * side, here.position_m + 3000.0 * up)
        away = [pf.Camera(place, ahead, up, fov, scene.planet)
                for place in places for ahead, fov in ((forward, 60.0), (side, 60.0), (forward, 20.0))]  # fmt: skip
        below = pf.latitude_longitude(here.position_m[None])
        at = pf.direction(below[0] + np.linspace(0.0, 0.02, 5), below[1] + np.linspace(0.0, 0.02, 5))
        renderer.settle(here)
        shown = scene.environment.add(pf.DebugView(freeze=True))
        renderer.render(here)
        drawn, heights_m = renderer.stats, renderer.height_drawn(at)
        for camera in away:
            renderer.render(camera, dt_s=0.1)
            assert renderer.stats == drawn
            np.testing.assert_allclose(renderer.height_drawn(at), heights_m, rtol=0.0, atol=0.01)
        shown.freeze = False
        renderer.settle(away[-1])
        renderer.render(away[-1])
        assert renderer.stats != drawn


def test_a_flight_held_for_a_look_goes_on_preparing_its_next_snap(gpu: Any) -> None:
    """As looking back between two frames does it; a picture that settles while it is held waits for none."""
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (96, 54), "low", ctx=gpu.ctx) as renderer:
        state = renderer.camera_state(pf.view("near"))
        shown = scene.environment.add(pf.DebugView())
        at = (pf.Camera(state.position_m + 3.0 * n * state.forward, state.forward, state.up) for n in range(60))
        here: Any = None
        ahead: Any = None
        while ahead is None or not ahead.phase:
            before, here = here, next(at)
            renderer.render(here, dt_s=0.016)
            ahead = renderer.views[0].snap
        begun, generation = ahead.number, renderer.views[0].proxy.generation
        for _ in range(60):
            shown.freeze = True
            renderer.render(before, dt_s=0.0)
            shown.freeze = False
            renderer.render(here, dt_s=0.016)
            if renderer.views[0].proxy.generation > generation:
                break
        assert renderer.views[0].proxy.generation > generation and ahead.number <= begun + 1
        shown.freeze = True
        renderer.settle(here)
        assert ahead.proxy is None


def test_a_fade_that_ends_while_it_is_frozen_leaves_the_cells_that_it_led_to(gpu: Any) -> None:
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (96, 54), "low", ctx=gpu.ctx) as renderer:
        state, fade = renderer.camera_state(pf.view("near")), None
        shown = scene.environment.add(pf.DebugView())
        for n in range(90):
            camera = pf.Camera(state.position_m + 3.0 * n * state.forward, state.forward, state.up)
            seen = renderer.render(camera, dt_s=0.016, outputs=("surface",))["surface"] > 0
            fade = renderer.system("terrain").backend.view(renderer.views[0]).fade  # type: ignore[union-attr]
            if fade.running:
                break
        assert fade is not None and fade.running
        shown.freeze = True
        for _ in range(30):
            frozen = renderer.render(camera, dt_s=0.1, outputs=("surface",))["surface"] > 0
        assert not fade.running
        assert (frozen != seen).mean() < 0.01


def test_what_the_second_camera_does_not_see_is_no_pop() -> None:
    """A second camera that is turned to the right has the right of the first one's picture."""
    from planetfall.benchmarks.measure.popping import both_see

    with pf.load_scene("moon") as scene, pf.Renderer(scene, (96, 54), "low") as renderer:
        camera = pf.Camera.at(10.0, 20.0, 2000.0, 40.0, -60.0, planet=scene.planet, above="ground")
        turned = pf.Camera.at(10.0, 20.0, 2000.0, 70.0, -60.0, planet=scene.planet, above="ground")
        out = renderer.render(camera, outputs=("position", "surface"))
        first, second = renderer.camera_state(camera), renderer.camera_state(turned)
        assert both_see(first, first, out)[out["surface"] > 0].all()
        seen = both_see(second, first, out)
        assert seen[:, 80:].mean() > 0.6 and seen[:, :16].mean() < 0.1
