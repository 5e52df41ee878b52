"""Random graphs against an oracle that shares nothing with the engine.

A hidden program is invented first: a straight list of passes that create, modify and read resources. From it follow, by
plain bookkeeping, which version of everything each pass must see and which passes are needed. The declaration says only
what the rules ask for, in shuffled order. The passes then run on the null backend and keep contents by physical object,
so that a wrong order, a wrong version, shared memory that overlaps, a mixed-up parity or a missing barrier shows up.
Several programs with the same names, each in a view of its own, must not notice one another in one graph.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from planetfall.engine.graph import (
    STAGES,
    BarrierKind,
    BufferSpec,
    GraphBuilder,
    NullBackend,
    PassIO,
    Plan,
    TextureSpec,
    base_name,
    qualified,
)
from planetfall.engine.graph.barriers import open_hazards


@dataclass
class Step:
    """A pass of the hidden program."""

    name: str
    kind: str
    creates: list[str] = field(default_factory=list)
    reads: list[str] = field(default_factory=list)
    writes: list[str] = field(default_factory=list)
    history: list[str] = field(default_factory=list)
    after: set[str] = field(default_factory=set)
    unsaid: set[str] = field(default_factory=set)  # of `after`, what the stages say
    stage: str = ""
    gated: bool = False
    side_effect: bool = False
    sees: dict[str, tuple[str, ...]] = field(default_factory=dict)  # resource -> makers so far, its own place excluded


class Program:
    """A random hidden program, and what follows from it."""

    def __init__(self, rng: random.Random) -> None:
        self.specs: dict[str, TextureSpec | BufferSpec] = {}
        self.makers: dict[str, list[str]] = {}
        self.steps: list[Step] = []
        readers: dict[str, list[str]] = {}  # of the newest version
        for n in range(rng.randint(1, 12)):
            step = Step(f"p{n}", rng.choice(["raster", "raster", "compute", "copy"]))
            step.side_effect = rng.random() < 0.1
            known = list(self.makers)
            rng.shuffle(known)
            for name in known[: rng.randint(0, 3)]:
                if rng.random() < 0.3 and not (step.gated and self.specs[name].lifetime == "transient"):
                    step.writes.append(name)
                else:
                    step.reads.append(name)
            for name in (*step.reads, *step.writes):
                step.sees[name] = tuple(self.makers[name])
            step.gated = rng.random() < 0.2 and not step.writes
            for k in range(rng.randint(0 if step.writes else 1, 2)):
                self._create(rng, step, f"r{n}_{k}")
            # What the rules ask of a writer: to stand behind the writer before it and the readers of that version.
            for name in step.writes:
                step.after |= {self.makers[name][-1], *readers[name]}
                self.makers[name].append(step.name)
                readers[name] = []
            for name in step.reads:
                readers[name].append(step.name)
            for name in step.creates:
                self.makers[name] = [step.name]
                readers[name] = []
            self.steps.append(step)
        for step in self.steps:
            for name, spec in self.specs.items():
                if spec.lifetime == "history" and rng.random() < 0.3:
                    step.history.append(name)
        self._stage(rng)
        self.exports = rng.sample(list(self.specs), k=min(len(self.specs), rng.randint(1, 2)))
        self.by_name = {step.name: step for step in self.steps}

    def _stage(self, rng: random.Random) -> None:
        """Some writers stand in stages, which never go back along the program; then the writer before, if of an earlier
        stage, or the creator need not be named, unless it also reads what is written here."""
        rank, place = 0, {step.name: step for step in self.steps}
        for step in self.steps:
            if not step.writes or rng.random() < 0.4:
                continue
            rank = min(rank + rng.choice([0, 0, 1, 2]), len(STAGES) - 1)
            step.stage = STAGES[rank]
            firm: set[str] = set()
            for name in step.writes:
                *_, last = step.sees[name]
                before = place[last].stage
                by_stage = last == self.makers[name][0] or before not in ("", step.stage)
                (step.unsaid if by_stage else firm).add(last)
            for other in self.steps:
                if set(other.reads) & set(step.writes):
                    firm.add(other.name)
            step.unsaid -= firm

    def _create(self, rng: random.Random, step: Step, name: str) -> None:
        lifetime = "persistent" if step.gated else rng.choice(["transient", "transient", "persistent", "history"])
        if rng.random() < 0.3:
            self.specs[name] = BufferSpec(name, rng.choice([16, 32]), lifetime)  # type: ignore[arg-type]
        else:
            size = rng.choice([1.0, 0.5, (8, 8)])
            self.specs[name] = TextureSpec(name, "rgba8", size, lifetime)  # type: ignore[arg-type]
        step.creates.append(name)

    def needed(self) -> set[str]:
        """Walk back over versions."""
        todo = [s.name for s in self.steps if s.side_effect]
        todo += [maker for name in self.exports for maker in self.makers[name]]
        done: set[str] = set()
        while todo:
            name = todo.pop()
            if name not in done:
                done.add(name)
                step = self.by_name[name]
                todo += [maker for makers in step.sees.values() for maker in makers]
                todo += [maker for old in step.history for maker in self.makers[old]]
        return done


class Stage:
    """What the programs of one graph have in common: contents by physical object, and what touched them in order."""

    def __init__(self) -> None:
        self.content: dict[int, tuple[str, int, tuple[str, ...]]] = {}  # object -> (resource, frame made, makers)
        self.events: list[tuple[str, Any, bool]] = []
        self.backend = NullBackend()
        record = self.backend.barrier
        self.backend.barrier = lambda kinds: (record(kinds), self.events.append(("barrier", kinds, False)))[0]  # type: ignore

    def forget_released(self) -> None:
        """An address may come again."""
        live = {id(obj) for obj in self.backend.live}
        self.content = {key: value for key, value in self.content.items() if key in live}


class World:
    """Runs a program of one view on the null backend and checks every access."""

    def __init__(self, program: Program, rng: random.Random, stage: Stage, view: int = 0) -> None:
        self.program = program
        self.rng = rng
        self.stage = stage
        self.view = view
        self.alive = program.needed()
        self.valid_since: dict[str, int] = {}
        self.frame = 0
        self.ran: list[str] = []
        self.plan: Plan
        self.plan_size: tuple[int, int]

    def full(self, name: str) -> str:
        return qualified(name, self.view, None)

    def declare(self, builder: GraphBuilder, step: Step) -> None:
        builder.add_pass(
            step.name,
            bind=self.bind,
            creates=tuple(self.program.specs[n] for n in step.creates),
            reads=step.reads,
            writes=step.writes,
            after=step.after - step.unsaid,
            stage=step.stage,
            history=step.history,
            when=(lambda: self.rng.random() < 0.5) if step.gated else None,
            side_effect=step.side_effect,
            kind=step.kind,  # type: ignore[arg-type]
        )

    def bind(self, io: PassIO) -> Callable[[], None]:
        step = self.program.by_name[base_name(io.pass_name)]
        assert io.pass_name == self.full(step.name) and io.size == self.plan_size

        def find(name: str) -> Any:
            return io.texture(name) if isinstance(self.program.specs[name], TextureSpec) else io.buffer(name)

        found = {name: find(name) for name in (*step.creates, *step.reads, *step.writes)}
        old = {name: (io.history(name), io.history_valid_for(name)) for name in step.history}
        for name, obj in found.items():
            assert not obj.released
            if isinstance(spec := self.program.specs[name], TextureSpec):
                assert obj.size == spec.resolve(self.plan_size)

        def run() -> None:
            self.ran.append(step.name)
            for name, makers in step.sees.items():
                self.check(found[name], name, makers)
            for name, (obj, flag) in old.items():
                assert flag.value == (self.frame > self.valid_since.get(name, 0))
                if flag.value:
                    makers = tuple(m for m in self.program.makers[name])
                    assert self.stage.content[id(obj)] == (self.full(name), self.frame - 1, makers)
            for name in step.reads:
                self.stage.events.append(("touch", found[name], False))
            for name in old:
                self.stage.events.append(("touch", old[name][0], False))
            for name in (*step.creates, *step.writes):
                self.stage.events.append(("touch", found[name], step.kind == "compute"))
                self.stage.content[id(found[name])] = (
                    self.full(name),
                    self.frame,
                    (*step.sees.get(name, ()), step.name),
                )

        return run

    def check(self, obj: Any, name: str, makers: tuple[str, ...]) -> None:
        creator = self.program.by_name[self.program.makers[name][0]]
        seen_name, seen_frame, seen_makers = self.stage.content[id(obj)]
        assert (seen_name, seen_makers[: len(makers)]) == (self.full(name), makers)
        if not creator.gated:
            assert (seen_frame, seen_makers) == (self.frame, makers)

    def check_frame(self) -> None:
        """After an execute: what ran, and what is exported."""
        may_skip = {s.name for s in self.program.steps if s.gated}
        assert set(self.ran) <= self.alive
        assert self.alive - set(self.ran) <= may_skip
        for name in self.program.exports:
            makers = tuple(self.program.makers[name])
            obj = self.plan.resource(self.full(name))
            if not self.program.by_name[makers[0]].gated:
                assert self.stage.content[id(obj)] == (self.full(name), self.frame, makers)
            self.stage.events.append(("touch", obj, False))
        self.frame += 1
        self.ran.clear()

    def resized(self) -> None:
        """After this view's size has changed."""
        for name, spec in self.program.specs.items():
            if spec.relative:
                self.valid_since[name] = self.frame


