"""What a stage reads and writes outside itself, found by following pointers through its instructions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from .module import Instruction, Module, Op, Variable

__all__ = ["Access", "accesses"]

_POINTS = (Op.ACCESS_CHAIN, Op.IN_BOUNDS_CHAIN, Op.TEXEL_POINTER, Op.COPY_OBJECT, Op.SAMPLED_IMAGE, Op.IMAGE)
"""Their result stands for (a part of) what their third word stands for."""


@dataclass(frozen=True)
class Access:
    """Whether any instruction that the entry point can reach reads or writes a variable: whatever the data are. Asking
    for a size is neither."""

    variable: Variable
    reads: bool
    writes: bool


def accesses(module: Module) -> list[Access]:
    """Of all textures, images, storage buffers, uniform blocks, inputs and outputs that are touched, by name."""
    roots, opaque = _roots(module), _opaque(module)
    read: set[int] = set()
    written: set[int] = set()
    for number in module.reachable:
        for one in module.functions[number].body:
            reads, writes = _touched(one)
            for pointer in reads:
                held = roots.get(pointer, frozenset())
                # A load of an image or sampler is no read of it: what is done with its value is.
                read |= held - opaque if one.code == Op.LOAD else held
            for pointer in writes:
                written |= roots.get(pointer, frozenset())
    found = [
        Access(variable, number in read, number in written)
        for number, variable in module.variables.items()
        if number in read or number in written
    ]
    return sorted(found, key=lambda access: (access.variable.kind, access.variable.name))


def _touched(one: Instruction) -> tuple[Iterable[int], Iterable[int]]:
    """Pointers (or images) that an instruction reads, and those that it writes."""
    code, w = one.code, one.words
    if code == Op.STORE:
        return (), (w[0],)
    if code == Op.COPY_MEMORY:
        return (w[1],), (w[0],)
    if code == Op.IMAGE_WRITE:
        return (), (w[0],)
    if code == Op.ATOMIC_STORE:
        return (), (w[0],)
    if Op.ATOMIC_FIRST <= code <= Op.ATOMIC_LAST:
        return (w[2],), (w[2],)
    if code in (Op.LOAD, Op.ATOMIC_LOAD, Op.IMAGE_READ) or Op.SAMPLE_FIRST <= code <= Op.SAMPLE_LAST:
        return (w[2],), ()
    return (), ()


def _roots(module: Module) -> dict[int, frozenset[int]]:
    """Of each pointer and image the variables that it may stand for."""
    roots: dict[int, frozenset[int]] = {number: frozenset((number,)) for number in module.variables}
    opaque = _opaque(module)
    changed = True
    while changed:
        changed = False
        for number in module.reachable:
            for one in module.functions[number].body:
                code, w = one.code, one.words
                if code in _POINTS:
                    changed |= _join(roots, w[1], roots.get(w[2]))
                elif code == Op.LOAD:
                    held = roots.get(w[2], frozenset()) & opaque
                    changed |= bool(held) and _join(roots, w[1], held)
                elif code == Op.CALL:
                    for parameter, argument in zip(module.functions[w[2]].parameters, w[3:], strict=True):
                        changed |= _join(roots, parameter, roots.get(argument))
    return roots


def _opaque(module: Module) -> frozenset[int]:
    return frozenset(n for n, v in module.variables.items() if v.kind in ("texture", "image"))


def _join(roots: dict[int, frozenset[int]], into: int, more: frozenset[int] | None) -> bool:
    if not more or more <= roots.get(into, frozenset()):
        return False
    roots[into] = roots.get(into, frozenset()) | more
    return True
