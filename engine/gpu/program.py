"""Programs, compute shaders, full-screen passes and vertex arrays that survive hot reload."""

from __future__ import annotations

import logging
import re
import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from . import gl as G
from .errors import GpuError, ShaderError
from .preprocess import Defines, Expanded
from .shaders import LinkedProgram, ShaderLibrary, Stages, describe, unknown_uniform

if TYPE_CHECKING:
    from .device import Device

__all__ = ["Compute", "Fullscreen", "Program", "VertexArray"]

UniformValue: TypeAlias = float | np.generic | Sequence[float] | Sequence[Sequence[float]] | NDArray[np.generic]

log = logging.getLogger(__name__)


def _same(held: object, value: object) -> bool:
    """Whether two values of one class are surely the same: numbers or tuples of them; arrays may change in place."""
    kind = value.__class__
    if kind is tuple:
        return bool(value) and isinstance(value[0], (int, float)) and value == held  # type: ignore[index]
    return kind in (int, float, bool) and value == held


class Program:
    """A program by its files. Values set here are kept: they are set again after a reload, and after another wrapper
    has used the GL program that both share.

    moderngl's object is `.mgl`; it changes on reload, so do not keep it.
    """

    def __init__(self, gpu: Device, stages: Stages, defines: Defines | None = None) -> None:
        self._gpu = gpu
        self._library: ShaderLibrary = gpu.shaders
        self._stages = dict(stages)
        self._defines = dict(defines or {})
        self._values: dict[str, UniformValue] = {}
        self.error: ShaderError | None = None
        self.alive = True
        expanded = self._library.expand(self._stages, self._defines)
        self._take_sources(expanded)
        self.linked: LinkedProgram = self._library.acquire(expanded, self.name)
        self._failed_key = ""
        self._generation = self._library.sources.generation
        self._library.register(self)

    @property
    def name(self) -> str:
        return describe(self._stages)

    @property
    def mgl(self) -> moderngl.Program | moderngl.ComputeShader:
        return self.linked.mgl

    @property
    def files(self) -> frozenset[str]:
        """Every source file that took part."""
        return self._files

    def _take_sources(self, expanded: dict[str, Expanded]) -> None:
        self._files = frozenset().union(*(e.files for e in expanded.values()))
        # Of each file, which most programs share; and what the defines bring in.
        files = (self._library.sources.words(file) for file in self._files)
        self._words = (*files, frozenset(re.findall(r"\w+", repr(self._defines))))

    def mentions(self, name: str) -> bool:
        """Whether a source has this word: an optimised-out name is fine, a misspelt one is not."""
        return any(name in words for words in self._words)

    def set(self, name: str, value: UniformValue) -> None:
        """Set a uniform: a number, a tuple, an array (matrices column by column). Optimised-out names are ignored.

        KeyError for a name that no source mentions, ValueError for a value of the wrong shape.
        """
        held = self._values.get(name)
        if held.__class__ is value.__class__ and self.linked.holder is self and _same(held, value):
            return
        if held is None and name not in self._values and not self.mentions(name.partition("[")[0]):
            raise KeyError(unknown_uniform(name, self.name, self.linked.mgl))
        self._values[name] = value
        # As holder all of its values are in the program.
        if self.linked.holder is self:
            try:
                self._write(name, value)
            except ValueError:
                if held is None:
                    del self._values[name]
                else:
                    self._values[name] = held  # what is there still; the same mistake is one again
                raise

    def _write(self, name: str, value: UniformValue) -> None:
        found = self.linked.mgl.get(name, None)
        if not isinstance(found, moderngl.Uniform):
            return
        member: Any = found  # the stubs lack fmt
        try:
            if isinstance(value, np.ndarray):
                kind = {"f": "f4", "d": "f8", "i": "i4", "I": "u4"}[member.fmt[-1]]
                data = np.ascontiguousarray(value, kind)
                if data.size != member.dimension * member.array_length:
                    raise ValueError(f"{data.size} numbers")
                member.write(data.tobytes())
            else:
                member.value = value
        except (struct.error, TypeError, ValueError) as error:
            raise ValueError(
                f"uniform {name!r} of {self.name}: expected {member.array_length} x {member.dimension} numbers "
                f"({member.fmt}), found {value!r} ({error})"
            ) from None

    def use(self) -> LinkedProgram:
        """Make sure that the sources are current and this wrapper's values are in the program; called by render()."""
        if self._generation != self._library.sources.generation:
            self.refresh(None)
        linked = self.linked
        if linked.holder is not self:
            linked.holder = self
            for name, value in self._values.items():
                self._write(name, value)
        return linked

    def refresh(self, changed: set[str] | None) -> bool:
        """Rebuild if the expanded sources differ now; changed: names of changed files (None: any may have changed).

        True if the program was rebuilt. On an error the last good program stays and `error` says why.
        """
        generation = self._library.sources.generation
        untouched = changed is not None and not (changed & self._files)
        if untouched and self._generation == generation and self.error is None:
            return False
        self._generation = generation
        try:
            expanded = self._library.expand(self._stages, self._defines)
            key = self._library.key_of(expanded)
            if key == self.linked.key:
                self.error, self._failed_key = None, ""
                return False
            if key == self._failed_key:
                return False
            self._failed_key = key
            self._files |= frozenset().union(*(e.files for e in expanded.values()))
            fresh = self._library.acquire(expanded, self.name, at_once=True)
        except ShaderError as error:
            if self.error is None or str(self.error) != str(error):
                log.error("%s (the last good version stays in use)", error)
            self.error = error
            return False
        old, self.linked = self.linked, fresh
        self._take_sources(expanded)
        self.error, self._failed_key = None, ""
        if old.holder is self:
            old.holder = None
        self._library.give_back(old)
        return True

    def release(self) -> None:
        """Give the GL program back; freed when nobody else shares it."""
        if self.alive:
            self.alive = False
            if self.linked.holder is self:
                self.linked.holder = None
            self._library.unregister(self)
            self._library.give_back(self.linked)


