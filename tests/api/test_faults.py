"""A system that raises is switched off; the rest is drawn on, and it comes back when something has changed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.frame import Frame
from planetfall.engine.system import System
from planetfall.systems.ocean import OceanSystem
from planetfall.systems.proxy import ProxySystem
from planetfall.systems.terrain.system import TerrainSystem

pytestmark = pytest.mark.gpu

SIZE = (96, 54)


class Moody(System):
    """A game's system that raises where it is told to."""

    name: ClassVar[str] = "moody"
    where: ClassVar[str] = ""

    def _mood(self, where: str) -> None:
        if type(self).where == where:
            raise ZeroDivisionError(f"moody in {where}")

    def setup(self, setup: Any) -> None:
        setup.gpu.buffer(reserve=64)
        self._mood("setup")

    def begin(self, frame: Frame) -> None:
        self._mood("begin")

    def update(self, frame: Frame) -> None:
        self._mood("update")

    def declare(self, builder: Any, view: Any) -> None:
        self._mood("declare")

        def bind(io: Any) -> Any:
            return lambda: self._mood("pass")

        builder.add_pass("moody.draw", bind=bind, system=self.name, reads=("composite.ldr",), writes=("target",),
                         after=("outputs.present",))  # fmt: skip

    def release(self) -> None:
        self._mood("setup")  # what was never set up may well fail here too


class Stage:
    def __init__(self, gpu: Any) -> None:
        self.scene = pf.load_scene("earth")
        self.scene.environment[pf.Exposure].mode = "fixed"
        self.renderer = pf.Renderer(self.scene, SIZE, "low", ctx=gpu.ctx, systems=(Moody,))
        self.renderer.tolerant = True
        self.target = gpu.ctx.simple_framebuffer(SIZE, 4)
        self.view = pf.view("coast", self.scene.planet)

    def draw(self) -> np.ndarray:
        self.renderer.render_to(self.target, self.view, dt_s=0.1)
        return np.frombuffer(self.target.read(components=3), np.uint8).astype(int)


@pytest.fixture
def stage(gpu: Any) -> Iterator[Stage]:
    Moody.where = ""
    before = gpu.counts()
    made = Stage(gpu)
    made.draw()
    made.renderer.settle(made.view)
    yield made
    Moody.where = ""
    made.renderer.gpu.leave(made.target)
    made.renderer.release()
    made.target.release()
    made.scene.release()
    assert gpu.counts() == before and gpu.ctx.error == "GL_NO_ERROR"


@pytest.mark.parametrize("where", ["setup", "begin", "update", "declare", "pass"])
def test_a_games_system_that_raises_is_switched_off_and_comes_back(stage: Stage, where: str) -> None:
    good = stage.draw()
    Moody.where = where
    if where in ("setup", "declare"):
        stage.renderer.gate_again()
        stage.scene.environment.remove(pf.Stars)  # the structure changes: all is declared anew
        if where == "setup":
            Moody.where = ""
            stage.renderer.own.switch_off(next(s for s in stage.renderer.running if s.name == "moody"))
            Moody.where = where
    stage.draw()
    (fault,) = stage.renderer.faults.list
    assert fault.system == "moody" and f"moody in {where}" in fault.report and "Traceback" in fault.report
    assert "moody" not in stage.renderer.gpu.counts()
    assert "moody.draw" not in {report.name for report in stage.renderer.passes()}
    for _ in range(3):  # it isn't asked again
        stage.draw()
    assert len(stage.renderer.faults.list) == 1
    Moody.where = ""
    stage.renderer.faults.forget()
    stage.renderer.gate_again()
    last = stage.draw()
    assert not stage.renderer.faults and "moody.draw" in {report.name for report in stage.renderer.passes()}
    if where not in ("setup", "declare"):
        assert (last == good).all()


def test_the_sea_fails_and_the_ground_is_still_there(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    good = stage.draw()
    original = OceanSystem.update

    def broken(self: Any, frame: Frame) -> None:
        if frame.world.get(frame.planet, pf.Ocean).sea_level_m != 0.0:
            raise ValueError("no such sea")
        original(self, frame)

    monkeypatch.setattr(OceanSystem, "update", broken)
    stage.scene.planet[pf.Ocean].sea_level_m = 1.0
    dry = stage.draw()
    assert [fault.system for fault in stage.renderer.faults.list] == ["ocean"]
    ran = {report.system for report in stage.renderer.passes() if report.ran}
    assert "terrain" in ran and "ocean" not in ran and (dry != good).any()
    stage.scene.planet[pf.Ocean].sea_level_m = 2.0  # a change: tried again, and fails again
    stage.draw()
    assert len(stage.renderer.faults.list) == 1
    stage.scene.planet[pf.Ocean].sea_level_m = 0.0
    stage.draw()
    stage.renderer.settle(stage.view)  # shadows come from coarse to fine, over some frames
    assert (stage.draw() == good).all() and not stage.renderer.faults


def test_what_nothing_can_be_drawn_without_raises_its_own_error(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    good = stage.draw()

    def broken(self: Any, frame: Frame) -> None:
        raise ValueError("no ground under the feet")

    with monkeypatch.context() as patch:
        patch.setattr(ProxySystem, "update", broken)
        with pytest.raises(ValueError, match="no ground under the feet"):
            stage.draw()
        assert not stage.renderer.faults
    assert (stage.draw() == good).all()


def test_without_being_tolerant_it_raises(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self: Any, frame: Frame) -> None:
        raise ValueError("broken")

    stage.renderer.tolerant = False
    with monkeypatch.context() as patch:
        patch.setattr(TerrainSystem, "update", broken)
        with pytest.raises(ValueError, match="broken"):
            stage.draw()
    assert not stage.renderer.faults
    stage.draw()
