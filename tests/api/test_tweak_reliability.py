"""Storms of syntax errors and of presets: nothing is lost, nothing grows."""

from __future__ import annotations

import gc
import os
import random
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planetfall as pf
from planetfall.app.tweak_store import SceneStore
from planetfall.render import renderer as renderer_module
from planetfall.scene.presets import load_parts
from planetfall.systems.tweak import Workbench

pytestmark = pytest.mark.gpu

SIZE = (96, 54)


class Stage:
    def __init__(self, gpu: Any) -> None:
        self.scene = pf.load_scene("earth")
        self.scene.environment[pf.Exposure].mode = "fixed"
        self.renderer = pf.Renderer(self.scene, SIZE, "low", ctx=gpu.ctx)
        self.renderer.tolerant = True
        self.target = gpu.ctx.simple_framebuffer(SIZE, 4)

    def draw(self, camera: Any = None) -> np.ndarray:
        if camera is None:
            camera = pf.Camera.at(3.0, 140.0, 0.4 * self.scene.planet.radius_m, 0.0, -60.0, planet=self.scene.planet)
        self.renderer.render_to(self.target, camera, 0.0, dt_s=0.1)
        return np.frombuffer(self.target.read(components=3), np.uint8).astype(int)

    def release(self) -> None:
        self.renderer.gpu.leave(self.target)
        self.renderer.release()
        self.target.release()
        self.scene.release()


@pytest.fixture
def shaders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(pf.ASSETS / "shaders", tmp_path / "shaders")
    monkeypatch.setattr(renderer_module, "ASSETS", tmp_path)
    return tmp_path / "shaders"


@pytest.fixture
def stage(gpu: Any, shaders: Path) -> Iterator[Stage]:
    made = Stage(gpu)
    yield made
    made.release()


def broken(text: str, draw: random.Random) -> str:
    """As an editor leaves it while somebody types."""
    kind, at = draw.randrange(5), draw.randrange(max(len(text), 1))
    if kind == 0:
        return text[:at]
    if kind == 1:
        return text[:at] + draw.choice([";", "{", "}", "(", "#if", "#include", "@", "float", "\0"]) + text[at:]
    if kind == 2:
        return text.replace(draw.choice(["float", "vec3", ";", "main", "}"]), "", 1)
    if kind == 3:
        return "\n".join(draw.sample(text.splitlines(), len(text.splitlines())))
    return ""


def test_hot_reload_under_a_storm_of_syntax_errors(stage: Stage, shaders: Path) -> None:
    stage.draw()
    camera = pf.Camera.at(3.0, 140.0, 0.4 * stage.scene.planet.radius_m, 0.0, -60.0, planet=stage.scene.planet)
    for heading in range(20):  # shaders that are made ahead are there
        stage.draw(pf.Camera.at(3.0, 140.0, 0.4 * stage.scene.planet.radius_m, float(heading), -60.0))
    stage.renderer.settle(camera, 0.0)
    good, counts = stage.draw(camera), stage.renderer.gpu.counts()
    files = sorted(path for path in shaders.rglob("*") if path.suffix in (".frag", ".vert", ".comp", ".glsl"))
    texts = {path: path.read_text() for path in files}
    draw = random.Random(7)
    told, rounds = 0, 8
    for _ in range(rounds):
        hit = draw.sample(files, 5)
        for path in hit:
            path.write_text(broken(texts[path], draw))
        stage.renderer.reload_shaders()
        picture = stage.draw(camera)
        told += bool(stage.renderer.gpu.shaders.errors)
        assert not stage.renderer.faults
        assert picture.shape == good.shape
        for path in hit[:-1]:  # one of them stays as it is for a while
            path.write_text(texts[path])
    assert told > 0.6 * rounds
    for path, text in texts.items():
        if path.read_text() != text:
            path.write_text(text)
    stage.renderer.reload_shaders()
    assert not stage.renderer.gpu.shaders.errors
    stage.renderer.settle(camera, 0.0)
    assert (stage.draw(camera) == good).all()
    # Tables of the air may have come from a cache before; now their own programs have made them.
    after = stage.renderer.gpu.counts()
    assert {**after, "atmosphere": {}} == {**counts, "atmosphere": {}}
    assert stage.renderer.gpu.ctx.error == "GL_NO_ERROR"


def resident_kb() -> int:
    status = Path("/proc/self/status")
    if not status.exists():
        pytest.skip("no /proc to read memory from")
    return int(next(line for line in status.read_text().splitlines() if line.startswith("VmRSS")).split()[1])


def handles() -> int:
    return len(os.listdir("/proc/self/fd"))


def switch_presets(gpu: Any, times: int) -> None:
    """Load planet after planet into one scene that is being drawn, as the settings do."""
    stage = Stage(gpu)
    try:
        bench = Workbench(SceneStore(stage.scene))
        planets = ("mars", "earth", "moon", "hazy")
        held: list[tuple[Any, int, int]] = []
        for number in range(times):
            assert bench.to(load_parts(planets[number % 4]), "load") == ""
            stage.draw()
            if number % 4 == 3:
                gc.collect()
                held.append((stage.renderer.gpu.counts(), handles(), resident_kb()))
        assert len(bench.history) == times
        middle = held[len(held) // 2 :]
        assert all(counts == middle[0][0] for counts, _, _ in middle)
        assert all(files == middle[0][1] for _, files, _ in middle)
        # A switch makes some ten MB anew. Held, fifty of them would be hundreds; noise of the allocator is below 30.
        assert middle[-1][2] - middle[0][2] < 30_000
        while bench.undo():
            pass
        assert stage.scene.planet.radius_m > 6e6 and stage.scene.planet.has(pf.Ocean)
    finally:
        stage.release()


def test_switching_presets_leaves_nothing_behind(gpu: Any) -> None:
    switch_presets(gpu, 12)


@pytest.mark.slow
def test_100_switches_of_presets_leave_nothing_behind(gpu: Any) -> None:
    switch_presets(gpu, 100)
