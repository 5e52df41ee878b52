"""Uniform and storage blocks from dataclasses: one declaration gives the numpy record and the GLSL text.

The layout rules are those of OpenGL 4.3, 7.6.2.2: std140, or std430 for storage blocks.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, get_type_hints

import numpy as np
from numpy.typing import NDArray

from .errors import FormatError

__all__ = [
    "GlslType",
    "IVec2",
    "IVec4",
    "Mat4",
    "StructLayout",
    "UInt",
    "UVec2",
    "UVec4",
    "Vec2",
    "Vec3",
    "Vec4",
    "array",
]


@dataclass(frozen=True)
class GlslType:
    """A type of a block's member: alignment in bytes; columns > 1 for a matrix; count > 0 for an array."""

    name: str
    base: str
    components: int
    alignment: int
    columns: int = 1
    count: int = 0

    @property
    def bytes(self) -> int:
        return 4 * self.components * self.columns

    def stride(self, layout: str) -> int:
        """Bytes from one array element to the next."""
        size = -(-self.bytes // self.alignment) * self.alignment
        return -(-size // 16) * 16 if layout == "std140" else size


_FLOAT = GlslType("float", "f4", 1, 4)
_INT = GlslType("int", "i4", 1, 4)
_UINT = GlslType("uint", "u4", 1, 4)
_BOOL = GlslType("bool", "u4", 1, 4)

Floats: TypeAlias = Sequence[float] | NDArray[np.floating[Any]]
Ints: TypeAlias = Sequence[int] | NDArray[np.integer[Any]]

UInt: TypeAlias = Annotated[int, _UINT]
Vec2: TypeAlias = Annotated[Floats, GlslType("vec2", "f4", 2, 8)]
Vec3: TypeAlias = Annotated[Floats, GlslType("vec3", "f4", 3, 16)]
Vec4: TypeAlias = Annotated[Floats, GlslType("vec4", "f4", 4, 16)]
IVec2: TypeAlias = Annotated[Ints, GlslType("ivec2", "i4", 2, 8)]
IVec4: TypeAlias = Annotated[Ints, GlslType("ivec4", "i4", 4, 16)]
UVec2: TypeAlias = Annotated[Ints, GlslType("uvec2", "u4", 2, 8)]
UVec4: TypeAlias = Annotated[Ints, GlslType("uvec4", "u4", 4, 16)]
Mat4: TypeAlias = Annotated[Floats | Sequence[Floats], GlslType("mat4", "f4", 4, 16, columns=4)]
"""A (4, 4) array whose rows are the matrix's columns (so m.T of the usual notation), or 16 numbers column by column."""


def array(element: Any, count: int) -> GlslType:
    """A fixed array, to be used as ``Annotated[Any, array(Vec4, 6)]``. Values are (count, components) arrays."""
    kind = _type_of(element, "array")
    if kind.count or count < 1:
        raise FormatError(f"array({kind.name}, {count}): one dimension with at least one element, please")
    return dataclasses.replace(kind, count=count)


def _type_of(annotation: Any, where: str) -> GlslType:
    if isinstance(annotation, GlslType):
        return annotation
    for extra in getattr(annotation, "__metadata__", ()):
        if isinstance(extra, GlslType):
            return extra
    plain = {float: _FLOAT, int: _INT, bool: _BOOL}.get(annotation)
    if plain is None:
        raise FormatError(
            f"{where}: {annotation!r} has no GLSL type; use float, int, bool, UInt, Vec2, Vec3, Vec4, IVec2, IVec4, "
            "UVec2, UVec4, Mat4 or Annotated[Any, array(Vec4, n)]"
        )
    return plain


@dataclass(frozen=True)
class Member:
    """One member: where it lies in the block."""

    name: str
    type: GlslType
    offset: int
    help: str


class StructLayout:
    """The memory layout of a dataclass as a std140 (or std430) block.

    dtype: numpy record, `size` bytes, to fill with pack(). glsl: the struct's declaration. block(): a whole uniform or
    storage block. Fields may carry metadata {"help": ...}, which becomes a comment in the GLSL.
    """

    def __init__(self, cls: type[Any], layout: str = "std140") -> None:
        if not dataclasses.is_dataclass(cls):
            raise FormatError(f"{cls!r} is not a dataclass")
        if layout not in ("std140", "std430"):
            raise FormatError(f"layout must be std140 or std430, found {layout!r}")
        self.cls, self.layout, self.name = cls, layout, cls.__name__
        hints = get_type_hints(cls, include_extras=True)
        members: list[Member] = []
        offset = 0
        largest = 4
        for item in dataclasses.fields(cls):
            if not re.fullmatch(r"[a-z]\w*", item.name, re.IGNORECASE) or "__" in item.name:
                raise FormatError(f"{self.name}.{item.name} is not a GLSL identifier")
            kind = _type_of(hints[item.name], f"{self.name}.{item.name}")
            align = kind.alignment
            if kind.count and layout == "std140":
                align = max(16, align)
            offset = -(-offset // align) * align
            members.append(Member(item.name, kind, offset, str(item.metadata.get("help", ""))))
            offset += kind.stride(layout) * kind.count if kind.count else kind.bytes
            largest = max(largest, align)
        if not members:
            raise FormatError(f"{self.name} has no fields: a block needs at least one")
        unit = 16 if layout == "std140" else largest
        self.members = tuple(members)
        self.size = -(-offset // unit) * unit
        self.dtype = np.dtype(
            {
                "names": [m.name for m in members],
                "formats": [self._numpy_format(m.type) for m in members],
                "offsets": [m.offset for m in members],
                "itemsize": self.size,
            }
        )

    def _numpy_format(self, kind: GlslType) -> Any:
        base = np.dtype(kind.base)
        shape: tuple[int, ...] = (kind.columns,) if kind.columns > 1 else ()
        shape += (kind.components,) if kind.components > 1 else ()
        element = np.dtype((base, shape)) if shape else base
        if not kind.count:
            return element
        # Elements are `stride` bytes apart: a record with one padded field; `views` hides it again.
        stride = kind.stride(self.layout)
        padded = np.dtype({"names": ["value"], "formats": [element], "offsets": [0], "itemsize": stride})
        return np.dtype((padded, (kind.count,)))

    def record(self) -> NDArray[Any]:
        """One zeroed record, shape (1,)."""
        return np.zeros(1, self.dtype)

    def views(self, record: NDArray[Any]) -> dict[str, NDArray[Any]]:
        """Each member of a record as a plain array: (components,), (count, components), (4, 4); (1,) for scalars."""
        views: dict[str, NDArray[Any]] = {}
        for member in self.members:
            part = record[member.name]
            if member.type.count:
                part = part["value"]
            views[member.name] = part if part.ndim == 1 else part[0]
        return views

    def pack(self, instance: Any) -> bytes:
        """The bytes of an instance; for per-frame use UniformBlock.write, which allocates nothing."""
        record = self.record()
        for name, view in self.views(record).items():
            fill(view, getattr(instance, name), f"{self.name}.{name}")
        return record.tobytes()

    def _declarations(self) -> str:
        lines: list[str] = []
        for member in self.members:
            suffix = f"[{member.type.count}]" if member.type.count else ""
            comment = f"  // {' '.join(member.help.split())}" if member.help else ""
            lines.append(f"    {member.type.name} {member.name}{suffix};{comment}")
        return "\n".join(lines)

    @property
    def glsl(self) -> str:
        """``struct Name { ... };``"""
        return f"struct {self.name} {{\n{self._declarations()}\n}};\n"

    def block(self, binding: int, instance: str, storage: bool = False) -> str:
        """A whole block under an instance name: shaders write ``instance.member``."""
        kind = "buffer" if storage else "uniform"
        head = f"layout({self.layout}, binding = {binding}) {kind} {self.name}"
        return f"{head} {{\n{self._declarations()}\n}} {instance};\n"


def fill(view: NDArray[Any], value: Any, where: str) -> None:
    """Copy a value into a member's view; FormatError says which member got what."""
    try:
        if view.shape == (1,) and not hasattr(value, "__len__"):
            view[0] = value
            return
        given = np.asarray(value)
        if given.size != view.size:
            raise ValueError(f"{given.size} numbers")
        view[...] = given.reshape(view.shape)
    except (TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{where} needs {view.size} numbers of {view.dtype}, shape {view.shape}: {error}") from None
