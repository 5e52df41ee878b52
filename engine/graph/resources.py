"""What a pass can create or borrow: textures, buffers, imports. Plain data, no GL."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from .errors import GraphError, did_you_mean

Lifetime = Literal["transient", "persistent", "history"]
ImportKind = Literal["framebuffer", "texture", "buffer"]

BYTES_PER_TEXEL: dict[str, int] = {
    "r8": 1, "rg8": 2, "rgba8": 4,
    "r16f": 2, "rg16f": 4, "rgba16f": 8,
    "r32f": 4, "rg32f": 8, "rgba32f": 16,
    "r8ui": 1, "r16ui": 2, "r32ui": 4, "rg32ui": 8, "rgba32ui": 16,
    "rg16_snorm": 4, "rgba16_snorm": 8,
    "depth32f": 4,
}  # fmt: skip
"""Every texture format of the graph with its size in bytes."""

_LIFETIMES = ("transient", "persistent", "history")
_IMPORT_KINDS = ("framebuffer", "texture", "buffer")


def _check_name(what: str, name: object) -> None:
    if not isinstance(name, str) or not name.strip() or name != name.strip():
        raise GraphError(f"{what}: the name must be a non-empty string without outer blanks, found {name!r}.")


def _check_choice(where: str, field: str, value: object, choices: tuple[str, ...]) -> None:
    if value not in choices:
        hint = did_you_mean(str(value), choices, listing=False)
        raise GraphError(f"{where}: {field}={value!r} is not one of {', '.join(map(repr, choices))}.{hint}")


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 1


class TextureKind(NamedTuple):
    """What textures have to have in common to stand in for one another. size: as in TextureSpec."""

    format: str
    size: float | tuple[int, ...]
    levels: int
    layers: int
    filter: str
    wrap: str


class BufferKind(NamedTuple):
    """The same of buffers."""

    size_bytes: int


Kind = TextureKind | BufferKind


@dataclass(frozen=True, slots=True)
class TextureSpec:
    """A texture that a pass creates.

    size: a number is relative to the view (1.0 = full, 0.5 = half, rounded up); (w, h) or (w, h, d) are texels.
    lifetime: "transient" lives from its creator to its last use and shares memory with others of the same kind;
    "persistent" keeps its content between frames; "history" is two textures that swap every frame.
    layers > 1 makes a texture array; three numbers in size make a 3D texture.
    """

    name: str
    format: str
    size: float | tuple[int, ...] = 1.0
    lifetime: Lifetime = "transient"
    levels: int = 1
    layers: int = 1
    filter: Literal["nearest", "linear"] = "nearest"
    wrap: Literal["clamp", "repeat"] = "clamp"
    help: str = ""

    def __post_init__(self) -> None:
        _check_name("TextureSpec", self.name)
        where = f"texture {self.name!r}"
        if self.format not in BYTES_PER_TEXEL:
            raise GraphError(f"{where}: unknown format {self.format!r}.{did_you_mean(self.format, BYTES_PER_TEXEL)}")
        _check_choice(where, "lifetime", self.lifetime, _LIFETIMES)
        _check_choice(where, "filter", self.filter, ("nearest", "linear"))
        _check_choice(where, "wrap", self.wrap, ("clamp", "repeat"))
        size: object = self.size
        if isinstance(size, tuple):
            if len(size) not in {2, 3} or not all(_is_count(n) for n in size):
                raise GraphError(f"{where}: size={size!r}; give (w, h) or (w, h, d) in whole texels >= 1.")
        elif isinstance(size, bool) or not isinstance(size, (int, float)) or not (math.isfinite(size) and size > 0):
            raise GraphError(
                f"{where}: size={size!r}; give a number > 0 (relative to the view) or a tuple of whole texels."
            )
        if not _is_count(self.levels) or not _is_count(self.layers):
            raise GraphError(f"{where}: levels={self.levels!r}, layers={self.layers!r}; both are whole numbers >= 1.")
        if isinstance(size, tuple) and len(size) == 3 and self.layers != 1:
            raise GraphError(f"{where}: a 3D texture has no layers, found layers={self.layers}; use layers=1.")

    @property
    def relative(self) -> bool:
        """True when the size follows the view, so that a resize makes the texture anew."""
        return not isinstance(self.size, tuple)

    def resolve(self, view_size: tuple[int, int]) -> tuple[int, ...]:
        """Texels (w, h) or (w, h, d) for a view of view_size pixels."""
        if isinstance(self.size, tuple):
            return self.size
        scale = float(self.size)
        # Rounded up: a half-resolution texture of an odd view still covers the last row. The 1e-9 keeps 1/3 of 9 at 3.
        return tuple(max(1, math.ceil(n * scale - 1e-9)) for n in view_size)

    def levels_for(self, size: tuple[int, ...]) -> int:
        """The number of mip levels that a texture of this size can really have (<= levels)."""
        return min(self.levels, max(size).bit_length())

    def bytes_for(self, size: tuple[int, ...]) -> int:
        """Bytes of texel data with all levels and layers; drivers may pad."""
        total = 0
        for level in range(self.levels_for(size)):
            total += math.prod(max(1, n >> level) for n in size)
        return total * BYTES_PER_TEXEL[self.format] * self.layers

    def pool_key(self) -> TextureKind:
        """Two transients with equal keys can share one texture (also after any resize)."""
        size = self.size if isinstance(self.size, tuple) else float(self.size)
        return TextureKind(self.format, size, self.levels, self.layers, self.filter, self.wrap)


@dataclass(frozen=True, slots=True)
class BufferSpec:
    """A buffer of size_bytes that a pass creates; lifetimes as in TextureSpec."""

    name: str
    size_bytes: int
    lifetime: Lifetime = "transient"
    help: str = ""

    def __post_init__(self) -> None:
        _check_name("BufferSpec", self.name)
        _check_choice(f"buffer {self.name!r}", "lifetime", self.lifetime, _LIFETIMES)
        if not _is_count(self.size_bytes):
            raise GraphError(f"buffer {self.name!r}: size_bytes={self.size_bytes!r}; give a whole number >= 1.")

    @property
    def relative(self) -> bool:
        """Always False: buffers do not follow the view."""
        return False

    def resolve(self, view_size: tuple[int, int]) -> tuple[int, ...]:
        """(size_bytes,), whatever the view."""
        return (self.size_bytes,)

    def bytes_for(self, size: tuple[int, ...]) -> int:
        """size_bytes."""
        return size[0]

    def pool_key(self) -> BufferKind:
        """Two transients with equal keys can share one buffer."""
        return BufferKind(self.size_bytes)


@dataclass(frozen=True, slots=True)
class ImportSpec:
    """Something that the graph does not own: lent by a system as `lent`, or by the host, late, with `bind_import`."""

    name: str
    kind: ImportKind
    help: str = ""
    lent: object = None

    def __post_init__(self) -> None:
        _check_name("ImportSpec", self.name)
        _check_choice(f"import {self.name!r}", "kind", self.kind, _IMPORT_KINDS)


CreatedSpec = TextureSpec | BufferSpec
"""What stands in `creates=` of a pass."""
