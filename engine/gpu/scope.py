"""GpuScope: every GL object has an owner, and an owner's objects go together."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, cast

import moderngl
import numpy as np

from .errors import FormatError, GpuError
from .preprocess import Defines
from .program import Compute, Content, Fullscreen, Program, VertexArray
from .textures import AnyTexture, Data, create_texture, texture_bytes
from .uniforms import UniformBlock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .device import Device
    from .timers import GpuTimers

__all__ = ["GpuScope"]

T = TypeVar("T")


class _Releasable(Protocol):
    def release(self) -> object: ...


class GpuScope:
    """Makes GL objects in the name of `owner` and frees them together. Made by Gpu.scope().

    Objects may also be released one by one (obj.release() or free()); the count follows.
    """

    def __init__(self, gpu: Device, owner: str) -> None:
        self.gpu, self.owner = gpu, owner
        # What is the GPU's, at hand: see Gpu.
        self.ctx, self.gl, self.caps, self.shaders = gpu.ctx, gpu.gl, gpu.caps, gpu.shaders
        self.state, self.barrier, self.apart, self.upload = gpu.state, gpu.barrier, gpu.apart, gpu.upload
        self.clear, self.copy_color, self.upload_part = gpu.clear, gpu.copy_color, gpu.upload_part
        self._objects: dict[int, tuple[str, Any]] = {}
        self._parts: list[GpuScope] = []
        self.released = False
        gpu.count_in(self)

    def beside(self, owner: str) -> GpuScope:
        """A further scope on the same GPU, counted under `owner`."""
        return GpuScope(self.gpu, owner)

    def part(self) -> GpuScope:
        """A scope for some of this owner's objects, which may be released before the others and goes with them."""
        self._check()
        self._parts = [part for part in self._parts if not part.released]
        self._parts.append(self.beside(self.owner))
        return self._parts[-1]

    # -- accounting --------------------------------------------------------------------------------------------------

    def _own(self, kind: str, obj: T) -> T:
        self._objects[id(obj)] = (kind, obj)
        return obj

    def _check(self) -> None:
        if self.released:
            raise GpuError(f"the GL scope of {self.owner!r} was released: ask Gpu.scope() for a new one")

    def counts(self) -> dict[str, int]:
        """Live objects by kind."""
        gone = [key for key, (_, obj) in self._objects.items() if not _alive(obj)]
        for key in gone:
            del self._objects[key]
        return dict(Counter(kind for kind, _ in self._objects.values()))

    def bytes(self) -> int:
        """Memory of its textures (all levels and layers) and buffers, as they were asked for: what a driver adds to
        each is its own affair."""
        self.counts()  # forgets what is gone
        total = 0
        for kind, obj in self._objects.values():
            if kind == "texture":
                total += texture_bytes(obj)
            elif kind == "buffer":
                total += obj.size if isinstance(obj, moderngl.Buffer) else obj.layout.size  # or a uniform block
        return total

    def free(self, obj: _Releasable) -> None:
        """Release one object made here (a Fullscreen frees its program and vertex array)."""
        self._objects.pop(id(obj), None)
        if isinstance(obj, moderngl.Framebuffer):
            self.gpu.leave(obj)
        if _alive(obj):
            obj.release()

    def release(self) -> None:
        """Free everything, users before what they use. May be called twice."""
        for part in self._parts:
            part.release()
        self._parts.clear()
        for _, obj in reversed(list(self._objects.values())):
            self.free(obj)
        self._objects.clear()
        self.released = True
        self.gpu.forget(self)

    # -- memory ------------------------------------------------------------------------------------------------------

    def texture(
        self,
        size: tuple[int, ...],
        format: str,
        data: Data | None = None,
        levels: int = 1,
        layers: int = 1,
        filter: str = "nearest",
        wrap: str = "clamp",
    ) -> moderngl.Texture:
        """A texture: 2D; an array if layers > 1; 3D if size has three numbers. Returns moderngl's object, whose calls
        are the same for all three.

        format: see gpu.textures.FORMATS. data: bytes or an array for level 0, from which coarser levels are filled
        (not of integers); what isn't filled is undefined. filter: nearest, linear (nearest level), trilinear. wrap:
        clamp or repeat. FormatError for unknown formats, size 0, sizes beyond the GPU's limits.
        """
        self._check()
        self.gpu.check_error(f"something before a texture of {self.owner!r}")  # or it would be blamed on this texture
        made = create_texture(self.ctx, self.gl, self.caps, tuple(size), format, data, levels, layers, filter, wrap)
        return self._own("texture", cast(moderngl.Texture, made))

    def buffer(self, data: Data | None = None, reserve: int = 0, dynamic: bool = False) -> moderngl.Buffer:
        """A buffer with `data` (bytes or an array) or `reserve` bytes, content undefined."""
        self._check()
        if data is not None:
            data = np.ascontiguousarray(data) if isinstance(data, np.ndarray) else bytes(data)
        size = reserve if data is None else (data.nbytes if isinstance(data, np.ndarray) else len(data))
        if size < 1:
            raise FormatError(f"a buffer needs data or a size of at least 1 byte, found {size} (owner {self.owner!r})")
        limit = self.caps.max_storage_block_bytes
        if size > limit:
            raise FormatError(
                f"a buffer of {size} bytes for {self.owner!r} is beyond this GPU's limit of {limit} for storage "
                "buffers; choose a lower quality"
            )
        self.gpu.check_error(f"something before a buffer of {self.owner!r}")
        made = self.ctx.buffer(data, reserve=0 if data is not None else reserve, dynamic=dynamic)
        error = self.ctx.error
        if error != "GL_NO_ERROR":
            made.release()
            raise GpuError(f"a buffer of {size / 2**20:.1f} MiB for {self.owner!r}: {error}")
        return self._own("buffer", made)

    def framebuffer(
        self, colors: Sequence[AnyTexture] = (), depth: moderngl.Texture | None = None
    ) -> moderngl.Framebuffer:
        """A framebuffer over whole textures of equal size. GpuError where the driver cannot draw into a format."""
        self._check()
        sizes = {tuple(t.size)[:2] for t in (*colors, *((depth,) if depth is not None else ()))}
        if len(sizes) != 1:
            raise FormatError(f"a framebuffer needs attachments of one size, found {sorted(sizes) or 'none'}")
        try:
            return self._own("framebuffer", self.ctx.framebuffer(list(colors), depth))
        except moderngl.Error as error:
            names = [getattr(t.extra, "format", None) for t in (*colors, depth) if t is not None]
            formats = ", ".join(f.name if f else "?" for f in names)
            raise GpuError(f"this GPU cannot draw into the formats {formats} together: {error}") from None

    def sampler(self, filter: str = "linear", wrap: str = "clamp", compare: str = "") -> moderngl.Sampler:
        """A sampler object: filter nearest, linear or trilinear; wrap clamp or repeat; compare "" or a depth test."""
        self._check()
        modes = {
            "nearest": (moderngl.NEAREST, moderngl.NEAREST),
            "linear": (moderngl.LINEAR, moderngl.LINEAR),
            "trilinear": (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR),
        }
        if filter not in modes or wrap not in ("clamp", "repeat"):
            raise FormatError(f"filter is one of {', '.join(modes)} and wrap clamp or repeat: {filter=}, {wrap=}")
        repeat = wrap == "repeat"
        made = self.ctx.sampler(
            repeat_x=repeat, repeat_y=repeat, repeat_z=repeat, filter=modes[filter], compare_func=compare
        )
        return self._own("sampler", made)

    def own_timers(self, timers: GpuTimers) -> GpuTimers:
        """Count timers as one "query" of this owner."""
        return self._own("query", timers)

    def uniform_block(self, block: type, binding: int, instance: str | None = None) -> UniformBlock:
        """A std140 uniform buffer for a dataclass (see layout.StructLayout).

        instance: if given, `#include "generated/<instance>.glsl"` declares the block under that instance name.
        """
        self._check()
        made = UniformBlock(self.gpu, block, binding)
        if instance is not None:
            self.shaders.add_virtual(f"generated/{instance}.glsl", made.layout.block(binding, instance))
        return self._own("buffer", made)

    # -- programs ----------------------------------------------------------------------------------------------------

    def program(
        self,
        vertex: str,
        fragment: str | None = None,
        geometry: str | None = None,
        tess_control: str | None = None,
        tess_evaluation: str | None = None,
        defines: Defines | None = None,
    ) -> Program:
        """A program from shader files, named relative to the shader roots.

        ShaderError maps the driver's log to file:line.
        """
        self._check()
        given = {
            "vertex": vertex,
            "fragment": fragment,
            "geometry": geometry,
            "tess_control": tess_control,
            "tess_evaluation": tess_evaluation,
        }
        stages = {stage: file for stage, file in given.items() if file is not None}
        return self._own("program", Program(self.gpu, stages, defines))

    def compute(self, file: str, defines: Defines | None = None) -> Compute:
        """A compute shader."""
        self._check()
        return self._own("program", Compute(self.gpu, file, defines))

    def vertex_array(
        self, program: Program, content: Content = (), index: moderngl.Buffer | None = None, index_size: int = 4
    ) -> VertexArray:
        """Buffers for a program's inputs: content as in moderngl, [(buffer, "3f 2f", "in_position", "in_uv")]."""
        self._check()
        return self._own("vertex_array", VertexArray(self.gpu, program, content, index, index_size))

    def fullscreen(self, file: str, defines: Defines | None = None) -> Fullscreen:
        """A fragment shader over the whole bound framebuffer (vertex stage common/fullscreen.vert)."""
        self._check()
        program = self.program(Fullscreen.VERTEX, file, defines=defines)
        return Fullscreen(program, self.vertex_array(program))


def _alive(obj: object) -> bool:
    alive = getattr(obj, "alive", None)
    return bool(alive) if alive is not None else not isinstance(getattr(obj, "mglo", None), moderngl.InvalidObject)
