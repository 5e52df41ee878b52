"""ReadbackRing: small results of compute shaders, read some frames later without waiting for the GPU."""

from __future__ import annotations

import ctypes as c
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

import moderngl

from . import gl as G

if TYPE_CHECKING:
    from . import GpuScope

__all__ = ["ReadbackRing"]

L = TypeVar("L")

_GPU_COMMANDS_COMPLETE = 0x9117
_ALREADY_SIGNALED, _CONDITION_SATISFIED = 0x911A, 0x911C
_FLUSH_COMMANDS_BIT = 0x1


@dataclass
class _Pending(Generic[L]):
    buffer: moderngl.Buffer
    label: L
    bytes: int
    fence: int
    queries: tuple[int, int]


class ReadbackRing(Generic[L]):
    """Up to `count` buffers of `size` bytes that compute shaders write and the CPU reads once they have been written.

    begin() gives a buffer (None while all are under way), end() puts a fence behind the work, poll() returns what has
    arrived. The time that the GPU took between begin and end comes with it.
    """

    def __init__(self, scope: GpuScope, size: int, count: int = 4) -> None:
        self._scope = scope
        gl = scope.gl
        self._fence = gl.function("glFenceSync", c.c_void_p, G.enum, G.bitfield)
        self._wait = gl.function("glClientWaitSync", G.enum, c.c_void_p, G.bitfield, c.c_uint64)
        self._forget = gl.function("glDeleteSync", None, c.c_void_p)
        self._stamp = gl.function("glQueryCounter", None, G.uint, G.enum)
        self._value = gl.function("glGetQueryObjectui64v", None, G.uint, G.enum, c.POINTER(c.c_uint64))
        self._names = (c.c_uint * (2 * count))()
        gl.function("glGenQueries", None, G.sizei, c.POINTER(c.c_uint))(2 * count, self._names)
        self._free = [
            (scope.buffer(reserve=size, dynamic=True), (self._names[2 * k], self._names[2 * k + 1]))
            for k in range(count)
        ]
        self._begun: tuple[moderngl.Buffer, tuple[int, int]] | None = None
        self._pending: deque[_Pending[L]] = deque()

    @property
    def pending(self) -> int:
        """Results that have not been read."""
        return len(self._pending)

    def begin(self) -> moderngl.Buffer | None:
        """A buffer to write into, or None."""
        if not self._free:
            return None
        self._begun = self._free.pop()
        self._stamp(self._begun[1][0], G.TIMESTAMP)
        return self._begun[0]

    def end(self, label: L, size: int) -> None:
        """The work is submitted; `size` bytes of the buffer are of interest, `label` comes back with them."""
        assert self._begun is not None, "begin comes first"
        buffer, queries = self._begun
        self._stamp(queries[1], G.TIMESTAMP)
        self._pending.append(_Pending(buffer, label, size, self._fence(_GPU_COMMANDS_COMPLETE, 0), queries))
        self._begun = None

    def poll(self, wait: bool = False) -> list[tuple[L, bytes, float]]:
        """(label, bytes, seconds on the GPU) of what has arrived, oldest first. wait: all, however long it takes."""
        found = []
        while self._pending:
            first = self._pending[0]
            state = self._wait(first.fence, _FLUSH_COMMANDS_BIT, 10**10 if wait else 0)
            if state not in (_ALREADY_SIGNALED, _CONDITION_SATISFIED):
                break
            self._pending.popleft()
            self._forget(first.fence)
            times = [c.c_uint64(), c.c_uint64()]
            for name, value in zip(first.queries, times, strict=True):
                self._value(name, G.QUERY_RESULT, c.byref(value))
            found.append((first.label, first.buffer.read(first.bytes), (times[1].value - times[0].value) * 1e-9))
            self._free.append((first.buffer, first.queries))
        return found

    def release(self) -> None:
        """Free fences and queries; the buffers are the scope's."""
        for pending in self._pending:
            self._forget(pending.fence)
        self._pending.clear()
        gl = self._scope.gpu.gl
        gl.function("glDeleteQueries", None, G.sizei, c.POINTER(c.c_uint))(len(self._names), self._names)
