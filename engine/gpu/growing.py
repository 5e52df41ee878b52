"""A storage buffer that grows with what is written into it."""

from __future__ import annotations

from typing import Any

import moderngl
from numpy.typing import NDArray

from .scope import GpuScope

__all__ = ["GrowingBuffer"]


class GrowingBuffer:
    """Rows of one type, of which there are more or fewer in each frame. `buffer` changes when it has to grow."""

    def __init__(self, gpu: GpuScope, row_bytes: int, rows: int = 64) -> None:
        self._gpu = gpu
        self.buffer: moderngl.Buffer = gpu.buffer(reserve=rows * row_bytes, dynamic=True)

    def write(self, rows: NDArray[Any]) -> None:
        """All rows anew; room for twice as many when they do not fit."""
        if rows.nbytes > self.buffer.size:
            self._gpu.free(self.buffer)
            self.buffer = self._gpu.buffer(reserve=2 * rows.nbytes, dynamic=True)
        if rows.nbytes:
            self.buffer.write(rows.tobytes())
