"""Guard of a host's GL state: everything a compiled plan may touch is as it was when the guard is left.

Reading OpenGL state costs about 0.25 us a value from Python, so calls are prepared once (arguments as ctypes objects,
one array for all results) and only what differs is set again. moderngl keeps its own idea of some state beside GL (the
bound framebuffer, enable flags, cull face, ...): a host that uses the same context object gets that back as well.

Not covered, because no pass touches it: transform feedback, queries, program pipelines, debug output, hints, the state
inside the host's own objects (except the draw and read buffers of its bound framebuffers).
"""

from __future__ import annotations

import ctypes as c
import logging
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from itertools import starmap
from types import TracebackType
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np

from ..blocks.bindings import POINTS
from . import gl as G
from .guard_tables import (
    ATTRIBUTES_OF_CONTEXT,
    ATTRIBUTES_OF_FRAMEBUFFER,
    BLEND_PER_BUFFER,
    ERROR_NAMES,
    Calls,
    Item,
    build_items,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .context import Gpu

__all__ = ["StateGuard"]

log = logging.getLogger(__name__)

_TARGETS = ((0x0DE1, 0x8069), (0x806F, 0x806A), (0x8513, 0x8514), (0x8C1A, 0x8C1D))  # 2D, 3D, cube, 2D array
_SAMPLER_BINDING = 0x8919
_ENABLE_FLAGS = (  # moderngl's flag, GL capability
    (moderngl.BLEND, 0x0BE2),
    (moderngl.DEPTH_TEST, 0x0B71),
    (moderngl.CULL_FACE, 0x0B44),
    (moderngl.RASTERIZER_DISCARD, 0x8C89),
    (moderngl.PROGRAM_POINT_SIZE, 0x8642),
)
_UBO, _UBO_BINDING = 0x8A11, 0x8A28  # start and size of a range are the next two names
_SSBO, _SSBO_BINDING = 0x90D2, 0x90D3
_IMAGE_NAME, _IMAGE_LEVEL, _IMAGE_LAYERED, _IMAGE_LAYER, _IMAGE_ACCESS, _IMAGE_FORMAT = (
    0x8F3A, 0x8F3B, 0x8F3C, 0x8F3D, 0x8F3E, 0x906E,
)  # fmt: skip
_MAX_ERRORS = 64


class _Saved:
    """What one `with` found on entry."""

    __slots__ = ("attributes", "buffers", "fbo", "fbo_mglo", "framebuffers", "images", "names", "values", "words")

    def __init__(self) -> None:
        self.values: NDArray[np.int32]
        self.words: list[int]  # the same
        self.names: NDArray[np.int32]
        self.buffers: list[tuple[int, int, int, int, int]]  # target, index, buffer, start, size
        self.images: list[tuple[int, ...]]
        self.fbo: moderngl.Framebuffer | None
        self.fbo_mglo: Any
        self.attributes: list[Any]
        self.framebuffers: list[tuple[Any, bool, list[Any]]]  # moderngl's inner object, scissor is off, attributes


class StateGuard:
    """Saves the host's state on entering a `with` and restores it on leaving; may be entered again inside itself.

    Inside, the pixel transfer settings are GL's defaults; all else is still the host's until somebody changes it.

    Args:
        gpu: the Gpu of the context.
        texture_units: texture units 0..n-1 (and moderngl's default unit) with their samplers: how many a plan uses.
        ubo_bindings, ssbo_bindings: indexed buffer bindings 0..n-1 (buffer, offset and size).
        image_units: image units 0..n-1.
        framebuffers: moderngl framebuffers of the host that we draw into; their viewport, scissor and masks are kept
            too. The framebuffer bound on entry always is among them. May be set anew before each `with`.

    On leaving, GL errors are drained: `errors_before` and `errors` name those found on entry and those of our own work;
    both are logged. Hosts such as pyglet raise on any error left behind.

    Cost: 0.16 ms for one entry and exit (llvmpipe, 20 texture units, 16 uniform blocks, 8 of everything else).
    """

    def __init__(
        self,
        gpu: Gpu,
        texture_units: int = POINTS["texture unit"],
        ubo_bindings: int = POINTS["uniform block"],
        ssbo_bindings: int = POINTS["storage buffer"],
        image_units: int = POINTS["image"],
        framebuffers: Sequence[moderngl.Framebuffer] = (),
    ) -> None:
        self.ctx = gpu.ctx
        self.framebuffers: Sequence[moderngl.Framebuffer] = framebuffers
        self.errors_before: tuple[str, ...] = ()
        self.errors: tuple[str, ...] = ()
        self._stack: list[_Saved] = []
        self._calls = calls = Calls(gpu.gl)
        limit = gpu.gl.integer
        texture_units = min(texture_units, limit(G.MAX_COMBINED_TEXTURE_IMAGE_UNITS))
        self.ubos = min(ubo_bindings, limit(0x8A2F))
        self.ssbos = min(ssbo_bindings, limit(0x90DD))
        self.images = min(image_units, limit(0x8F38))
        self._draw_buffers = limit(0x8824)
        self.multi_bind = gpu.ctx.version_code >= 440 or "GL_ARB_multi_bind" in gpu.ctx.extensions

        # Values that are read one by one: read on entry, read again on exit, set where they differ.
        self._items: list[Item] = build_items(calls, self._draw_buffers, gpu.caps.has_clip_control)
        words = sum(item.words for item in self._items)
        self._values = np.zeros(words, np.int32)
        self._item_of_word = np.zeros(words, np.int32)
        self._reads: list[tuple[Callable[..., Any], list[tuple[Any, ...]]]] = []
        offset = 0
        base = self._values.ctypes.data
        for index, item in enumerate(self._items):
            item.offset = offset
            self._item_of_word[offset : offset + item.words] = index
            for function, name, position in item.reads:
                if not self._reads or self._reads[-1][0] is not function:
                    self._reads.append((function, []))
                address = c.c_void_p(base + 4 * (offset + position))
                self._reads[-1][1].append((*map(c.c_uint, name), address))
            offset += item.words
        word_of = {item.reads[0][1][0]: item.offset for item in self._items if item.words == 1}
        self._flag_words = [(flag, word_of.get(capability)) for flag, capability in _ENABLE_FLAGS]

        self._scissor_word = word_of[G.SCISSOR_TEST]
        self._first = [item for item in self._items if item.first]
        self._always = [item for item in self._items if item.always]
        neutral = [index for index, item in enumerate(self._items) if item.neutral is not None]
        self._neutral_items = np.array(neutral)
        self._neutral_words = np.array([self._items[index].offset for index in neutral])
        self._neutral_values = np.array([self._items[index].neutral for index in neutral], np.int32)

        # Names of bound objects: per unit the textures and the sampler, then blend, then the indexed bindings.
        default_unit = int(gpu.ctx.default_texture_unit)
        self.units = list(range(texture_units)) + ([default_unit] if default_unit >= texture_units else [])
        per_unit = len(_TARGETS) + 1
        blend_words = self._draw_buffers * len(BLEND_PER_BUFFER) + 4 * self._draw_buffers
        self._blend_at = len(self.units) * per_unit
        self._masks_at = self._blend_at + self._draw_buffers * len(BLEND_PER_BUFFER)
        self._ubo_at = self._blend_at + blend_words
        self._ssbo_at = self._ubo_at + self.ubos
        self._image_at = self._ssbo_at + self.ssbos
        self._names = np.zeros(self._image_at + self.images, np.int32)
        base = self._names.ctypes.data
        # From OpenGL 4.5 on a unit's bindings are read by its number, without making it the active one.
        self._direct = gpu.ctx.version_code >= 450
        self._direct_reads: tuple[list[tuple[Any, ...]], list[tuple[Any, ...]]] = ([], [])
        self._unit_reads: list[tuple[c.c_uint, list[tuple[Any, Any]], list[tuple[Any, Any]]]] = []
        for row, unit in enumerate(self.units):
            reads = [
                (c.c_uint(name), c.c_void_p(base + 4 * (row * per_unit + k)))
                for k, name in enumerate([*(binding for _target, binding in _TARGETS), _SAMPLER_BINDING])
            ]
            self._unit_reads.append((c.c_uint(G.TEXTURE0 + unit), reads, reads[:-1]))
            direct = [(name, c.c_uint(unit), address) for name, address in reads]
            self._direct_reads[1].extend(direct)
            self._direct_reads[0].extend(direct[:-1])
        self._indexed_reads: list[tuple[Any, Any, Any]] = []

        def indexed(name: int, index: int, word: int) -> None:
            self._indexed_reads.append((c.c_uint(name), c.c_uint(index), c.c_void_p(base + 4 * word)))

        for i in range(self._draw_buffers):
            for k, name in enumerate(BLEND_PER_BUFFER):
                indexed(name, i, self._blend_at + i * len(BLEND_PER_BUFFER) + k)
            indexed(0x0C23, i, self._masks_at + 4 * i)
        # Where the ranges of buffers begin and how long they are, for those that are bound.
        self._ranges: dict[int, Any] = {}
        self._range_reads: dict[int, list[tuple[tuple[Any, ...], tuple[Any, ...]]]] = {}
        for name, count in ((_UBO_BINDING, self.ubos), (_SSBO_BINDING, self.ssbos)):
            found = self._ranges[name] = (c.c_int64 * (2 * max(count, 1)))()
            at = c.addressof(found)
            self._range_reads[name] = [
                (
                    (c.c_uint(name + 1), c.c_uint(i), c.c_void_p(at + 16 * i)),
                    (c.c_uint(name + 2), c.c_uint(i), c.c_void_p(at + 16 * i + 8)),
                )
                for i in range(count)
            ]
        for name, count, at in (
            (_UBO_BINDING, self.ubos, self._ubo_at),
            (_SSBO_BINDING, self.ssbos, self._ssbo_at),
            (_IMAGE_NAME, self.images, self._image_at),
        ):
            for i in range(count):
                indexed(name, i, at + i)

    # -- reading -----------------------------------------------------------------------------------------------------
    def _read_values(self) -> None:
        for function, arguments in self._reads:
            deque(starmap(function, arguments), 0)

    def _read_units(self, samplers: bool) -> None:
        if self._direct:
            deque(starmap(self._calls.get_indexed, self._direct_reads[samplers]), 0)
            return
        activate, get = self._calls.active_texture, self._calls.get
        for unit, everything, textures in self._unit_reads:
            activate(unit)
            deque(starmap(get, everything if samplers else textures), 0)

    def _read_ranges(self, saved: _Saved) -> None:
        calls = self._calls
        for target, binding, at, count in (
            (_UBO, _UBO_BINDING, self._ubo_at, self.ubos),
            (_SSBO, _SSBO_BINDING, self._ssbo_at, self.ssbos),
        ):
            for i in np.flatnonzero(saved.names[at : at + count]).tolist():
                start, size = self._range_reads[binding][i]
                calls.get_indexed_long(*start)
                calls.get_indexed_long(*size)
                found = self._ranges[binding]
                saved.buffers.append((target, i, int(saved.names[at + i]), found[2 * i], found[2 * i + 1]))
        for i in np.flatnonzero(saved.names[self._image_at :]).tolist():
            properties = [
                calls.indexed_integer(name, i)
                for name in (_IMAGE_LEVEL, _IMAGE_LAYERED, _IMAGE_LAYER, _IMAGE_ACCESS, _IMAGE_FORMAT)
            ]
            saved.images.append((i, int(saved.names[self._image_at + i]), *properties))

    def drain(self) -> tuple[str, ...]:
        """Take all pending errors off GL's list and name them."""
        found: list[str] = []
        error = self._calls.error()
        while error and len(found) < _MAX_ERRORS:  # a lost context reports for ever
            found.append(ERROR_NAMES.get(error, hex(error)))
            error = self._calls.error()
        return tuple(found)

    # -- with --------------------------------------------------------------------------------------------------------
    def __enter__(self) -> StateGuard:
        self.errors_before = self.drain()
        if self.errors_before:
            log.warning("OpenGL errors left by the host before our frame: %s", ", ".join(self.errors_before))
        saved = _Saved()
        saved.buffers, saved.images = [], []
        self._read_values()
        saved.values, saved.words = self._values.copy(), self._values.tolist()
        self._save_moderngl(saved)
        self._read_units(samplers=True)
        self._calls.active_texture(self._active_unit(saved))
        deque(starmap(self._calls.get_indexed, self._indexed_reads), 0)
        saved.names = self._names.copy()
        self._read_ranges(saved)
        self._stack.append(saved)
        self._neutralise(saved)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        ours = self.drain()
        saved = self._stack.pop()
        self._restore_moderngl(saved)
        for item in self._first:  # what other values belong to: the framebuffers and the vertex array
            item.restore(saved.values[item.offset : item.offset + item.words])
        self._read_values()
        # Textures before the single values: those end with the active unit and the general buffer bindings.
        self._restore_units(saved)
        self._restore_blend(saved)
        self._restore_indexed(saved)
        # In the order of the items; one of several words is set once.
        for index in dict.fromkeys(self._item_of_word[saved.values != self._values].tolist()):
            item = self._items[index]
            item.restore(saved.values[item.offset : item.offset + item.words])
        for item in self._always:
            item.restore(saved.values[item.offset : item.offset + item.words])
        self.errors = (*ours, *self.drain())
        if self.errors:
            log.error("OpenGL errors of our own frame, now cleared: %s", ", ".join(self.errors))

    def _neutralise(self, saved: _Saved) -> None:
        """Put the host's pixel transfer settings aside: uploads and read-backs of ours must not go through them."""
        for index in self._neutral_items[saved.values[self._neutral_words] != self._neutral_values].tolist():
            item = self._items[index]
            item.restore([item.neutral])

    # -- restoring ---------------------------------------------------------------------------------------------------
    def _active_unit(self, saved: _Saved) -> int:
        return int(saved.values[self._items[-1].offset])

    def _restore_units(self, saved: _Saved) -> None:
        self._read_units(samplers=False)
        per_unit = len(_TARGETS) + 1
        end = self._blend_at
        wanted = saved.names[:end].reshape(-1, per_unit)
        found = self._names[:end].reshape(-1, per_unit)
        calls = self._calls
        different = (wanted[:, :-1] != found[:, :-1]).nonzero()
        for row, column in zip(different[0].tolist(), different[1].tolist(), strict=True):
            calls.active_texture(G.TEXTURE0 + self.units[row])
            calls.bind_texture(_TARGETS[column][0], int(wanted[row, column]) & 0xFFFFFFFF)
        if self.multi_bind:
            count = len(self.units) - 1
            samplers = np.ascontiguousarray(wanted[:count, -1])
            calls.bind_samplers(0, count, samplers.ctypes.data)
            calls.bind_sampler(self.units[-1], int(wanted[-1, -1]))
        else:
            for row, unit in enumerate(self.units):
                calls.bind_sampler(unit, int(wanted[row, -1]))

    def _restore_blend(self, saved: _Saved) -> None:
        calls, n, width = self._calls, self._draw_buffers, len(BLEND_PER_BUFFER)
        words = saved.names[self._blend_at : self._masks_at + 4 * n].tolist()
        blend, masks = words[: n * width], words[n * width :]
        if blend == blend[:width] * n:
            calls.blend(blend[0], blend[1:width])
        else:
            for i in range(n):
                enabled, *functions = blend[i * width : (i + 1) * width]
                calls.blend_indexed(i, enabled, functions)
        if masks == masks[:4] * n:
            calls.color_mask(*masks[:4])
        else:
            for i in range(n):
                calls.color_mask_indexed(i, *masks[4 * i : 4 * i + 4])

    def _restore_indexed(self, saved: _Saved) -> None:
        calls = self._calls
        for target, at, count in ((_UBO, self._ubo_at, self.ubos), (_SSBO, self._ssbo_at, self.ssbos)):
            if self.multi_bind:
                calls.bind_buffers_base(target, 0, count, None)
            else:
                for i in np.flatnonzero(saved.names[at : at + count] == 0).tolist():
                    calls.bind_buffer_base(target, i, 0)
        for target, i, buffer, start, size in saved.buffers:
            if size:
                calls.bind_buffer_range(target, i, buffer, start, size)
            else:  # bound whole: grows with the buffer
                calls.bind_buffer_base(target, i, buffer)
        if self.multi_bind:
            calls.bind_image_textures(0, self.images, None)
        else:
            for i in range(self.images):
                calls.bind_image_texture(i, 0, 0, 0, 0, 0x88B8, 0x8229)
        for image in saved.images:
            calls.bind_image_texture(*image)

    # -- moderngl's own idea -----------------------------------------------------------------------------------------
    def _save_moderngl(self, saved: _Saved) -> None:
        mglo = self.ctx.mglo
        context: Any = self.ctx
        if context.fbo is not None and isinstance(context.fbo.mglo, moderngl.InvalidObject):
            # The host has released the framebuffer that was bound. GL has gone back to the window's, moderngl has not,
            # and would bind the dead name each time it tidies up.
            context.fbo = context.screen or context.detect_framebuffer(0)
            mglo.fbo = context.fbo.mglo
        saved.fbo = self.ctx.fbo
        saved.fbo_mglo = mglo.fbo
        saved.attributes = [getattr(mglo, name) for name in ATTRIBUTES_OF_CONTEXT]
        # moderngl does not tell whether a framebuffer's scissor is on: GL does for the bound one, the size for others
        bound = mglo.fbo
        saved.framebuffers = [(bound, not saved.values[self._scissor_word], _attributes(bound))]
        for framebuffer in self.framebuffers:
            if framebuffer.mglo is not bound:
                unscissored = framebuffer.scissor == (0, 0, *framebuffer.size)
                saved.framebuffers.append((framebuffer.mglo, unscissored, _attributes(framebuffer.mglo)))

    def _restore_moderngl(self, saved: _Saved) -> None:
        mglo = self.ctx.mglo
        flags = 0
        for flag, word in self._flag_words:
            enabled = saved.names[self._blend_at] if word is None else saved.words[word]
            if enabled:
                flags |= flag
        mglo.enable_only(flags)
        _assign_changed(mglo, ATTRIBUTES_OF_CONTEXT, saved.attributes)
        for framebuffer, unscissored, attributes in saved.framebuffers:
            now = _attributes(framebuffer)
            for name, old, new in zip(ATTRIBUTES_OF_FRAMEBUFFER, attributes, now, strict=True):
                if old != new:
                    setattr(framebuffer, name, None if name == "scissor" and unscissored else old)
        mglo.fbo = saved.fbo_mglo
        context: Any = self.ctx  # its type says that it always has a framebuffer; a headless one starts without
        context.fbo = saved.fbo


def _attributes(framebuffer: Any) -> list[Any]:
    return [getattr(framebuffer, name) for name in ATTRIBUTES_OF_FRAMEBUFFER]


def _assign_changed(owner: Any, names: Iterable[str], values: Iterable[Any]) -> None:
    for name, value in zip(names, values, strict=True):
        if getattr(owner, name) != value:
            setattr(owner, name, value)
