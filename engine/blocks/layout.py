"""Uniform and storage blocks from dataclasses: one declaration gives the bytes and the GLSL text.

The layout rules are those of OpenGL 4.3, 7.6.2.2: std140, or std430 for storage blocks.
"""

from __future__ import annotations

import dataclasses
import math
import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, TypeAlias, TypeVar, cast, get_type_hints

import numpy as np
from numpy.typing import NDArray

from .errors import FormatError

__all__ = [
    "GlslType",
    "IVec2",
    "IVec3",
    "IVec4",
    "Mat3",
    "Mat4",
    "StructLayout",
    "UInt",
    "UVec2",
    "UVec4",
    "Vec2",
    "Vec3",
    "Vec4",
    "array",
    "zeros",
]


@dataclass(frozen=True)
class GlslType:
    """A type of numbers. alignment in bytes; format as in the module struct; shape of a value: () for one number."""

    name: str
    format: str
    alignment: int
    shape: tuple[int, ...] = ()

    @cached_property
    def size(self) -> int:
        """Bytes."""
        return struct.calcsize("=" + self.format)


@dataclass(frozen=True)
class _Array:
    element: Any
    count: int
    flat: bool = False


_T = TypeVar("_T")
_FLOAT = GlslType("float", "f", 4)
_INT = GlslType("int", "i", 4)
_BOOL = GlslType("bool", "?3x", 4)
_NUMPY = {"f": "<f4", "i": "<i4", "I": "<u4", "?": "<u4"}

Floats: TypeAlias = Sequence[float] | NDArray[np.floating[Any]]
Ints: TypeAlias = Sequence[int] | NDArray[np.integer[Any]]

UInt: TypeAlias = Annotated[int, GlslType("uint", "I", 4)]
Vec2: TypeAlias = Annotated[Floats, GlslType("vec2", "2f", 8, (2,))]
Vec3: TypeAlias = Annotated[Floats, GlslType("vec3", "3f", 16, (3,))]
Vec4: TypeAlias = Annotated[Floats, GlslType("vec4", "4f", 16, (4,))]
IVec2: TypeAlias = Annotated[Ints, GlslType("ivec2", "2i", 8, (2,))]
IVec3: TypeAlias = Annotated[Ints, GlslType("ivec3", "3i", 16, (3,))]
IVec4: TypeAlias = Annotated[Ints, GlslType("ivec4", "4i", 16, (4,))]
UVec2: TypeAlias = Annotated[Ints, GlslType("uvec2", "2I", 8, (2,))]
UVec4: TypeAlias = Annotated[Ints, GlslType("uvec4", "4I", 16, (4,))]
Mat3: TypeAlias = Annotated[Floats | Sequence[Floats], GlslType("mat3", "3f4x" * 3, 16, (3, 3))]
Mat4: TypeAlias = Annotated[Floats | Sequence[Floats], GlslType("mat4", "16f", 16, (4, 4))]
"""An array whose rows are the matrix's columns (m.T of the usual notation). Mat3 takes as much room as three Vec4."""


def array(element: Any, count: int, flat: bool = False) -> _Array:
    """A fixed array, to be used as ``Annotated[Any, array(Vec4, 6)]``; its element may be a dataclass.

    flat: of a uniform block's dataclasses, whose every number is a uniform to the driver. A thousand elements cost
    megabytes and much of the start in each program that has them, so here they are one array of numbers, and shaders
    read an element by the function ``<Element> <instance>_<member>(int i)``; their number is ``<INSTANCE>_<MEMBER>``.
    """
    if _array_of(element) or count < 1:
        raise FormatError(f"array({element!r}, {count}): one dimension with at least one element, please")
    if flat and not dataclasses.is_dataclass(element):
        raise FormatError(f"array({element!r}, {count}, flat=True): flat arrays are of dataclasses")
    return _Array(element, count, flat)


def _array_of(annotation: Any) -> _Array | None:
    extras = (annotation, *getattr(annotation, "__metadata__", ()))
    return next((e for e in extras if isinstance(e, _Array)), None)


