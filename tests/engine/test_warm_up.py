"""Shaders that later frames will need are made before they do, one a frame, and by no picture by itself."""

from __future__ import annotations

from typing import Any

import planetfall as pf
from planetfall.benchmarks.measure.motion import turned
from planetfall.engine.gpu.errors import ShaderError
from planetfall.engine.warm_up import WarmUp

SIZE = (64, 36)


class _Frame:
    def __init__(self, one_shot: bool = False, settling: bool = False) -> None:
        self.one_shot, self.settling = one_shot, settling


def test_one_a_frame_in_order() -> None:
    made: list[int] = []
    warming = WarmUp([lambda k=k: made.append(k) for k in range(3)])
    alone: list[Any] = [_Frame(one_shot=True), _Frame(settling=True)]
    for frame in alone:
        warming.step(frame)
    assert made == []
    live: Any = _Frame()
    for _ in range(5):
        warming.step(live)
    assert made == [0, 1, 2]


def test_a_broken_shader_does_not_stop_the_frame() -> None:
    made: list[int] = []

    def broken() -> None:
        raise ShaderError("sea.comp", "a comma is missing", [])

    warming = WarmUp([broken, lambda: made.append(1)])
    live: Any = _Frame()
    warming.step(live)
    warming.step(live)
    assert made == [1]


def test_the_sea_has_its_shaders_before_a_flight_needs_them() -> None:
    """From space to the water: nothing is built after the first frames, and single pictures build nothing ahead."""
    scene = pf.load_scene("earth")
    heights = (2e7, 2e5, 9e3, 1e3, 20.0, 2.0)
    cameras = [pf.Camera.at(0.0, -30.0, height, pitch_deg=-20.0) for height in heights]
    cameras[0] = pf.Camera.at(0.0, -30.0, heights[0], pitch_deg=-90.0)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.render(cameras[0])
        built = renderer.gpu.work.snapshot()["programs_built"]
        renderer.render(cameras[0])
        assert renderer.gpu.work.snapshot()["programs_built"] == built
        target = renderer.ctx.simple_framebuffer(SIZE)
        for looking in turned(renderer.camera_state(cameras[0]), 0.01, 30):
            renderer.render_to(target, looking, dt_s=1.0 / 60.0)
        ready = renderer.gpu.work.snapshot()["programs_built"]
        assert ready > built
        for camera in cameras:
            for _ in range(2):
                renderer.render_to(target, camera, dt_s=1.0 / 60.0)
        assert renderer.gpu.work.snapshot()["programs_built"] == ready
        renderer.gpu.leave(target)
        target.release()


def test_what_is_made_ahead_is_linked_ahead(scope) -> None:
    scope.gpu.shaders.add_virtual("test/ahead.comp", "layout(local_size_x = 1) in;\nvoid main() {}\n")
    scope.gpu.shaders.late = True
    try:
        program = scope.compute("test/ahead.comp")
    finally:
        scope.gpu.shaders.late = False
    assert not program.linked.is_linked
    live: Any = _Frame()
    WarmUp([lambda: program]).step(live)
    assert program.linked.is_linked
