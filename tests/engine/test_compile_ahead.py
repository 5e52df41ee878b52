"""Programs that the driver compiles before they are used: linked late, equal pictures, errors at the first use."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.gpu import Gpu, GpuScope, ShaderError
from planetfall.engine.gpu.compile_ahead import SWITCH, compiles_ahead

GOOD = (
    "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer B { float x[]; };\nvoid main() { x[0] = %s; }\n"
)


@pytest.fixture
def ahead(gpu, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Gpu, GpuScope]]:
    monkeypatch.setenv(SWITCH, "1")
    (tmp_path / "good.comp").write_text(GOOD % "2.0")
    (tmp_path / "bad.comp").write_text(GOOD % "nothing")
    own = Gpu(gpu.ctx, [tmp_path], compile_ahead=True)
    yield own, own.scope("test")
    own.release()


def test_a_program_is_linked_at_its_first_use(ahead):
    gpu, scope = ahead
    program = scope.compute("good.comp")
    assert program.linked.ahead is not None and not program.linked.is_linked
    buffer = scope.buffer(np.zeros(1, np.float32))
    buffer.bind_to_storage_buffer(0)
    program.run()
    assert program.linked.is_linked and program.linked.ahead is None
    gpu.ctx.finish()
    assert np.frombuffer(buffer.read(), np.float32)[0] == 2.0


def test_what_is_not_used_is_never_linked_and_leaves_nothing(ahead):
    gpu, scope = ahead
    program = scope.compute("good.comp")
    name = program.linked.ahead
    assert gpu.gl.is_object("Program", name)
    program.release()
    assert not gpu.gl.is_object("Program", name) and gpu.shaders.program_count == 0


def test_an_error_is_told_at_the_first_use(ahead):
    _, scope = ahead
    program = scope.compute("bad.comp")
    with pytest.raises(ShaderError, match=r"bad\.comp:3.*nothing"):
        program.run()


def test_a_reload_is_linked_at_once_and_a_broken_one_leaves_the_last_good(ahead, tmp_path):
    gpu, scope = ahead
    program = scope.compute("good.comp")
    program.run()
    (tmp_path / "good.comp").write_text(GOOD % "still nothing")
    gpu.shaders.reload_changed()
    assert program.error is not None and program.linked.is_linked
    program.run()
    (tmp_path / "good.comp").write_text(GOOD % "3.25")
    gpu.shaders.reload_changed()
    assert program.error is None and program.linked.is_linked


def test_pictures_are_the_same(monkeypatch):
    pictures = []
    for switch in ("0", "1"):
        monkeypatch.setenv(SWITCH, switch)
        with pf.load_scene("earth") as scene, pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
            pictures.append(renderer.snapshot(pf.view("near", scene.planet)).array)
    np.testing.assert_array_equal(*pictures)


def test_nobody_compiles_ahead_unasked(gpu, monkeypatch):
    monkeypatch.delenv(SWITCH, raising=False)
    assert compiles_ahead(gpu.ctx, gpu.caps) == ("NVIDIA" in gpu.caps.vendor)
    monkeypatch.setenv(SWITCH, "0")
    assert not compiles_ahead(gpu.ctx, gpu.caps)