def _type_of(annotation: Any, layout: str, where: str) -> GlslType | StructLayout:
    for extra in (annotation, *getattr(annotation, "__metadata__", ())):
        if isinstance(extra, GlslType):
            return extra
    plain = getattr(annotation, "__origin__", annotation)  # of Annotated[float, "m"]
    if dataclasses.is_dataclass(plain):
        return StructLayout(plain, layout)  # type: ignore[arg-type]
    kind = {float: _FLOAT, int: _INT, bool: _BOOL}.get(plain)
    if kind is None:
        raise FormatError(
            f"{where}: {annotation!r} has no GLSL type; use float, int, bool, UInt, Vec2, Vec3, Vec4, "
            "IVec2, IVec3, IVec4, UVec2, UVec4, Mat3, Mat4, a dataclass of those or Annotated[Any, array(Vec4, n)]"
        )
    return kind


@dataclass(frozen=True)
class Member:
    """One member: where it lies in the block. stride: bytes from one element to the next where count > 0."""

    name: str
    type: GlslType | StructLayout
    count: int
    offset: int
    stride: int
    comment: str
    flat: bool = False

    @property
    def fields(self) -> StructLayout | None:
        return self.type if isinstance(self.type, StructLayout) else None

    @property
    def shape(self) -> tuple[int, ...]:
        """Of a value that is numbers."""
        own = self.type.shape if isinstance(self.type, GlslType) else ()
        return (self.count, *own) if self.count else own