def check_barriers(events: list[tuple[str, Any, bool]]) -> None:
    """A barrier lies between a compute store and any later access, and between any access and a later such store."""
    stored: dict[int, Any] = {}
    accessed: dict[int, Any] = {}
    for what, subject, compute_write in events:
        if what == "barrier":
            kinds = BarrierKind(subject)
            for objects in (stored, accessed):
                for key, obj in list(objects.items()):
                    kind = BarrierKind.BUFFER if hasattr(obj, "size_bytes") else BarrierKind.TEXTURE
                    if kind & kinds:
                        del objects[key]
            continue
        assert id(subject) not in stored
        assert not (compute_write and id(subject) in accessed)
        accessed[id(subject)] = subject
        if compute_write:
            stored[id(subject)] = subject


SIZES = [(64, 32), (32, 64), (7, 5)]


def check(
    rng: random.Random, worlds: list[World], builders: list[GraphBuilder], own: dict[int, tuple[int, int]]
) -> Plan:
    """Declare all programs in one shuffled order, compile, check the plan, run frames and resize. own: views' sizes."""
    stage = worlds[0].stage
    declared = [
        (world, builder, step) for world, builder in zip(worlds, builders, strict=True) for step in world.program.steps
    ]
    rng.shuffle(declared)
    for world, builder, step in declared:
        world.declare(builder, step)
    for world, builder in zip(worlds, builders, strict=True):
        world.plan_size = own.get(world.view, SIZES[0])
        for name in world.program.exports:
            builder.export(name)
    plan = builders[0].compile(stage.backend, SIZES[0])

    order = plan.analysis.alive
    assert set(order) == {world.full(name) for world in worlds for name in world.alive}
    assert set(plan.culled) == {world.full(n) for world in worlds for n in set(world.program.by_name) - world.alive}
    for world in worlds:
        world.plan = plan
        for name in world.alive:
            for earlier in world.program.by_name[name].after & world.alive:
                assert order.index(world.full(earlier)) < order.index(world.full(name))
    assert set(plan.resources) == {
        world.full(name) for world in worlds for s in world.program.steps if s.name in world.alive for name in s.creates
    }
    objects = {id(obj): obj for obj in stage.backend.live if hasattr(obj, "bytes")}
    assert plan.memory_bytes() == sum(obj.bytes for obj in objects.values())

    for _ in range(6):
        for _ in range(rng.randint(1, 3)):
            plan.execute()
            for world in worlds:
                world.check_frame()
        view = rng.choice([None, *own])
        size = rng.choice(SIZES)
        resized = [w for w in worlds if w.plan_size != size and (w.view == view if view in own else w.view not in own)]
        for world in resized:
            world.plan_size = size
            world.resized()
        plan.resize(size, view)
        stage.forget_released()
    check_barriers(stage.events)
    assert plan.explain(order[0])
    assert plan.to_mermaid().startswith("flowchart LR\n")
    plan.release()
    assert not stage.backend.live
    return plan


