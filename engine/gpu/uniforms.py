"""A uniform buffer that follows a dataclass."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import FormatError
from .layout import StructLayout, fill

if TYPE_CHECKING:
    from .device import Device

__all__ = ["UniformBlock"]


_CODES = {"vec4": "4f", "ivec4": "4i", "uvec4": "4I"}

Run = tuple[tuple[str, ...], struct.Struct]


def _runs(layout: StructLayout) -> tuple[Run | tuple[str, int], ...] | None:
    """A block of nothing but vectors of four as (names, packer) of those that follow one another and (name, count) of
    arrays of vec4; None for a block with other members."""
    found: list[Run | tuple[str, int]] = []
    names: list[str] = []
    codes = ""
    for member in (*layout.members, None):
        kind = None if member is None else member.type
        if names and (kind is None or kind.count):
            found.append((tuple(names), struct.Struct("=" + codes)))
            names, codes = [], ""
        if member is None or kind is None:
            break
        if kind.name not in _CODES or (kind.count and kind.name != "vec4"):
            return None
        if kind.count:
            found.append((member.name, kind.count))
        else:
            names.append(member.name)
            codes += _CODES[kind.name]
    return tuple(found)


class UniformBlock:
    """A std140 uniform buffer filled from instances of a dataclass.

    write() packs into one record made beforehand and uploads it only if it differs from what the buffer holds.
    """

    def __init__(self, gpu: Device, block: type[Any], binding: int) -> None:
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
        self._runs = _runs(self.layout)
        self._held = self._record.tobytes()
        self.buffer = gpu.ctx.buffer(self._record, dynamic=True)
        self.alive = True

    def write(self, instance: Any) -> bool:
        """Take over an instance's values; True if they had to be uploaded.

        FormatError names a field that does not fit.
        """
        data = self._packed(instance)
        if data == self._held:
            return False
        self._held = data
        self._gpu.upload(self.buffer, data)
        return True

    def _packed(self, instance: Any) -> bytes:
        """An instance's bytes."""
        quick = None if self._runs is None else _quickly(self._runs, instance)
        if quick is not None:
            return quick
        for name, view, length in self._views:
            value = getattr(instance, name)
            try:
                if length and len(value) != length:  # numpy would spread one number over a vector
                    raise ValueError
                view[...] = value
            except (TypeError, ValueError, OverflowError):
                fill(view, value, f"{self.layout.name}.{name}")
        return self._record.tobytes()

    def bind(self) -> None:
        """Bind to the block's binding point."""
        self.buffer.bind_to_uniform_block(self.binding)

    def release(self) -> None:
        if self.alive:
            self.alive = False
            self.buffer.release()


def _quickly(runs: tuple[Run | tuple[str, int], ...], instance: Any) -> bytes | None:
    """The bytes of an instance whose vectors are tuples and whose arrays are numpy's, as in the blocks of each frame;
    None for others, and for what does not fit: numpy takes more, and says what is wrong."""
    parts: list[bytes] = []
    for names, how in runs:
        if isinstance(how, int):
            value = getattr(instance, names)  # type: ignore[arg-type]
            if not isinstance(value, np.ndarray) or value.shape != (how, 4):
                return None
            parts.append(value.astype(np.float32).tobytes())
            continue
        numbers: list[Any] = []
        for name in names:
            value = getattr(instance, name)
            if value.__class__ is not tuple or len(value) != 4:
                return None
            numbers += value
        try:
            parts.append(how.pack(*numbers))
        except (struct.error, OverflowError):
            return None
    return parts[0] if len(parts) == 1 else b"".join(parts)
