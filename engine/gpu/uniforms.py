"""A uniform buffer that follows a dataclass."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import FormatError
from .layout import StructLayout, fill

if TYPE_CHECKING:
    from .context import Gpu

__all__ = ["UniformBlock"]


class UniformBlock:
    """A std140 uniform buffer filled from instances of a dataclass.

    write() packs into one record made beforehand and uploads it only if it differs from what the buffer holds.
    """

    def __init__(self, gpu: Gpu, block: type[Any], binding: int) -> None:
        self._gpu = gpu
        self.binding = binding
        self.layout = StructLayout(block)
        if self.layout.size > gpu.caps.max_uniform_block_bytes:
            raise FormatError(
                f"uniform block {self.layout.name} has {self.layout.size} bytes, beyond this GPU's limit of "
                f"{gpu.caps.max_uniform_block_bytes}; use a storage buffer"
            )
        self._record = self.layout.record()
        views = self.layout.views(self._record)
        self._views = tuple((name, view, 0 if view.shape == (1,) else len(view)) for name, view in views.items())
        self._words = self._record.view(np.uint32)
        self._held = self._words.copy()
        self._differs = np.empty(self._words.shape, bool)
        self.buffer = gpu.ctx.buffer(self._record, dynamic=True)
        self.alive = True

    def write(self, instance: Any) -> bool:
        """Take over an instance's values; True if they had to be uploaded.

        FormatError names a field that does not fit.
        """
        for name, view, length in self._views:
            value = getattr(instance, name)
            try:
                if length and len(value) != length:  # numpy would spread one number over a vector
                    raise ValueError
                view[...] = value
            except (TypeError, ValueError, OverflowError):
                fill(view, value, f"{self.layout.name}.{name}")
        np.not_equal(self._words, self._held, out=self._differs)
        if not self._differs.any():
            return False
        np.copyto(self._held, self._words)
        self._gpu.upload(self.buffer, self._held)
        return True

    def bind(self) -> None:
        """Bind to the block's binding point."""
        self.buffer.bind_to_uniform_block(self.binding)

    def release(self) -> None:
        if self.alive:
            self.alive = False
            self.buffer.release()