@settings(max_examples=150)
@given(st.integers(0, 2**32))
def test_random_graphs(seed: int) -> None:
    rng = random.Random(seed)
    check(rng, [World(Program(rng), rng, Stage())], [GraphBuilder()], {})


@settings(max_examples=100)
@given(st.integers(0, 2**32))
def test_random_graphs_of_several_views(seed: int) -> None:
    rng = random.Random(seed)
    stage, builder = Stage(), GraphBuilder()
    worlds = [World(Program(rng), rng, stage, view) for view in range(rng.randint(2, 3))]
    own = {world.view: rng.choice(SIZES) for world in worlds if rng.random() < 0.5}
    check(rng, worlds, [builder.scope(view=w.view, size=own.get(w.view)) for w in worlds], own)


@settings(max_examples=60)
@given(st.integers(0, 2**32))
@example(248)  # a compute pass that stores into what it also reads of the frame before
def test_a_barrier_that_is_taken_out_is_found_by_the_hazards_and_by_the_run(seed: int) -> None:
    rng = random.Random(seed)
    program, stage = Program(rng), Stage()
    for step in program.steps:
        step.gated = False  # a pass that is skipped may hide the hazard
    world, builder = World(program, rng, stage), GraphBuilder()
    world.plan_size = SIZES[0]
    for step in program.steps:
        world.declare(builder, step)
    for name in program.exports:
        builder.export(name)
    found = builder.analyse()
    whole, parts = found.barriers, (found.model, found.culling, found.lifetimes)
    assert open_hazards(*parts, whole) == []
    places = [place for place, kinds in enumerate(whole.before) if kinds]
    if not places:
        return
    taken = rng.choice(places)
    lacking = replace(whole, before=[0 if place == taken else kinds for place, kinds in enumerate(whole.before)])
    assert open_hazards(*parts, lacking), "none is placed in vain"

    world.plan = plan = builder.compile(stage.backend, SIZES[0])
    steps = plan._running
    for half in steps:
        run, gate, _ = half[taken]
        half[taken] = (run, gate, None)
    for _ in range(4):
        plan.execute()
        world.check_frame()
    with pytest.raises(AssertionError):
        check_barriers(stage.events)
    plan.release()