class Compute(Program):
    """A compute shader. run() and run_indirect() issue no barrier: the frame graph does, or Gpu.barrier()."""

    def __init__(self, gpu: Device, file: str, defines: Defines | None = None) -> None:
        super().__init__(gpu, {"compute": file}, defines)
        self._local: tuple[LinkedProgram, tuple[int, ...]] | None = None

    @property
    def local_size(self) -> tuple[int, int, int]:
        """Invocations of a work group in x, y, z."""
        if self._local is None or self._local[0] is not self.linked:
            size = self._gpu.gl.program_integers(self.linked.mgl.glo, G.COMPUTE_WORK_GROUP_SIZE, 3)
            self._local = (self.linked, size)
        x, y, z = self._local[1]
        return x, y, z

    def run(self, x: int = 1, y: int = 1, z: int = 1) -> None:
        """Dispatch x * y * z work groups."""
        linked = self.use()
        self._gpu.work.dispatches += 1
        if self._gpu.watch is not None:
            self._gpu.watch.dispatched(linked)
        self._shader(linked).run(x, y, z)

    def run_over(self, x: int, y: int = 1, z: int = 1) -> None:
        """Dispatch enough work groups for x * y * z invocations; the shader has to check its bounds."""
        self.use()
        a, b, c = self.local_size
        self.run(-(-x // a), -(-y // b), -(-z // c))

    def run_indirect(self, buffer: moderngl.Buffer, offset: int = 0) -> None:
        """Dispatch the work groups that three uints at `offset` bytes of the buffer name."""
        linked = self.use()
        self._gpu.work.dispatches += 1
        if self._gpu.watch is not None:
            self._gpu.watch.dispatched(linked, buffer)
        self._shader(linked).run_indirect(buffer, offset)

    @staticmethod
    def _shader(linked: LinkedProgram) -> moderngl.ComputeShader:
        assert isinstance(linked.mgl, moderngl.ComputeShader)
        return linked.mgl


Content: TypeAlias = Sequence[tuple[moderngl.Buffer, *tuple[str, ...]]]


class VertexArray:
    """Buffers bound to a program's inputs, built when the program is, and again when that is rebuilt. `mgl`: moderngl's
    object of the moment, if there is one yet."""

    def __init__(
        self,
        gpu: Device,
        program: Program,
        content: Content = (),
        index: moderngl.Buffer | None = None,
        index_size: int = 4,
    ) -> None:
        if isinstance(program, Compute):
            raise GpuError(f"{program.name} is a compute shader: it takes no vertices")
        self._gpu, self.program = gpu, program
        for _, _, *names in content:
            for name in names:
                if isinstance(name, str) and not program.mentions(name):
                    raise GpuError(f"program {program.name} has no input {name!r}, and no source of it mentions one")
        self._content, self._index, self._index_size = list(content), index, index_size
        self._linked: LinkedProgram | None = None
        self._mgl: moderngl.VertexArray | None = None
        self.alive = True
        if program.linked.is_linked:
            self._build(program.linked)

    def _build(self, linked: LinkedProgram) -> moderngl.VertexArray:
        assert isinstance(linked.mgl, moderngl.Program)
        if self._mgl is not None:
            self._mgl.release()
        self._mgl = self._gpu.ctx.vertex_array(
            linked.mgl, self._content, index_buffer=self._index, index_element_size=self._index_size, skip_errors=True
        )
        self._linked = linked
        return self._mgl

    def _ready(self, indirect: moderngl.Buffer | None = None) -> moderngl.VertexArray:
        linked = self.program.use()
        self._gpu.work.draws += 1
        if self._gpu.watch is not None:
            self._gpu.watch.drawn(linked, (*(part[0] for part in self._content), self._index), indirect)
        return self._mgl if linked is self._linked and self._mgl is not None else self._build(linked)

    @property
    def mgl(self) -> moderngl.VertexArray | None:
        return self._mgl

    def set_buffers(self, content: Content = (), index: moderngl.Buffer | None = None, index_size: int = 4) -> None:
        """Other buffers from now on (grown ones, say)."""
        self._content, self._index, self._index_size = list(content), index, index_size
        if self.program.linked.is_linked:
            self._build(self.program.linked)

    def render(self, mode: int = moderngl.TRIANGLES, vertices: int = -1, first: int = 0, instances: int = 1) -> None:
        """Draw. vertices -1: all that the buffers hold."""
        self._ready().render(mode, vertices, first, instances)

    def render_indirect(
        self, buffer: moderngl.Buffer, mode: int = moderngl.TRIANGLES, count: int = -1, first: int = 0
    ) -> None:
        """Draw `count` commands from the buffer, from command `first` on; each has 20 bytes, array draws too."""
        self._ready(buffer).render_indirect(buffer, mode, count, first)

    def release(self) -> None:
        if self.alive:
            self.alive = False
            if self._mgl is not None:
                self._mgl.release()


class Fullscreen:
    """A fragment shader over every pixel of the bound framebuffer: one triangle, `v_ndc` and `v_uv` as inputs."""

    VERTEX = "common/fullscreen.vert"

    def __init__(self, program: Program, vertex_array: VertexArray) -> None:
        self.program, self._vertex_array = program, vertex_array

    @property
    def alive(self) -> bool:
        return self.program.alive

    def set(self, name: str, value: UniformValue) -> None:
        """Set a uniform; see Program.set."""
        self.program.set(name, value)

    def render(self) -> None:
        """Draw into the bound framebuffer's viewport."""
        self._vertex_array.render(moderngl.TRIANGLES, 3)

    def render_indirect(self, buffer: moderngl.Buffer, first: int = 0) -> None:
        """Draw as command `first` of the buffer says: 3 vertices, or none."""
        self._vertex_array.render_indirect(buffer, moderngl.TRIANGLES, 1, first)

    def release(self) -> None:
        self._vertex_array.release()
        self.program.release()
