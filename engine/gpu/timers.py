"""GPU times of passes without waiting: timestamps in a ring, read frames later."""

from __future__ import annotations

import ctypes as c
from typing import TYPE_CHECKING

from . import gl as G

if TYPE_CHECKING:
    from .device import Device

__all__ = ["GpuTimers"]

DELAY = 3
RING = 8


class GpuTimers:
    """Start and end timestamps for `count` slots a frame, in a ring of frames; nothing here blocks.

    Results are read at least DELAY frames late. A driver that lags more than the ring is long loses the oldest frame.
    On software renderers the times mean little, and each timestamp flushes.
    """

    def __init__(self, gpu: Device, count: int) -> None:
        self.count = count
        self.alive = True
        gl = gpu.gl
        self._stamp = gl.function("glQueryCounter", None, G.uint, G.enum)
        self._poll = gl.function("glGetQueryObjectuiv", None, G.uint, G.enum, c.POINTER(c.c_uint))
        self._read = gl.function("glGetQueryObjectui64v", None, G.uint, G.enum, c.POINTER(c.c_uint64))
        self._delete = gl.function("glDeleteQueries", None, G.sizei, c.POINTER(c.c_uint))
        self._names = (c.c_uint * (2 * count * RING))()
        gl.function("glGenQueries", None, G.sizei, c.POINTER(c.c_uint))(len(self._names), self._names)
        self._began = [[False] * count for _ in range(RING)]
        self._ended = [[False] * count for _ in range(RING)]
        self._last = [0] * RING  # the name of the last timestamp of a frame
        self._frame = 0
        self._oldest = 0  # the first frame not read yet
        self._flag, self._value = c.c_uint(), c.c_uint64()

    def _name(self, frame: int, slot: int, end: int) -> int:
        return self._names[2 * (frame % RING * self.count + slot) + end]

    def begin(self, slot: int) -> None:
        name = self._name(self._frame, slot, 0)
        self._began[self._frame % RING][slot] = True
        self._stamp(name, G.TIMESTAMP)
        self._last[self._frame % RING] = name

    def end(self, slot: int) -> None:
        name = self._name(self._frame, slot, 1)
        self._ended[self._frame % RING][slot] = True
        self._stamp(name, G.TIMESTAMP)
        self._last[self._frame % RING] = name

    def collect(self, out: list[float | None]) -> None:
        """Move on by a frame; write the milliseconds of the oldest finished frame into `out`, if there is one."""
        self._frame += 1
        if self._frame - self._oldest > DELAY and self._finished(self._oldest % RING):
            self._write(out)
            self._forget()
        if self._frame - self._oldest >= RING:
            self._forget()  # its names are needed again

    def _finished(self, row: int) -> bool:
        last = self._last[row]
        if not last:
            return True
        self._poll(last, G.QUERY_RESULT_AVAILABLE, c.byref(self._flag))
        return bool(self._flag.value)

    def _write(self, out: list[float | None]) -> None:
        row = self._oldest % RING
        for slot in range(self.count):
            if self._began[row][slot] and self._ended[row][slot]:
                self._read(self._name(self._oldest, slot, 0), G.QUERY_RESULT, c.byref(self._value))
                start = self._value.value
                self._read(self._name(self._oldest, slot, 1), G.QUERY_RESULT, c.byref(self._value))
                out[slot] = (self._value.value - start) * 1e-6
            else:
                out[slot] = None

    def _forget(self) -> None:
        row = self._oldest % RING
        for flags in (self._began[row], self._ended[row]):
            for slot in range(self.count):
                flags[slot] = False
        self._last[row] = 0
        self._oldest += 1

    def release(self) -> None:
        if self.alive:
            self.alive = False
            self._delete(len(self._names), self._names)
