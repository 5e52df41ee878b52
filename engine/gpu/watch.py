"""Which objects a pass's commands touch: what the SPIR-V of its programs says, at what is bound when they run.

For authors only (PLANETFALL_VALIDATE=1): each draw and dispatch asks OpenGL what is bound, which takes many times as
long as the command.
"""

from __future__ import annotations

import contextlib
import ctypes as c
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import moderngl

from ..graph.touches import Identity, Touch
from . import gl as G
from .spirv import Access, accesses

if TYPE_CHECKING:
    from .device import Device
    from .shaders import LinkedProgram

__all__ = ["GLWatch"]

T = TypeVar("T")

_TARGETS = {
    0x8B5D: 0x8068, 0x8B5E: 0x8069, 0x8B5F: 0x806A, 0x8B60: 0x8514, 0x8B62: 0x8069, 0x8DC1: 0x8C1D, 0x8DCA: 0x8069,
    0x8DCB: 0x806A, 0x8DCF: 0x8C1D, 0x8DD2: 0x8069, 0x8DD3: 0x806A, 0x8DD7: 0x8C1D, 0x9108: 0x9104,
}  # fmt: skip
"""GL types of samplers -> GL_TEXTURE_BINDING_*."""
_IMAGE_NAME, _STORAGE_BINDING, _UNIFORM_BINDING = 0x8F3A, 0x90D3, 0x8A28
_ACTIVE_TEXTURE, _DRAW_FRAMEBUFFER, _DRAW_FRAMEBUFFER_BINDING = 0x84E0, 0x8CA9, 0x8CA6
_DRAW_BUFFER0, _ATTACHED_NAME, _DEPTH_ATTACHMENT, _COLOR_ATTACHMENT0 = 0x8825, 0x8CD1, 0x8D00, 0x8CE0
_DEPTH_WRITES, _COLOR_WRITES = 0x0B72, 0x0C23
_BUFFER_READS, _BUFFER_WRITES = ("read", "read_into", "read_chunks"), ("write", "clear", "orphan", "write_chunks")
_TEXTURE_READS, _TEXTURE_WRITES = ("read", "read_into"), ("write", "build_mipmaps")


