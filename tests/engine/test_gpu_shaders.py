"""Programs: compile errors with places, sharing, uniforms, hot reload, contracts."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from planetfall import ASSETS
from planetfall.engine.gpu import Gpu, GpuScope, ShaderError

FRAGMENT = "out vec4 o;\nuniform float u_level;\nvoid main() { o = vec4(u_level); }\n"


class Bench:
    """A Gpu over a scratch shader folder (and the library's own), with a 1 x 1 target to look at."""

    def __init__(self, ctx, folder: Path) -> None:
        self.folder = folder
        self.gpu = Gpu(ctx, [folder, ASSETS / "shaders"])
        self.scope: GpuScope = self.gpu.scope("bench")
        self._time_ns = 10**18
        self._texture = self.scope.texture((1, 1), "rgba32f")
        self.framebuffer = self.scope.framebuffer([self._texture])

    def write(self, name: str, text: str) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        self._time_ns += 10**9  # the clock of some file systems is too coarse for a test
        os.utime(path, ns=(self._time_ns, self._time_ns))

    def shown(self, screen) -> list[float]:
        self.framebuffer.use()
        screen.render()
        return np.frombuffer(self._texture.read(), "f4").tolist()


@pytest.fixture
def bench(gpu, tmp_path):
    made = Bench(gpu.ctx, tmp_path)
    yield made
    made.gpu.release()
    assert made.gpu.shaders.program_count == 0
    assert gpu.ctx.error == "GL_NO_ERROR"


def test_compile_errors_name_file_and_line(bench):
    bench.write("lib.glsl", "float ok() { return 1.0; }\nfloat bad() { return nothing; }\n")
    bench.write("a.frag", 'out vec4 o;\n#include "lib.glsl"\nvoid main() { o = vec4(bad()); }\n')
    with pytest.raises(ShaderError) as caught:
        bench.scope.fullscreen("a.frag", {"SOME": 1})
    error = caught.value
    assert (error.file, error.line) == ("lib.glsl", 2)
    assert "common/fullscreen.vert + a.frag: compilation failed" in str(error)
    assert "lib.glsl:2: error:" in str(error) and "nothing" in error.message
    assert bench.scope.counts() == {"texture": 1, "framebuffer": 1}


def test_linked_programs_keep_no_shaders(bench):
    """They would hold their text, and compiled anew their syntax trees: 60 MB of all that a first picture needs."""
    bench.write("a.comp", "layout(local_size_x = 1) in;\nvoid main() {}\n")
    bench.write("a.frag", FRAGMENT)
    screen = bench.scope.fullscreen("a.frag")
    for program in (bench.scope.compute("a.comp"), screen.program):
        assert bench.gpu.gl.program_integers(program.mgl.glo, 0x8B85) == (0,)  # GL_ATTACHED_SHADERS
    screen.set("u_level", 0.5)
    assert bench.shown(screen) == [0.5] * 4


def test_compute_and_link_errors(bench):
    bench.write("a.comp", "layout(local_size_x = 1) in;\n\nvoid main() { int x = 1.0 }\n")
    with pytest.raises(ShaderError) as caught:
        bench.scope.compute("a.comp")
    assert (caught.value.file, caught.value.line) == ("a.comp", 3)
    bench.write("b.frag", "out vec4 o;\nvec4 f();\nvoid main() { o = f(); }\n")
    with pytest.raises(ShaderError, match="linking failed"):
        bench.scope.fullscreen("b.frag")


def test_samplers_of_two_types_on_one_unit_are_refused(bench):
    bench.write(
        "a.comp",
        "layout(local_size_x = 1) in;\n"
        "layout(binding = 2) uniform sampler2D a;\nlayout(binding = 2) uniform sampler3D b;\n"
        "layout(std430, binding = 0) buffer O { vec4 o; };\n"
        "void main() { o = texelFetch(a, ivec2(0), 0) + texelFetch(b, ivec3(0), 0); }\n",
    )
    with pytest.raises(ShaderError, match=r"share texture unit 2: give each its own layout") as caught:
        bench.scope.compute("a.comp")
    assert caught.value.file == "a.comp" and caught.value.line in (2, 3)
    bench.write(
        "ok.frag",
        "out vec4 o;\nlayout(binding = 0) uniform sampler2D a, b;\n"
        "void main() { o = texelFetch(a, ivec2(0), 0) + texelFetch(b, ivec2(0), 0); }\n",
    )
    bench.scope.fullscreen("ok.frag")


def test_equal_programs_are_one_with_values_of_their_own(bench):
    bench.write("a.frag", FRAGMENT)
    one, two = bench.scope.fullscreen("a.frag"), bench.gpu.scope("other").fullscreen("a.frag")
    three = bench.scope.fullscreen("a.frag", {"OTHER": 1})
    assert one.program.mgl is two.program.mgl is not three.program.mgl
    assert bench.gpu.shaders.program_count == 2 and bench.gpu.work.programs_built == 2
    assert bench.gpu.counts()["bench"]["program"] == 2 and bench.gpu.counts()["other"]["program"] == 1
    one.set("u_level", 1.0)
    two.set("u_level", 2.0)
    assert [bench.shown(s)[0] for s in (one, two, one, two)] == [1, 2, 1, 2]
    one.release()
    assert bench.shown(two)[0] == 2


def test_uniform_values_and_mistakes(bench):
    bench.write(
        "a.frag",
        "out vec4 o; uniform float u_unused;\n"
        "uniform vec3 u_v; uniform mat4 u_m; uniform vec2 u_a[2]; uniform uint u_n;\n"
        "void main() { o = vec4(u_v.z, u_m[3][0], u_a[1].y, float(u_n)); }\n",
    )
    screen = bench.scope.fullscreen("a.frag")
    screen.set("u_v", (1, 2, 3))
    screen.set("u_m", np.arange(16.0).reshape(4, 4))
    screen.set("u_a", [(1, 2), (3, 4)])
    screen.set("u_n", np.uint32(7))
    screen.set("u_unused", 5.0)
    assert bench.shown(screen) == [3, 12, 4, 7]
    with pytest.raises(KeyError, match="has no uniform 'u_w'"):
        screen.set("u_w", 1)
    with pytest.raises(ValueError, match=r"uniform 'u_v' of .*a\.frag: expected 1 x 3 numbers"):
        screen.set("u_v", (1, 2))
    with pytest.raises(ValueError, match="expected 1 x 16 numbers"):
        screen.set("u_m", np.zeros(4))


def test_values_that_did_not_change_are_not_written_again(bench, monkeypatch):
    bench.write("a.frag", FRAGMENT)
    screen = bench.scope.fullscreen("a.frag")
    written, write = [], screen.program._write
    monkeypatch.setattr(screen.program, "_write", lambda name, value: (written.append(value), write(name, value)))
    for value in (0.25, 0.25, 0.5, 0.5, np.float32(0.5), 0.25):
        screen.set("u_level", value)
        assert bench.shown(screen)[0] == value
    assert written == [0.25, 0.5, 0.5, 0.25]  # another type is written: it may not fit
    for _ in range(2):
        with pytest.raises(ValueError, match="u_level"):
            screen.set("u_level", (1.0, 2.0))
    assert bench.shown(screen)[0] == 0.25


def test_hot_reload_keeps_uniforms_and_vertex_arrays(bench):
    bench.write("scale.glsl", "float scale() { return 1.0; }\n")
    bench.write("a.frag", '#include "scale.glsl"\n' + FRAGMENT.replace("vec4(u_level)", "vec4(u_level * scale())"))
    screen = bench.scope.fullscreen("a.frag")
    screen.set("u_level", 2.0)
    assert bench.shown(screen)[0] == 2
    assert bench.gpu.shaders.reload_changed() == []
    bench.write("scale.glsl", "float scale() { return 10.0; }\n")
    assert bench.gpu.shaders.reload_changed() == ["common/fullscreen.vert + a.frag"]
    assert bench.shown(screen)[0] == 20
    assert bench.gpu.shaders.program_count == 1
    assert bench.gpu.counts()["bench"]["vertex_array"] == 1


def test_a_broken_shader_keeps_the_last_good_one(bench, caplog):
    bench.write("a.frag", FRAGMENT)
    screen = bench.scope.fullscreen("a.frag")
    screen.set("u_level", 3.0)
    bench.write("a.frag", FRAGMENT.replace("vec4(u_level)", "vec4(u_levle)"))
    for _ in range(2):
        assert bench.gpu.shaders.reload_changed() == []
        (error,) = bench.gpu.shaders.errors
        assert (error.file, error.line) == ("a.frag", 3) and "u_levle" in error.message
        assert bench.shown(screen)[0] == 3
    assert caplog.text.count("compilation failed") == 1  # said once, not on every look
    bench.write("a.frag", '#include "gone.glsl"\n' + FRAGMENT)
    bench.gpu.shaders.reload_changed()
    assert bench.gpu.shaders.errors[0].line == 1 and "gone.glsl" in bench.gpu.shaders.errors[0].message
    bench.write("gone.glsl", "// back\n")  # only the missing file comes
    assert bench.gpu.shaders.reload_changed() == ["common/fullscreen.vert + a.frag"]
    assert bench.gpu.shaders.errors == []
    bench.write("a.frag", FRAGMENT.replace("vec4(u_level)", "vec4(u_levle)"))
    bench.gpu.shaders.reload_changed()
    bench.write("a.frag", '#include "gone.glsl"\n' + FRAGMENT)  # back to the very text in use
    bench.gpu.shaders.reload_changed()
    assert bench.gpu.shaders.errors == [] and bench.shown(screen)[0] == 3


def test_a_file_that_vanishes_for_a_moment(bench):
    bench.write("a.frag", FRAGMENT)
    screen = bench.scope.fullscreen("a.frag")
    screen.set("u_level", 1.0)
    (bench.folder / "a.frag").unlink()
    bench.gpu.shaders.reload_changed()
    assert len(bench.gpu.shaders.errors) == 1 and bench.shown(screen)[0] == 1
    bench.write("a.frag", FRAGMENT.replace("vec4(u_level)", "vec4(u_level + 1.0)"))
    bench.gpu.shaders.reload_changed()
    assert bench.gpu.shaders.errors == [] and bench.shown(screen)[0] == 2


def test_programs_follow_contracts_at_next_use(bench):
    bench.write("common/tint.glsl", "float tint() { return 1.0; }\n")
    bench.write("sky/tint.glsl", "float tint() { return 5.0; }\n")
    bench.write("bad/tint.glsl", "float tint() { return nothing; }\n")
    bench.write("a.frag", '#include "contract/tint.glsl"\nout vec4 o; void main() { o = vec4(tint()); }\n')
    bench.write("b.frag", "out vec4 o; void main() { o = vec4(9.0); }\n")
    screen, other = bench.scope.fullscreen("a.frag"), bench.scope.fullscreen("b.frag")
    shaders = bench.gpu.shaders
    assert bench.shown(screen)[0] == 1
    shaders.provide("tint", "sky/tint.glsl", "sky")
    built = bench.gpu.work.programs_built
    assert bench.shown(screen)[0] == 5 and bench.shown(other)[0] == 9
    assert bench.gpu.work.programs_built == built + 1
    shaders.withdraw("sky")
    assert bench.shown(screen)[0] == 1
    shaders.provide("tint", "bad/tint.glsl", "bad")
    assert bench.shown(screen)[0] == 1
    assert shaders.errors[0].file == "bad/tint.glsl"
    shaders.withdraw("bad")
    assert bench.shown(screen)[0] == 1 and shaders.errors == []


def test_compute_follows_reloads_too(bench):
    text = "layout(local_size_x = {n}) in;\nlayout(std430, binding = 0) buffer O {{ uint o[]; }};\n" \
           "void main() {{ o[gl_LocalInvocationID.x] = {n}u; }}\n"  # fmt: skip
    bench.write("a.comp", text.format(n=4))
    compute = bench.scope.compute("a.comp")
    buffer = bench.scope.buffer(np.zeros(8, "u4"))
    buffer.bind_to_storage_buffer(0)
    assert compute.local_size == (4, 1, 1)
    bench.write("a.comp", text.format(n=8))
    assert bench.gpu.shaders.reload_changed() == ["a.comp"]
    assert compute.local_size == (8, 1, 1)
    compute.run()
    bench.gpu.barrier()
    np.testing.assert_array_equal(np.frombuffer(buffer.read(), "u4"), np.full(8, 8, "u4"))


def test_unused_inputs_are_skipped_and_misspelt_ones_refused(bench):
    bench.write("a.vert", "in vec2 in_unused; in float in_x; void main() { gl_Position = vec4(in_x); }\n")
    bench.write("a.frag", "out vec4 o; void main() { o = vec4(1.0); }\n")
    program = bench.scope.program("a.vert", "a.frag")
    buffer = bench.scope.buffer(np.zeros(9, "f4"))
    bench.framebuffer.use()
    bench.scope.vertex_array(program, [(buffer, "2f 1f", "in_unused", "in_x")]).render(0)
    with pytest.raises(RuntimeError, match=r"a\.vert \+ a\.frag has no input 'in_y'"):
        bench.scope.vertex_array(program, [(buffer, "1f", "in_y")])


def test_compute_programs_take_no_vertices(bench):
    bench.write("a.comp", "layout(local_size_x = 1) in; void main() {}\n")
    compute = bench.scope.compute("a.comp")
    with pytest.raises(RuntimeError, match=r"a\.comp is a compute shader"):
        bench.scope.vertex_array(compute)


def test_the_packages_own_programs_are_linked_at_their_first_use_and_a_games_at_once(gpu, tmp_path):
    own, game = tmp_path / "own", tmp_path / "game"
    for folder in (own, game):
        folder.mkdir()
    (own / "own.comp").write_text("layout(local_size_x = 1) in;\nvoid main() {}\n")
    (own / "broken.comp").write_text("layout(local_size_x = 1) in;\nvoid main() { nothing; }\n")
    (own / "mixed.comp").write_text('#include "game.glsl"\nlayout(local_size_x = 1) in;\nvoid main() { f(); }\n')
    (game / "game.glsl").write_text("void f() { nothing; }\n")
    made = Gpu(gpu.ctx, [own, game], compile_ahead=True)
    try:
        scope = made.scope("test")
        late, broken = scope.compute("own.comp"), scope.compute("broken.comp")
        assert not late.linked.is_linked and not broken.linked.is_linked
        with pytest.raises(ShaderError, match=r"game\.glsl:1.*nothing"):
            scope.compute("mixed.comp")
        (game / "game.glsl").write_text("void f() {}\n")
        made.shaders.reload_changed()
        assert scope.compute("mixed.comp").linked.is_linked
        made.shaders.link_another()  # the broken one, whose first use tells
        assert not late.linked.is_linked
        made.shaders.link_another()
        assert late.linked.is_linked
        made.shaders.link_another()
        with pytest.raises(ShaderError, match=r"broken\.comp:2.*nothing"):
            broken.run()
    finally:
        made.release()
