"""Reads SPIR-V 1.0 as far as the checks need it (Khronos, SPIR-V Specification 1.0, 2.3 and 3)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

from ..errors import FormatError

__all__ = ["Function", "Instruction", "Module", "Op", "Storage", "Variable"]

_MAGIC = 0x07230203
_BUFFER_BLOCK, _BUILT_IN, _LOCATION, _BINDING, _LOCAL_SIZE = 3, 11, 30, 33, 17


class Op(IntEnum):
    """Codes of the instructions that are looked at."""

    NAME, MEMBER_NAME, ENTRY_POINT, EXECUTION_MODE, CAPABILITY = 5, 6, 15, 16, 17
    TYPE_BOOL, TYPE_INT, TYPE_FLOAT, TYPE_VECTOR, TYPE_MATRIX, CONSTANT = 20, 21, 22, 23, 24, 43
    TYPE_IMAGE, TYPE_SAMPLED_IMAGE, TYPE_ARRAY, TYPE_RUNTIME_ARRAY, TYPE_STRUCT, TYPE_POINTER = 25, 27, 28, 29, 30, 32
    FUNCTION, PARAMETER, FUNCTION_END, CALL, VARIABLE = 54, 55, 56, 57, 59
    TEXEL_POINTER, LOAD, STORE, COPY_MEMORY, ACCESS_CHAIN, IN_BOUNDS_CHAIN, ARRAY_LENGTH = 60, 61, 62, 63, 65, 66, 68
    DECORATE, MEMBER_DECORATE, COPY_OBJECT = 71, 72, 83
    SAMPLED_IMAGE, SAMPLE_FIRST, SAMPLE_LAST, IMAGE_READ, IMAGE_WRITE, IMAGE = 86, 87, 97, 98, 99, 100
    CONTROL_BARRIER, ATOMIC_LOAD, ATOMIC_STORE, ATOMIC_FIRST, ATOMIC_LAST = 224, 227, 228, 229, 242
    PHI, LOOP_MERGE, SELECTION_MERGE, LABEL, BRANCH, BRANCH_IF, SWITCH = 245, 246, 247, 248, 249, 250, 251
    KILL, RETURN, RETURN_VALUE, UNREACHABLE = 252, 253, 254, 255


class Storage(IntEnum):
    """Storage classes."""

    CONSTANT, INPUT, UNIFORM, OUTPUT, WORKGROUP, FUNCTION = 0, 1, 2, 3, 4, 7


_OPAQUE: dict[int, str] = {Op.TYPE_SAMPLED_IMAGE: "texture", Op.TYPE_IMAGE: "image"}
_KINDS: dict[int, str] = {Storage.INPUT: "input", Storage.OUTPUT: "output", Storage.WORKGROUP: "shared"}


@dataclass(frozen=True)
class Instruction:
    """code: as in Op. words: operands."""

    code: int
    words: tuple[int, ...]


@dataclass
class Function:
    """One function: its parameters' ids and its instructions in order."""

    id: int
    parameters: list[int] = field(default_factory=list)
    body: list[Instruction] = field(default_factory=list)


@dataclass(frozen=True)
class Variable:
    """A module's variable. kind: "texture", "image", "storage", "uniform" (a block), "value" (a uniform outside any
    block), "input", "output" or "shared". binding, location, built_in: None where it has none."""

    id: int
    name: str
    kind: str
    binding: int | None
    location: int | None
    built_in: int | None


