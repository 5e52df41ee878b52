"""A compiled frame: prepared steps over owned objects. Executing allocates nothing and looks nothing up."""

from __future__ import annotations

import logging
from functools import partial
from time import perf_counter_ns
from typing import Any

from . import inspect
from .analysis import Analysis
from .backend import GraphBackend, PassTimers
from .binding import EVERY, State, Step, bind_passes, timed
from .errors import GraphError, did_you_mean
from .lifetimes import History, Key, Own
from .names import canonical
from .pass_io import Flag, Slot
from .report import PassReport, make_report
from .sizes import Size, ViewSizes, checked_size
from .storage import Storage, take_over
from .watching import Watching

log = logging.getLogger(__name__)


class Plan:
    """Made by `GraphBuilder.compile`. Not for use from several threads."""

    def __init__(self, backend: GraphBackend, size: Size, analysis: Analysis, previous: Plan | None = None) -> None:
        sizes = ViewSizes(checked_size(size), analysis.model.sizes, analysis.model.sized_by)
        self.backend = backend
        """What makes its objects."""
        self._analysis = analysis
        model, span = analysis.model, analysis.lifetimes.span
        lifetime = {name: model.specs[name].lifetime for name in span}
        self._state = State(
            slots={name: Slot(name, spec.lent) for name, spec in model.imports.items()},
            valid={name: Flag(False) for name in span if lifetime[name] == "history"},
            stale={name: Flag(True) for name in span if lifetime[name] == "persistent"},
        )
        self._parity = 0
        self._timers: PassTimers | None = None
        watch = backend.watch
        self.watching = None if watch is None else Watching(watch, analysis)
        """What passes do against what they declare, where the backend listens."""
        keep: dict[Key, object] = {}
        if previous is not None:
            keep = self._inherit(previous, sizes)
        storage = Storage(backend, analysis.lifetimes.spec, sizes, keep)
        try:
            self._install(sizes, storage)
        except BaseException:
            if previous is not None:
                previous._bind_again()
            raise
        if previous is not None:
            previous._retire(keep)

        count = len(analysis.culling.alive)
        at_end = EVERY if backend.barriers_everywhere else analysis.barriers.at_end
        self._at_end = partial(backend.barrier, at_end) if at_end else None
        self._required = [self._state.slots[name] for name in self._imports_in_use()]
        self._unsettled = True
        self._ran = [False] * count
        self._cpu_ns = [0] * count
        self._gpu_ms: list[float | None] = [None] * count
        self._not_run_why = "no frame has been executed yet"
        self._not_run_from = 0
        self._last_writers = self._find_last_writers()
        self._repeated = False
        self._released = False
        self.failed_system = ""
        """Whose pass raised in the last execute(); "" where none did."""

    # --- running -----------------------------------------------------------------------------------------------------

    def execute(self) -> None:
        """Run one frame.

        Raises GraphError when an import in use is not bound, and what a pass raises, with a note naming the pass. A
        frame that raised does not count: the next one runs on the same parity with the same history.
        """
        if self._released:
            self._check_usable()
        for slot in self._required:
            if slot.value is None:
                raise self._unbound(slot.name)
        ran = self._ran
        cpu_ns = self._cpu_ns
        clock = perf_counter_ns
        place = 0
        self.failed_system = ""
        self.backend.begin_frame()
        try:
            last = clock()
            for run, gate, barrier in self._running[self._parity]:
                if gate is None or gate():
                    if barrier is not None:
                        barrier()
                    run()
                    ran[place] = True
                else:
                    ran[place] = False
                now = clock()
                cpu_ns[place] = now - last
                last = now
                place += 1
            if self._at_end is not None:
                self._at_end()
        except BaseException as error:
            self._note_failure(place, error)
            raise
        finally:
            if self._timers is not None:
                self._timers.collect(self._gpu_ms)
            self.backend.end_frame()
        self._parity ^= 1
        self._repeated = False
        if self._unsettled:
            self._settle()

    def repeat(self) -> bool:
        """Write the host's imports once more from what the last frame left, run nothing else; False: that can't be.

        It can't after a frame that raised, before the first, after a resize or a change of what persists, and where a
        pass that writes one is followed by others, which may have used its inputs' memory.
        """
        first = self._last_writers
        if self._released or self._unsettled or first is None:
            return False
        for slot in self._required:
            if slot.value is None:
                raise self._unbound(slot.name)
        self._ran[:first] = [False] * first
        self._cpu_ns[:first] = [0] * first
        self.backend.begin_frame()
        place = first
        try:
            for run, _, barrier in self._running[1 - self._parity][first:]:  # those of the last frame
                started = perf_counter_ns()
                if barrier is not None:
                    barrier()
                run()
                self._ran[place] = True
                self._cpu_ns[place] = perf_counter_ns() - started
                place += 1
            if self._at_end is not None:
                self._at_end()
        except BaseException as error:
            self._note_failure(place, error)
            raise
        finally:
            self.backend.end_frame()
        self._repeated = True
        return True

    def _find_last_writers(self) -> int | None:
        """Where the passes that write the host's imports begin, if they are the last ones; None: others come after one
        of them. What a system lends stays as its passes left it."""
        model = self._analysis.model
        hosts = {name for name, spec in model.imports.items() if spec.lent is None}
        writes = [not hosts.isdisjoint(model.passes[i].writes) for i in self._analysis.culling.alive]
        first = writes.index(True) if True in writes else len(writes)
        return first if all(writes[first:]) else None

    def _note_failure(self, place: int, error: BaseException) -> None:
        model = self._analysis.model
        if place < len(self._ran):
            decl = model.passes[self._analysis.culling.alive[place]]
            self.failed_system = decl.system
            error.add_note(f"in pass {decl.name!r} (system {decl.system!r}) of the frame graph")
            for later in range(place, len(self._ran)):
                self._ran[later] = False
                self._cpu_ns[later] = 0
            # Its when() may have taken its "changed" mark down: what it was making has to be made in the next frame.
            for name in (*(spec.name for spec in decl.creates), *decl.writes):
                if name in self._state.stale:
                    self._state.stale[name].value = True
            self._not_run_from = place
            self._not_run_why = f"pass {decl.name!r} raised {type(error).__name__}"
        self._unsettled = True

    def _settle(self) -> None:
        """After the first complete frame: what was undefined has been written."""
        for flag in self._state.valid.values():
            flag.value = True
        for flag in self._state.stale.values():
            flag.value = False
        self._not_run_why = ""
        self._unsettled = False

    def invalidate_history(self, view: int | None = None) -> None:
        """Say that last frame's content means nothing (teleport, cut): history_valid is False for the next frame.

        view: of this view alone; None: of all, and of what they share.
        """
        model = self._analysis.model
        for name, flag in self._state.valid.items():
            if view is None or model.passes[model.creator[name]].scope.view == view:
                flag.value = False
        self._unsettled = True

    def invalidate_persistent(self) -> None:
        """Say that persistent content is outdated (a shader was reloaded): its passes run once whatever when() says."""
        for flag in self._state.stale.values():
            flag.value = True
        self._unsettled = True

    def bind_import(self, name: str, value: object) -> None:
        """Lend an object for an import, from the next execute on; None takes it away. May change every frame."""
        slot = self._state.slots.get(name) or self._state.slots.get(canonical(name))
        if slot is None:
            hint = did_you_mean(name, self._state.slots)
            raise GraphError(f"bind_import({name!r}): the graph has no such import.{hint}")
        slot.value = value

    # --- size and end ------------------------------------------------------------------------------------------------

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels of the views without a size of their own."""
        return self._sizes.plan

    def view_size(self, view: int) -> Size:
        """(w, h) of a view in pixels."""
        return self._sizes.of_view(view)

    def texels(self, resource: str) -> tuple[int, ...]:
        """(w, h) or (w, h, d) texels of a texture, (bytes,) of a buffer. Raises GraphError for an unknown one."""
        spec = self._analysis.model.specs.get(canonical(resource))
        if spec is None:
            raise self._not_there(resource)
        return self._sizes.resolve(spec)

    def resize(self, size: Size, view: int | None = None) -> None:
        """Make what is relative to the view anew and bind all passes again; the same size does nothing.

        view: one with a size of its own (`builder.scope(size=)`); None: all views that follow the plan. What has a
        fixed size keeps its content and its history. When this raises (too large, out of memory, a failing bind),
        nothing has changed.
        """
        self._check_usable()
        if view is not None and view not in self._sizes.own:
            raise GraphError(
                f"resize(view={view!r}): that view has no size of its own and follows the plan's; give it one with"
                f" builder.scope(view={view!r}, size=...), or resize without view=."
            )
        sizes = self._sizes.changed(checked_size(size), view)
        if sizes == self._sizes:
            return
        old = self._storage
        specs = self._analysis.lifetimes.spec
        keep = take_over(old, specs, self._sizes, specs, sizes)
        storage = Storage(self.backend, specs, sizes, keep)
        try:
            self._install(sizes, storage)
        except BaseException:
            self._bind_again()
            raise
        for key in storage.new:
            if isinstance(key, History):
                self._state.valid[key.name].value = False
            elif isinstance(key, Own):
                self._state.stale[key.name].value = True
        self._unsettled = True
        old.release(keep)

    def _install(self, sizes: ViewSizes, storage: Storage, keep_storage: bool = False) -> None:
        try:
            steps = bind_passes(self._analysis, self.backend, storage, self._state, sizes)
        except BaseException:
            if not keep_storage:
                storage.discard()
            raise
        self._storage = storage
        self._sizes = sizes
        if self.watching is not None:
            self.watching.install(storage, self._state.slots)
            steps = self.watching.steps(steps)
        self._steps: tuple[list[Step], list[Step]] = steps
        self._running = steps if self._timers is None else timed(steps, self._timers)

    def _bind_again(self) -> None:
        """After a failed attempt to replace this plan's objects: many a bind keeps what it looked up in its system, so
        let all look at the old objects again. What fails now has its old closure, which still works."""
        try:
            self._install(self._sizes, self._storage, keep_storage=True)
        except Exception:
            log.warning("a pass could not be bound again after a failure; its earlier binding stays", exc_info=True)

    def release(self) -> None:
        """Free all objects of the plan; again does nothing."""
        if not self._released:
            self._retire({})

    def _retire(self, keep: dict[Key, object]) -> None:
        self._released = True
        self.gpu_timing = False
        self._steps = self._running = ([], [])
        self._storage.release(keep)

    def _inherit(self, previous: Plan, sizes: ViewSizes) -> dict[Key, object]:
        """Objects of the plan that this one replaces, with what is known about their content."""
        previous._check_usable()
        if previous.backend is not self.backend:
            raise GraphError("compile(previous=): that plan belongs to another backend; pass a plan of the same one.")
        old, new = previous._analysis, self._analysis
        specs = new.lifetimes.spec
        keep = take_over(previous._storage, old.lifetimes.spec, previous._sizes, specs, sizes)
        self._parity = previous._parity
        for name, flag in self._state.valid.items():
            both = History(name, 0) in keep and History(name, 1) in keep
            flag.value = both and previous._state.valid[name].value
        for name, flag in self._state.stale.items():
            if Own(name) in keep and _creator(old, name) == _creator(new, name):
                flag.value = previous._state.stale[name].value
        for name, slot in self._state.slots.items():
            if slot.value is None and name in previous._state.slots:
                slot.value = previous._state.slots[name].value
        return keep

    # --- looking at it -----------------------------------------------------------------------------------------------

    def resource(self, name: str) -> Any:
        """The object that holds a resource's content after the last frame; the bound object of an import.

        An unexported transient may have been overwritten by a later one: export what you want to look at.
        """
        self._check_usable()
        name = canonical(name)
        if name in self._state.slots:
            return self._state.slots[name].value
        if name not in self._analysis.lifetimes.span:
            raise self._not_there(name)
        # execute() has moved the parity on, so the last frame's is the other one.
        return self._storage.objects[self._analysis.lifetimes.key(name, 1 - self._parity)]

    @property
    def resources(self) -> tuple[str, ...]:
        """Names of all resources that are allocated, in order of birth."""
        return tuple(self._analysis.lifetimes.span)

    @property
    def culled(self) -> dict[str, str]:
        """Passes that are not in the plan, and why."""
        return self._analysis.culled

    @property
    def analysis(self) -> Analysis:
        """The checked graph behind this plan."""
        return self._analysis

    @property
    def passes(self) -> list[PassReport]:
        """A report for each pass of the last frame in running order, then for the culled ones."""
        culling = self._analysis.culling
        bytes_of = self.bytes_of
        reports = [
            make_report(
                self._analysis,
                i,
                bytes_of,
                skipped_why=None if self._ran[place] else self._why_skipped(place),
                cpu_ms=self._cpu_ns[place] * 1e-6,
                gpu_ms=self._gpu_ms[place],
            )
            for place, i in enumerate(culling.alive)
        ]
        reports += [make_report(self._analysis, i, bytes_of, f"culled: {why}") for i, why in culling.why_culled.items()]
        return reports

    def _why_skipped(self, place: int) -> str:
        if self._not_run_why and place >= self._not_run_from:
            return self._not_run_why
        if self._repeated:
            return "nothing has changed: the last picture was shown again"
        i = self._analysis.culling.alive[place]
        only_while = self._analysis.model.passes[i].only_while
        skipped = i in self._analysis.together and only_while is not None and not only_while()
        return "its group's only_while() said no" if skipped else "its when() said no"

    def bytes_of(self, name: str) -> int:
        """Bytes that a resource occupies (both halves of a history); 0 when it is not allocated or imported."""
        name = canonical(name)
        if self._released or name not in self._analysis.lifetimes.span:
            return 0
        key = self._analysis.lifetimes.key
        return sum(self._storage.bytes_of(k) for k in {key(name, 0), key(name, 1)})

    def memory_bytes(self) -> int:
        """Bytes of all textures and buffers of the plan, each counted once."""
        return self._storage.memory_bytes()

    def explain(self, pass_name: str) -> str:
        """Why a pass runs or not, where in the order, what it touches and what that costs; several lines."""
        return inspect.explain(self._analysis, pass_name, self)

    def to_mermaid(self) -> str:
        """The graph as a mermaid flowchart: passes as boxes, resources on the arrows, culled passes dashed."""
        return self._analysis.to_mermaid()

    @property
    def gpu_timing(self) -> bool:
        """GPU times per pass; off by default, setting it makes or frees the queries."""
        return self._timers is not None

    @gpu_timing.setter
    def gpu_timing(self, on: bool) -> None:
        if on and self._timers is None:
            self._check_usable()
            self._timers = self.backend.create_timers(len(self._ran))
            self._running = timed(self._steps, self._timers)
        elif not on and self._timers is not None:
            self._running = self._steps
            self._timers.release()
            self._timers = None
            self._gpu_ms = [None] * len(self._ran)

    # --- errors ------------------------------------------------------------------------------------------------------

    def _check_usable(self) -> None:
        if self._released:
            raise GraphError("this plan was released; compile the graph again.")

    def _imports_in_use(self) -> list[str]:
        model = self._analysis.model
        used = {n for i in self._analysis.culling.alive for n in (*model.reads[i], *model.passes[i].writes)}
        return [name for name in model.imports if name in used]

    def _unbound(self, name: str) -> GraphError:
        model = self._analysis.model
        users = [
            repr(model.name(i))
            for i in self._analysis.culling.alive
            if name in model.reads[i] or name in model.passes[i].writes
        ]
        return GraphError(
            f"import {name!r} ({model.imports[name].kind}) is not bound, but pass {', '.join(users)} uses it; call"
            f" plan.bind_import({name!r}, ...) before execute()."
        )

    def _not_there(self, name: str) -> GraphError:
        if name in self._analysis.model.specs:
            creator = _creator(self._analysis, name)
            return GraphError(
                f"resource {name!r} is not allocated: pass {creator!r}, which creates it, is culled"
                f" ({self.culled[creator]}). Export {name!r} to keep it."
            )
        known = [*self._analysis.lifetimes.span, *self._state.slots]
        return GraphError(f"there is no resource {name!r}.{did_you_mean(name, known)}")


def _creator(analysis: Analysis, resource: str) -> str:
    return analysis.model.name(analysis.model.creator[resource])