class GLWatch:
    """See engine.graph.watching.PassWatch. Programs have to be linked with their SPIR-V (`LinkedProgram.modules`)."""

    def __init__(self, gpu: Device) -> None:
        self._gpu, self._gl = gpu, gpu.gl
        self._touches: list[Touch] = []
        self._inside = False
        self._stored: dict[Identity, tuple[str, int]] = {}
        """By what, and in which pass, objects were stored to since the last barrier for their kind."""
        self._apart: dict[Identity, tuple[str, int]] | None = None
        """The same, of dispatches that leave each other's texels alone."""
        self._pass = 0
        self._known: dict[str, tuple[tuple[str, Access], ...]] = {}
        self._number = c.c_int()
        pointer = c.POINTER(c.c_int)
        self._get_at = gpu.gl.function("glGetIntegeri_v", None, G.enum, G.uint, pointer)
        self._attached = gpu.gl.function("glGetFramebufferAttachmentParameteriv", None, G.enum, G.enum, G.enum, pointer)
        self._uniform = gpu.gl.function("glGetUniformiv", None, G.uint, c.c_int, pointer)
        self._activate = gpu.gl.function("glActiveTexture", None, G.enum)
        self._follow_copies()

    # -- of the graph ------------------------------------------------------------------------------------------------

    def begin(self) -> None:
        self._touches, self._inside = [], True
        self._pass += 1

    def end(self) -> list[Touch]:
        self._inside = False
        return self._touches

    def identity(self, obj: object) -> Identity | None:
        if isinstance(obj, moderngl.Buffer):
            return "buffer", obj.glo
        if isinstance(obj, moderngl.Framebuffer):
            return "framebuffer", obj.glo
        name = getattr(obj, "glo", None)
        return None if not isinstance(name, int) else ("texture", name)

    # -- of commands -------------------------------------------------------------------------------------------------

    def dispatched(self, linked: LinkedProgram, indirect: moderngl.Buffer | None = None) -> None:
        """Right before a dispatch."""
        self._indirect(indirect)
        self._program(linked)

    def drawn(self, linked: LinkedProgram, inputs: Iterable[Any], indirect: moderngl.Buffer | None = None) -> None:
        """Right before a draw. inputs: vertex and index buffers."""
        self._indirect(indirect)
        written = self._program(linked)
        for buffer in inputs:
            if isinstance(buffer, moderngl.Buffer):
                self._touch(("buffer", buffer.glo), True, False, "vertices")
        self._attachments(written)

    @contextlib.contextmanager
    def apart(self) -> Iterator[None]:
        """See Device.apart."""
        self._apart = {}
        try:
            yield
        finally:
            self._stored.update(self._apart)
            self._apart = None

    def copied(self, source: moderngl.Framebuffer | None, target: moderngl.Framebuffer) -> None:
        """See CommandWatch.copied."""
        how = "a clear" if source is None else "a copy"
        for texture in () if source is None else source.color_attachments:
            self._touch(("texture", texture.glo), True, False, how)
        self._touch(("framebuffer", target.glo), False, True, how)
        for texture in (*(target.color_attachments or ()), target.depth_attachment if source is None else None):
            if texture is not None:
                self._touch(("texture", texture.glo), False, True, how)

    def _program(self, linked: LinkedProgram) -> list[int]:
        """Touches of one program; the locations that its fragment stage writes."""
        written: list[int] = []
        stores: list[Identity] = []
        for stage, access in self._accesses(linked):
            variable = access.variable
            how = f"{variable.name!r} of {linked.files.get(stage, stage)}"
            if variable.kind == "output" and stage == "fragment" and variable.built_in is None:
                written.append(variable.location or 0)
            elif variable.kind in ("texture", "image"):
                for found in self._bound_images(linked, variable.name):
                    stores += self._touch(("texture", found), access.reads, access.writes, how)
            elif variable.kind in ("storage", "uniform") and variable.binding is not None:
                which = _STORAGE_BINDING if variable.kind == "storage" else _UNIFORM_BINDING
                found = self._at(which, variable.binding)
                stores += self._touch(("buffer", found), access.reads, access.writes, how)
        # After all of the command's touches: what it stores itself is its own affair.
        stored_by = " + ".join(linked.files.values())
        into = self._stored if self._apart is None else self._apart
        for each in stores:
            into[each] = (stored_by, self._pass)
        return written

    def _accesses(self, linked: LinkedProgram) -> tuple[tuple[str, Access], ...]:
        known = self._known.get(linked.key)
        if known is None:
            found = [(stage, access) for stage, module in linked.modules.items() for access in accesses(module)]
            known = self._known[linked.key] = tuple(found)
        return known

    def _bound_images(self, linked: LinkedProgram, name: str) -> list[int]:
        member: Any = linked.mgl.get(name, None)
        if member is None:
            return []  # the driver found that nothing comes of it
        kind = getattr(member, "gl_type", 0)
        units = [self._unit(linked.mgl.glo, member.location + k) for k in range(member.array_length)]
        if kind not in _TARGETS:
            return [self._at(_IMAGE_NAME, unit) for unit in units]
        active = self._gl.integer(_ACTIVE_TEXTURE)
        found = []
        for unit in units:
            self._activate(G.TEXTURE0 + unit)
            found.append(self._gl.integer(_TARGETS[kind]))
        self._activate(active)
        return found

    def _unit(self, program: int, location: int) -> int:
        self._uniform(program, location, c.byref(self._number))  # moderngl reads no image's
        return self._number.value

    def _attachments(self, written: list[int]) -> None:
        framebuffer = self._gl.integer(_DRAW_FRAMEBUFFER_BINDING)
        blends = self._gl.integer(G.BLEND) != 0
        colors = self._gl.integer(_COLOR_WRITES) != 0
        tests, keeps = self._gl.integer(G.DEPTH_TEST) != 0, self._gl.integer(_DEPTH_WRITES) != 0
        if written and colors:
            self._touch(("framebuffer", framebuffer), blends, True, "a draw")
        if framebuffer == 0:
            return
        for location in written if colors else ():
            place = self._gl.integer(_DRAW_BUFFER0 + location)
            if place:
                self._touch(("texture", self._attachment(place)), blends, True, f"colour {location} of a draw")
        if tests:
            self._touch(("texture", self._attachment(_DEPTH_ATTACHMENT)), True, keeps, "the depth test of a draw")

    def _attachment(self, place: int) -> int:
        self._attached(_DRAW_FRAMEBUFFER, place, _ATTACHED_NAME, c.byref(self._number))
        return self._number.value

    def _at(self, which: int, index: int) -> int:
        self._get_at(which, index, c.byref(self._number))
        return self._number.value

    def _indirect(self, buffer: moderngl.Buffer | None) -> None:
        if buffer is not None:
            self._touch(("buffer", buffer.glo), True, False, "indirect arguments")

    def _touch(self, object: Identity, reads: bool, writes: bool, how: str) -> list[Identity]:
        """The object, where it is written."""
        if not object[1] or not (reads or writes):
            return []
        if self._inside:
            stored = self._stored.get(object)
            # Two dispatches of a pass that only write may each have texels of their own.
            early = stored is not None and (reads or stored[1] != self._pass)
            self._touches.append(Touch(object, reads, writes, how, stored[0] if stored and early else ""))
        return [object] if writes else []

    def barrier(self, textures: bool = True, buffers: bool = True) -> None:
        """Stores to objects of these kinds are seen by what follows."""
        kept = {"texture": not textures, "buffer": not buffers}
        self._stored = {held: by for held, by in self._stored.items() if kept.get(held[0], False)}

    # -- of copies and of the processor ------------------------------------------------------------------------------

    def follow(self, obj: T) -> T:
        """The same texture, buffer or framebuffer, whose own methods that move data are heard, too."""
        if isinstance(obj, moderngl.Framebuffer):
            self._follow_clear(obj)
            return obj
        found = self.identity(obj)
        if found is not None:
            textures = found[0] == "texture"
            reads, writes = (_TEXTURE_READS, _TEXTURE_WRITES) if textures else (_BUFFER_READS, _BUFFER_WRITES)
            self._wrap(obj, found, reads, writes)
        return obj

    def _wrap(self, obj: Any, name: Identity, reads: tuple[str, ...], writes: tuple[str, ...]) -> None:
        for method in (*reads, *writes):
            own = getattr(obj, method, None)
            if own is None:
                continue

            def heard(*args: Any, _own: Any = own, _method: str = method, **more: Any) -> Any:
                self._touch(name, _method in reads, _method in writes, f"{_method}()")
                return _own(*args, **more)

            setattr(obj, method, heard)

    def _follow_clear(self, framebuffer: Any) -> None:
        own = framebuffer.clear
        attached = [*framebuffer.color_attachments, framebuffer.depth_attachment]

        def heard(*args: Any, **more: Any) -> Any:
            for texture in attached:
                if texture is not None:
                    self._touch(("texture", texture.glo), False, True, "clear()")
            return own(*args, **more)

        framebuffer.clear = heard

    def _follow_copies(self) -> None:
        ctx: Any = self._gpu.ctx
        copy_buffer, copy_framebuffer, copy_layers = ctx.copy_buffer, ctx.copy_framebuffer, self._gl.copy_layers

        def of_buffers(dst: Any, src: Any, *args: Any, **more: Any) -> Any:
            self._touch(("buffer", src.glo), True, False, "a copy")
            self._touch(("buffer", dst.glo), False, True, "a copy")
            return copy_buffer(dst, src, *args, **more)

        def of_framebuffers(dst: Any, src: Any) -> Any:
            for end, writes in ((src, False), (dst, True)):
                for texture in _attached_to(end):
                    self._touch(("texture", texture.glo), not writes, writes, "a copy")
                if writes and isinstance(end, moderngl.Framebuffer):
                    self._touch(("framebuffer", end.glo), False, True, "a copy")
            return copy_framebuffer(dst, src)

        def of_layers(target: int, source: int, begin: int, into: int, *args: Any) -> None:
            self._touch(("texture", source), True, False, "a copy of layers")
            self._touch(("texture", into), False, True, "a copy of layers")
            copy_layers(target, source, begin, into, *args)

        ctx.copy_buffer, ctx.copy_framebuffer = of_buffers, of_framebuffers
        self._gl.copy_layers = of_layers  # type: ignore[method-assign]


def _attached_to(end: Any) -> list[Any]:
    """The colour textures of a framebuffer, or the texture itself."""
    return list(end.color_attachments) if isinstance(end, moderngl.Framebuffer) else [end]
