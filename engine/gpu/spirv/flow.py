"""Barriers in control flow that may differ between the invocations of a work group."""

from __future__ import annotations

from dataclasses import dataclass, field

from .module import Function, Instruction, Module, Op, Variable

__all__ = ["divergent_barriers"]

_OWN = {27, 28, 29, 36, 41}
"""Built-ins that differ within a work group: LocalInvocationId 27, GlobalInvocationId 28, LocalInvocationIndex 29, and
the subgroup's SubgroupSize 36, SubgroupLocalInvocationId 41."""
_LEAVES = (Op.RETURN, Op.RETURN_VALUE, Op.KILL)
_NO_RESULT = {
    Op.STORE, Op.COPY_MEMORY, Op.IMAGE_WRITE, Op.ATOMIC_STORE, Op.CONTROL_BARRIER, 225, Op.LOOP_MERGE,
    Op.SELECTION_MERGE, Op.LABEL, Op.BRANCH, Op.BRANCH_IF, Op.SWITCH, *_LEAVES, Op.UNREACHABLE, 0, 8, 317,
}  # fmt: skip


def divergent_barriers(module: Module) -> list[tuple[str, str]]:
    """(function, why) of each function with such a barrier.

    A value differs where it is computed from an invocation's own number, from what an atomic returned, or from a
    variable that was stored under a condition that differs. What lies in buffers, images and shared memory counts as
    the same for all: it is where it is read at a place that is.
    """
    if not any(i.code == Op.CONTROL_BARRIER for n in module.reachable for i in module.functions[n].body):
        return []
    blocks = {number: _blocks(module.functions[number]) for number in sorted(module.reachable)}
    differing = _differing(module, blocks)
    entered = _entered_unevenly(blocks, differing)
    found = []
    for number, parts in blocks.items():
        why = "the function is called under a condition that differs" if number in entered else ""
        for block in parts:
            inside = why or block.condition(differing)
            if inside and any(i.code == Op.CONTROL_BARRIER for i in block.body):
                found.append((module.names.get(number, "?").partition("(")[0], inside))
                break
    return found


@dataclass
class _Block:
    """A basic block. within: conditions (ids) of the selections and loops around it; after: those under which some
    invocations have left the function, or the loop around it, before."""

    label: int
    body: list[Instruction] = field(default_factory=list)
    within: frozenset[int] = frozenset()
    after: frozenset[int] = frozenset()

    def condition(self, differing: set[int]) -> str:
        """Why not all invocations need come here; "" where they do."""
        if self.within & differing:
            return "it lies within a condition or loop that differs between invocations"
        return "invocations may have left before, under a condition that differs" if self.after & differing else ""


def _blocks(function: Function) -> list[_Block]:
    """In the order of the text, which structured control flow keeps: a construct begins at its header and ends at the
    label that its merge instruction names."""
    blocks: list[_Block] = []
    open_: list[tuple[int, bool, set[int]]] = []  # (label of the merge, a loop, conditions)
    left: set[int] = set()  # conditions under which the function was left
    broken: dict[int, set[int]] = {}  # by a loop's merge: those under which an invocation left an iteration early
    for one in function.body:
        if one.code == Op.LABEL:
            while open_ and open_[-1][0] == one.words[0]:
                open_.pop()
            within = frozenset().union(*(c for _, _, c in open_)) if open_ else frozenset()
            early = set(left)
            for merge, loop, _ in open_:
                if loop:
                    early |= broken.get(merge, set())
            blocks.append(_Block(one.words[0], [], within, frozenset(early)))
            continue
        block = blocks[-1]
        block.body.append(one)
        if one.code in (Op.LOOP_MERGE, Op.SELECTION_MERGE):
            open_.append((one.words[0], one.code == Op.LOOP_MERGE, set()))
        elif one.code in (Op.BRANCH_IF, Op.SWITCH):
            if open_:
                open_[-1][2].add(one.words[0])
        elif one.code == Op.BRANCH:
            for place, (merge, loop, _) in enumerate(open_):
                if loop and one.words[0] == merge:  # a break: those who stay in the loop differ from those who don't
                    broken.setdefault(merge, set()).update(*(c for _, _, c in open_[place:]))
        elif one.code in _LEAVES:
            left |= set().union(*(c for _, _, c in open_))
    return blocks


def _differing(module: Module, blocks: dict[int, list[_Block]]) -> set[int]:
    """Ids of values, and of variables that hold such, that may differ within a work group."""
    own = {n for n, v in module.variables.items() if _is_own(v)}
    differing, size = set(own), -1
    bases: dict[int, int] = {}
    while size != len(differing):
        size = len(differing)
        for parts in blocks.values():
            for block in parts:
                uneven = bool((block.within | block.after) & differing)
                for one in block.body:
                    _follow(module, one, uneven, differing, bases)
    return differing


def _is_own(variable: Variable) -> bool:
    return variable.kind == "input" and variable.built_in in _OWN


def _follow(module: Module, one: Instruction, uneven: bool, differing: set[int], bases: dict[int, int]) -> None:
    code, w = one.code, one.words
    if code == Op.STORE:
        base = bases.get(w[0], w[0])
        if (uneven or w[1] in differing or w[0] in differing) and _private(module, base):
            differing.update((base, w[0]))
    elif code == Op.CALL:
        function = module.functions[w[2]]
        for parameter, argument in zip(function.parameters, w[3:], strict=True):
            bases.setdefault(parameter, bases.get(argument, argument))
            if argument in differing or bases.get(argument) in differing:
                differing.add(parameter)
            if parameter in differing:  # it may have been written there
                differing.add(argument)
        if any(i.words[0] in differing for i in function.body if i.code == Op.RETURN_VALUE) or any(
            a in differing for a in w[3:]
        ):
            differing.add(w[1])
    elif code in _NO_RESULT or len(w) < 2:
        return
    elif Op.ATOMIC_FIRST <= code <= Op.ATOMIC_LAST:
        differing.add(w[1])
    elif code == Op.VARIABLE:
        return
    else:
        if code in (Op.ACCESS_CHAIN, Op.IN_BOUNDS_CHAIN):
            bases[w[1]] = bases.get(w[2], w[2])
        if code == Op.PHI and uneven:
            differing.add(w[1])
        if any(word in differing for word in w[2:]) or bases.get(w[1]) in differing:
            differing.add(w[1])


def _private(module: Module, base: int) -> bool:
    """Whether a variable is an invocation's own; shared ones are the same for all."""
    held = module.variables.get(base)
    return held is None or held.kind == "value"


def _entered_unevenly(blocks: dict[int, list[_Block]], differing: set[int]) -> set[int]:
    found: set[int] = set()
    changed = True
    while changed:
        changed = False
        for number, parts in blocks.items():
            for block in parts:
                if number in found or (block.within | block.after) & differing:
                    called = {i.words[2] for i in block.body if i.code == Op.CALL} - found
                    changed |= bool(called)
                    found |= called
    return found
