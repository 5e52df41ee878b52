"""A uniform buffer that follows a dataclass."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..blocks.layout import StructLayout
from .errors import FormatError

if TYPE_CHECKING:
    from .device import Device

__all__ = ["UniformBlock"]


class UniformBlock:
    """A std140 uniform buffer filled from instances of a dataclass; write() uploads only what differs from it."""

    def __init__(self, gpu: Device, block: type, binding: int) -> None:
        self._gpu = gpu
        self.binding = binding
        self.layout = StructLayout(block)
        if self.layout.size > gpu.caps.max_uniform_block_bytes:
            raise FormatError(
                f"uniform block {self.layout.name} has {self.layout.size} bytes, beyond this GPU's limit of "
                f"{gpu.caps.max_uniform_block_bytes}; use a storage buffer"
            )
        self._held = bytes(self.layout.size)
        self.buffer = gpu.ctx.buffer(self._held, dynamic=True)
        self.alive = True

    def write(self, value: object) -> bool:
        """Take over an instance's values, or what StructLayout.pack takes for one; True if they had to be uploaded.

        FormatError names a field that is missing, unknown or does not fit.
        """
        data = self.layout.pack(value)
        if data == self._held:
            return False
        self._held = data
        self._gpu.upload(self.buffer, data)
        return True

    def bind(self) -> None:
        """Bind to the block's binding point."""
        self.buffer.bind_to_uniform_block(self.binding)

    def release(self) -> None:
        if self.alive:
            self.alive = False
            self.buffer.release()
