"""Turns the declared passes into prepared steps: look-ups done, gates and barriers in place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from .analysis import Analysis
from .backend import BarrierKind, GraphBackend, PassTimers
from .declaration import PassDecl, Run
from .errors import GraphError
from .names import base_name
from .pass_io import Flag, PassIO, ResourceTable, Slot
from .sizes import ViewSizes
from .storage import Storage

EVERY = int(BarrierKind.TEXTURE | BarrierKind.BUFFER)
"""A barrier for all that is stored."""
Step = tuple[Run, Callable[[], object] | None, Callable[[], object] | None]
"""(run, gate, barrier): gate None: always; barrier None: none."""


@dataclass(slots=True)
class State:
    """What outlives a resize: import slots, validity of history, staleness of persistent content."""

    slots: dict[str, Slot]
    valid: dict[str, Flag]
    stale: dict[str, Flag]


def make_table(analysis: Analysis, storage: Storage, state: State, sizes: ViewSizes, parity: int) -> ResourceTable:
    """The objects of all living resources in frames of one parity."""
    key = analysis.lifetimes.key
    names = analysis.lifetimes.span
    return ResourceTable(
        names=analysis.model.names,
        sizes=sizes,
        parity=parity,
        specs=analysis.model.specs,
        imports=analysis.model.imports,
        slots=state.slots,
        current={name: storage.objects[key(name, parity)] for name in names},
        last_frame={name: storage.objects[key(name, 1 - parity)] for name in state.valid},
        valid=state.valid,
        readers=_readers(analysis),
        framebuffer=storage.framebuffer,
    )


def _readers(analysis: Analysis) -> dict[str, frozenset[str]]:
    model, alive = analysis.model, set(analysis.culling.alive)
    exported = {name: {""} for name in model.exports}
    return {
        name: frozenset({base_name(model.name(i)) for i in indices if i in alive} | exported.get(name, set()))
        for name, indices in model.readers.items()
    }


def bind_passes(
    analysis: Analysis, backend: GraphBackend, storage: Storage, state: State, sizes: ViewSizes
) -> tuple[list[Step], list[Step]]:
    """The steps of even and odd frames. A pass that touches no history resource is bound once for both.

    Raises what a bind raises, with a note that names the pass.
    """
    tables = tuple(make_table(analysis, storage, state, sizes, parity) for parity in (0, 1))
    steps: tuple[list[Step], list[Step]] = ([], [])
    for place, i in enumerate(analysis.culling.alive):
        decl = analysis.model.passes[i]
        gate = _gate(decl, state, i in analysis.together)
        kinds = EVERY if backend.barriers_everywhere else analysis.barriers.before[place]
        barrier = partial(backend.barrier, kinds) if kinds else None
        run = _bind(decl, tables[0])
        steps[0].append((run, gate, barrier))
        if _touches_history(analysis, i):
            run = _bind(decl, tables[1])
        steps[1].append((run, gate, barrier))
    return steps


def _bind(decl: PassDecl, table: ResourceTable) -> Run:
    try:
        run = decl.bind(PassIO(decl, table))
        if not callable(run):
            raise GraphError(
                f"bind of pass {decl.name!r} returned {run!r}; it must return the function that runs each frame."
            )
    except BaseException as error:
        error.add_note(f"while binding pass {decl.name!r} (system {decl.system!r}) of the frame graph")
        raise
    return run


def _touches_history(analysis: Analysis, i: int) -> bool:
    decl = analysis.model.passes[i]
    specs = analysis.model.specs
    touched = [*decl.creates, *(specs[n] for n in (*analysis.model.reads[i], *decl.writes) if n in specs)]
    return bool(decl.history) or any(spec.lifetime == "history" for spec in touched)


def _gate(decl: PassDecl, state: State, together: bool) -> Callable[[], object] | None:
    """when(), and only_while() before it, overruled while persistent content that the pass makes is new and therefore
    undefined. together: whether only_while() is asked."""
    when = decl.when
    if together and decl.only_while is not None:
        when = decl.only_while if when is None else _both(decl.only_while, when)
    if when is None:
        return None
    names = [*(spec.name for spec in decl.creates), *decl.writes]
    stale = [state.stale[name] for name in names if name in state.stale]
    if not stale:
        return when
    if len(stale) == 1:
        flag = stale[0]
        return lambda: _wanted(when) or flag.value
    return lambda: _wanted(when) or any(flag.value for flag in stale)


def _both(first: Callable[[], object], second: Callable[[], object]) -> Callable[[], object]:
    return lambda: first() and second()


def _wanted(when: Callable[[], object]) -> bool:
    # Asked in any case, and first: many a when() takes a "changed" mark down as it answers.
    return bool(when())


def timed(steps: tuple[list[Step], list[Step]], timers: PassTimers) -> tuple[list[Step], list[Step]]:
    """The same steps with each run between its GPU timer's marks."""

    def wrap(place: int, run: Run) -> Run:
        begin, end = timers.begin, timers.end

        def run_timed() -> None:
            begin(place)
            run()
            end(place)

        return run_timed

    even, odd = ([(wrap(i, run), gate, barrier) for i, (run, gate, barrier) in enumerate(half)] for half in steps)
    return even, odd