class StructLayout:
    """The memory layout of a dataclass as a std140 (or std430) block. Fields may be dataclasses, and arrays of them.

    size: bytes. glsl: the struct's declaration. block(): a whole uniform or storage block. dtype: for records that
    numpy fills. A text in a field's annotation, ``Annotated[float, "m"]``, is its unit or meaning and becomes a comment
    in the GLSL. Fields have no defaults: none is forgotten.
    """

    def __init__(self, cls: type, layout: str = "std140") -> None:
        if not dataclasses.is_dataclass(cls):
            raise FormatError(f"{cls!r} is not a dataclass")
        if layout not in ("std140", "std430"):
            raise FormatError(f"layout must be std140 or std430, found {layout!r}")
        self.cls, self.layout, self.name = cls, layout, cls.__name__
        hints = get_type_hints(cls, include_extras=True)
        least = 16 if layout == "std140" else 4  # alignment of structs and of elements of arrays
        members: list[Member] = []
        offset, self.alignment, self.format = 0, least, ""
        for item in dataclasses.fields(cls):
            where, hint = f"{self.name}.{item.name}", hints[item.name]
            if not re.fullmatch(r"[a-z]\w*", item.name, re.IGNORECASE) or "__" in item.name:
                raise FormatError(f"{where} is not a GLSL identifier")
            if item.default is not dataclasses.MISSING or item.default_factory is not dataclasses.MISSING:
                raise FormatError(
                    f"{where} has a default: whoever fills a block gives every field; take the default away, and begin "
                    f"with zeros({self.name}) where fields are filled one by one"
                )
            several = _array_of(hint)
            kind = _type_of(several.element if several else hint, layout, where)
            align = max(least, kind.alignment) if several else kind.alignment
            stride = _up(kind.size, align) if several else kind.size
            gap = _up(offset, align) - offset
            comment = "; ".join(e for e in getattr(hint, "__metadata__", ()) if isinstance(e, str))
            count = several.count if several else 0
            flat = several is not None and several.flat
            if flat and not _can_be_flat(cast(StructLayout, kind)):
                raise FormatError(f"{where}: flat arrays are of std140 dataclasses with numbers and vectors only")
            members.append(Member(item.name, kind, count, offset + gap, stride, comment, flat))
            self.format += f"{gap}x" + f"{kind.format}{stride - kind.size}x" * (count or 1)
            offset += gap + stride * (count or 1)
            self.alignment = max(self.alignment, align)
        if not members:
            raise FormatError(f"{self.name} has no fields: a block needs at least one")
        self.members = tuple(members)
        self.size = _up(offset, self.alignment)
        self.format += f"{self.size - offset}x"
        self._names = frozenset(m.name for m in members)
        self._plan = tuple((m.name, m.shape, m.fields, m.count) for m in members)
        self._packer = struct.Struct("=" + self.format)

    def pack(self, value: object) -> bytes:
        """The bytes of an instance. Instead of it, and of each dataclass in it, a mapping with the same names will do,
        another dataclass or a record of numpy's; for an array of them a sequence, or an array of records.

        FormatError names the field that is missing, unknown or does not fit.
        """
        numbers: list[Any] = []
        try:
            self._collect(value, numbers)
            return self._packer.pack(*numbers)
        except (AttributeError, LookupError, TypeError, ValueError, OverflowError, struct.error) as error:
            self._explain(value, self.name)
            raise FormatError(f"{self.name}: {error}") from None

    def _collect(self, value: Any, into: list[Any]) -> None:
        """A value's numbers in the order of the members."""
        own = value.__class__ is self.cls
        if not own and _names(value) != self._names:
            raise TypeError
        read: Callable[[Any, str], Any] = getattr if own or dataclasses.is_dataclass(value) else _item
        for name, shape, fields, count in self._plan:
            part = read(value, name)
            if fields is None:
                if part.__class__ is tuple and (len(part),) == shape:
                    into += part
                elif shape:
                    _flatten(part, shape, into)
                else:
                    into.append(part)
            elif not count:
                fields._collect(part, into)
            elif len(part) != count:
                raise ValueError
            else:
                for element in part:
                    fields._collect(element, into)

    def _explain(self, value: Any, where: str) -> None:
        """Raise for the first field that does not fit."""
        names = _names(value)
        if names is None:
            raise FormatError(f"{where} needs a {self.name} or a mapping with its fields: found {_shown(value)}")
        for what, wrong in (("lacks", self._names - names), ("has no field", names - self._names)):
            if wrong:
                raise FormatError(f"{where} {what} {', '.join(sorted(wrong))}; its fields are {self._listed}")
        read: Callable[[Any, str], Any] = getattr if dataclasses.is_dataclass(value) else _item
        for member in self.members:
            part = read(value, member.name)
            fields, place = member.fields, f"{where}.{member.name}"
            if fields is not None and not member.count:
                fields._explain(part, place)
            elif fields is not None:
                if not hasattr(part, "__len__") or isinstance(part, Mapping) or len(part) != member.count:
                    raise FormatError(f"{place} needs {member.count} of {fields.name}: found {_shown(part)}")
                for k, element in enumerate(part):
                    fields._explain(element, f"{place}[{k}]")
            else:
                numbers: list[Any] = []
                try:
                    _flatten(part, member.shape, numbers)
                    struct.pack("=" + member.type.format * (member.count or 1), *numbers)
                except (LookupError, TypeError, ValueError, OverflowError, struct.error) as error:
                    needs = f"{math.prod(member.shape)} numbers for {member.type.name}, shape {member.shape}"
                    raise FormatError(f"{place} needs {needs}: {_shown(part)} {error}".rstrip()) from None

    @cached_property
    def dtype(self) -> np.dtype[np.void]:
        """The same bytes as a record of numpy's. FormatError for elements with gaps between their numbers: a Mat3, and
        std140's arrays of less than a Vec4."""
        kinds: list[Any] = []
        for member in self.members:
            if isinstance(member.type, StructLayout):
                kind = member.type.dtype
            else:
                kind = np.dtype((_NUMPY[next(c for c in member.type.format if c in _NUMPY)], member.type.shape))
            if kind.itemsize != member.stride:
                raise FormatError(f"{self.name}.{member.name}: numpy has no {member.type.name} with gaps")
            kinds.append((kind, (member.count,)) if member.count else kind)
        names, offsets = [m.name for m in self.members], [m.offset for m in self.members]
        return np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": self.size})

    @property
    def _listed(self) -> str:
        return ", ".join(m.name for m in self.members)

    def _declarations(self) -> str:
        lines: list[str] = []
        for member in self.members:
            kind, count = (
                ("uvec4", member.count * member.stride // 16) if member.flat else (member.type.name, member.count)
            )
            suffix = f"[{count}]" if count else ""
            comment = f"  // {' '.join(member.comment.split())}" if member.comment else ""
            lines.append(f"    {kind} {member.name}{suffix};{comment}")
        return "\n".join(lines)

    @property
    def _structs(self) -> str:
        """The structs that members need; guarded, because several blocks may use one."""
        needed = {m.type.name: m.type.glsl for m in self.members if isinstance(m.type, StructLayout)}
        return "".join(f"#ifndef PF_STRUCT_{n}\n#define PF_STRUCT_{n}\n{text}#endif\n" for n, text in needed.items())

    @property
    def glsl(self) -> str:
        """``struct Name { ... };``, after those that it needs."""
        return f"{self._structs}struct {self.name} {{\n{self._declarations()}\n}};\n"

    def block(self, binding: int, instance: str, storage: bool = False) -> str:
        """A whole block under an instance name: shaders write ``instance.member``."""
        kind = "buffer" if storage else "uniform"
        head = f"layout({self.layout}, binding = {binding}) {kind} {self.name}"
        read = "".join(_reader(member, instance) for member in self.members if member.flat)
        return f"{self._structs}{head} {{\n{self._declarations()}\n}} {instance};\n{read}"


def zeros(cls: type[_T]) -> _T:
    """An instance of a block's dataclass whose numbers are all 0, for who fills its fields one by one."""
    return cast(_T, _zeros(StructLayout(cls)))


def _zeros(layout: StructLayout) -> Any:
    values: dict[str, Any] = {}
    for name, shape, fields, count in layout._plan:
        if fields is None:
            values[name] = np.zeros(shape, int).tolist()
        else:
            values[name] = [_zeros(fields) for _ in range(count)] if count else _zeros(fields)
    return layout.cls(**values)


_FROM_BITS = {"f": "uintBitsToFloat({})", "i": "ivec{n}({})", "I": "{}", "?": "bool({})"}


def _can_be_flat(layout: StructLayout) -> bool:
    """Whether it has numbers, vectors and dataclasses of them alone: std140 puts each within 16 bytes."""
    for member in layout.members:
        fits = _can_be_flat(member.type) if isinstance(member.type, StructLayout) else len(member.shape) < 2
        if member.count or not fits:
            return False
    return layout.layout == "std140"


def _reader(member: Member, instance: str) -> str:
    """GLSL: the function that reads an element of a flat array, and how many there are."""
    assert isinstance(member.type, StructLayout)
    place = f"{instance}.{member.name}[{member.stride // 16} * i + {{}}].{{}}"
    return "\n".join([
        f"const int {instance.upper()}_{member.name.upper()} = {member.count};",
        f"{member.type.name} {instance}_{member.name}(int i) {{",
        f"    {member.type.name} element;",
        *_parts_read(member.type, place, "element", 0),
        "    return element;",
        "}\n",
    ])  # fmt: skip


def _parts_read(layout: StructLayout, place: str, into: str, start: int) -> Iterator[str]:
    for part in layout.members:
        name, offset = f"{into}.{part.name}", start + part.offset
        if isinstance(part.type, StructLayout):
            yield from _parts_read(part.type, place, name, offset)
            continue
        n, word = math.prod(part.shape), offset // 4
        kind = next(c for c in part.type.format if c in _FROM_BITS)
        bits = place.format(word // 4, "xyzw"[word % 4 : word % 4 + n])
        yield f"    {name} = {_FROM_BITS[kind].format(bits, n=n).replace('ivec1', 'int')};"


def _up(offset: int, alignment: int) -> int:
    return -(-offset // alignment) * alignment


def _item(value: Any, name: str) -> Any:
    return value[name]


def _names(value: object) -> frozenset[str] | None:
    """The fields of what may stand for a dataclass; None for anything else."""
    if isinstance(value, Mapping):
        return frozenset(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return frozenset(f.name for f in dataclasses.fields(value))
    if isinstance(value, np.void) and value.dtype.names:
        return frozenset(value.dtype.names)
    return None


def _flatten(value: Any, shape: tuple[int, ...], into: list[Any]) -> None:
    """Append the numbers of a value of this shape. ValueError or TypeError for another one."""
    if isinstance(value, np.ndarray):
        if value.shape != shape:
            raise ValueError(f"has shape {value.shape}")
        into += value.ravel().tolist()
    elif not shape:
        into.append(value)
    elif len(value) != shape[0]:
        raise ValueError(f"has {len(value)}")
    elif len(shape) == 1:
        into += value
    else:
        for row in value:
            _flatten(row, shape[1:], into)


def _shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."