class Module:
    """One stage. FormatError for what is no SPIR-V."""

    def __init__(self, data: bytes) -> None:
        if len(data) < 20 or len(data) % 4 or struct.unpack_from("<I", data)[0] != _MAGIC:
            raise FormatError(f"{len(data)} bytes that begin with {data[:4]!r} are no SPIR-V in little-endian words")
        self._words = struct.unpack(f"<{len(data) // 4}I", data)
        self.names: dict[int, str] = {}
        self.members: dict[tuple[int, int], str] = {}
        self.capabilities: set[int] = set()
        self.entry = 0
        self.local_size = (1, 1, 1)
        """Of a compute stage."""
        self.functions: dict[int, Function] = {}
        self._decorations: dict[int, dict[int, int]] = {}
        self._member_built_ins: set[int] = set()
        self._types: dict[int, Instruction] = {}
        self._constants: dict[int, int] = {}
        self._variables: list[tuple[int, int, int]] = []
        self._read()

    def _instructions(self) -> Iterator[Instruction]:
        words, at = self._words, 5
        while at < len(words):
            count = words[at] >> 16
            if count == 0 or at + count > len(words):
                raise FormatError(f"SPIR-V is cut off at word {at} of {len(words)}")
            yield Instruction(words[at] & 0xFFFF, words[at + 1 : at + count])
            at += count

    def _read(self) -> None:
        function: Function | None = None
        for one in self._instructions():
            code = one.code
            w: tuple[int, ...] = one.words
            if function is not None:
                if code == Op.FUNCTION_END:
                    function = None
                elif code == Op.PARAMETER:
                    function.parameters.append(w[1])
                else:
                    function.body.append(one)
            elif code == Op.FUNCTION:
                function = self.functions[w[1]] = Function(w[1])
            elif code == Op.NAME:
                self.names[w[0]] = _text(w[1:])
            elif code == Op.MEMBER_NAME:
                self.members[w[0], w[1]] = _text(w[2:])
            elif code == Op.CAPABILITY:
                self.capabilities.add(w[0])
            elif code == Op.ENTRY_POINT:
                self.entry = w[1]
            elif code == Op.EXECUTION_MODE and w[1] == _LOCAL_SIZE:
                self.local_size = (w[2], w[3], w[4])
            elif code == Op.CONSTANT:
                self._constants[w[1]] = w[2]
            elif code == Op.DECORATE:
                self._decorations.setdefault(w[0], {})[w[1]] = next(iter(w[2:]), 0)
            elif code == Op.MEMBER_DECORATE and w[2] == _BUILT_IN:
                self._member_built_ins.add(w[0])
            elif Op.TYPE_BOOL <= code <= Op.TYPE_POINTER:
                self._types[w[0]] = one
            elif code == Op.VARIABLE:
                self._variables.append((w[0], w[1], w[2]))

    @cached_property
    def variables(self) -> dict[int, Variable]:
        """All variables outside functions, by id."""
        found = {}
        for type_id, number, storage in self._variables:
            marks = self._decorations.get(number, {})
            held = self._pointed(type_id)
            name = self.names.get(number) or self.names.get(held.words[0], "")
            built_in = marks.get(_BUILT_IN)
            if built_in is None and held.words[0] in self._member_built_ins:
                built_in = -1  # gl_PerVertex, a block of several
            kind = self._kind(storage, held)
            found[number] = Variable(number, name, kind, marks.get(_BINDING), marks.get(_LOCATION), built_in)
        return found

    @cached_property
    def reachable(self) -> frozenset[int]:
        """Functions that the entry point calls, itself among them."""
        found, left = set(), [self.entry]
        while left:
            one = left.pop()
            if one not in found:
                found.add(one)
                left += [i.words[2] for i in self.functions[one].body if i.code == Op.CALL]
        return frozenset(found)

    @cached_property
    def shared_bytes(self) -> int:
        """What a work group shares, without any padding."""
        return sum(
            self._bytes(self._types[type_id].words[2])
            for type_id, _, storage in self._variables
            if storage == Storage.WORKGROUP
        )

    def _bytes(self, type_id: int) -> int:
        held = self._types[type_id]
        code, w = held.code, held.words
        if code in (Op.TYPE_INT, Op.TYPE_FLOAT):
            return w[1] // 8
        if code in (Op.TYPE_VECTOR, Op.TYPE_MATRIX):
            return w[2] * self._bytes(w[1])
        if code == Op.TYPE_ARRAY:
            return self._constants[w[2]] * self._bytes(w[1])
        return sum(map(self._bytes, w[1:])) if code == Op.TYPE_STRUCT else 4

    def _pointed(self, pointer: int) -> Instruction:
        """The type that a pointer's type points to, within any arrays."""
        held = self._types.get(self._types[pointer].words[2])
        while held is not None and held.code in (Op.TYPE_ARRAY, Op.TYPE_RUNTIME_ARRAY):
            held = self._types.get(held.words[1])
        return held or Instruction(0, (0,))

    def _kind(self, storage: int, held: Instruction) -> str:
        if storage == Storage.UNIFORM:
            return "storage" if _BUFFER_BLOCK in self._decorations.get(held.words[0], {}) else "uniform"
        if storage == Storage.CONSTANT:
            return _OPAQUE.get(held.code, "value")
        return _KINDS.get(storage, "value")


def _text(words: tuple[int, ...]) -> str:
    return struct.pack(f"<{len(words)}I", *words).split(b"\0")[0].decode("utf-8")
