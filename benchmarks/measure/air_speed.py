"""Run time of the air: its tables, its passes in a frame, and what it adds to shading; first pictures; skipping.

Next to the wall clock stands the time of all processors together (`cpu_ms`): on a software renderer a pass cannot take
less than that divided by the processors, and other programs hardly change it.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ... import Camera, Renderer
from ...engine.blocks.bindings import AIR_BLOCK
from ...engine.gpu import Gpu, GpuScope
from ...quality import resolve_quality
from ...systems.atmosphere.block import AirBlock, air_block
from ...systems.atmosphere.model import AirModel
from ...systems.atmosphere.paper import PaperTables
from ...systems.atmosphere.sizes import paper_sizes, table_sizes
from ...systems.atmosphere.tables import QUICK, AirTables, TableSizes
from ..timing import Timing

AIR_PASSES = ("atmosphere.tables", "atmosphere.view", "sky.shade")
_SLICE = 1 << 21


@dataclass(frozen=True)
class Cost:
    """What a piece of work took: wall clock, and all processors together."""

    wall: Timing
    cpu_ms: float


def cost_of(samples: Sequence[tuple[float, float]]) -> Cost:
    """From (wall ms, processor ms) of each run."""
    return Cost(Timing.of([wall for wall, _ in samples]), float(np.median([cpu for _, cpu in samples])))


class CostTimers:
    """Timers for a frame graph that wait for each pass to end and read both clocks; see frames.FinishTimers."""

    def __init__(self, ctx: moderngl.Context, count: int) -> None:
        self._ctx = ctx
        self._began = [(0.0, 0.0)] * count
        self.costs: list[tuple[float, float] | None] = [None] * count

    def begin(self, slot: int) -> None:
        """Start of a pass."""
        self._ctx.finish()
        self._began[slot] = time.perf_counter(), time.process_time()

    def end(self, slot: int) -> None:
        """End of a pass."""
        self._ctx.finish()
        wall, cpu = self._began[slot]
        self.costs[slot] = 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - cpu)

    def collect(self, out: list[float | None]) -> None:
        """End of a frame."""
        out[:] = [None if cost is None else cost[0] for cost in self.costs]

    def release(self) -> None:
        """Nothing to free."""


class _Clocked:
    """A renderer each of whose passes is waited for, drawing into a framebuffer of its own."""

    def __init__(self, renderer: Renderer) -> None:
        self.renderer = renderer
        renderer.ctx.__enter__()
        self._target = renderer.ctx.simple_framebuffer(renderer.size)
        self._backend: Any = renderer.own.backend
        self._kept = self._backend.create_timers
        self._timers: CostTimers | None = None
        self._backend.create_timers = self._create

    def _create(self, count: int) -> CostTimers:
        self._timers = CostTimers(self.renderer.ctx, count)
        return self._timers

    def frame(self, camera: Camera) -> dict[str, tuple[float, float]]:
        """(wall ms, processor ms) by pass; "": of the whole frame."""
        ctx = self.renderer.ctx
        ctx.__enter__()
        ctx.finish()
        wall, cpu = time.perf_counter(), time.process_time()
        self.renderer.render_to(self._target, camera)
        ctx.finish()
        costs = {"": (1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - cpu))}
        assert self._timers is not None
        for report, cost in zip(self.renderer.passes(), self._timers.costs, strict=False):  # then come culled passes
            if cost is not None:
                costs[report.name] = cost
        self._timers.costs = [None] * len(self._timers.costs)
        return costs

    def settle(self, camera: Camera) -> None:
        """As Renderer.settle; then a frame into the target, whose graph is another, and which gets the timers."""
        self.renderer.settle(camera)
        self.renderer.render_to(self._target, camera)
        self.renderer.graph.gpu_timing = True

    def release(self) -> None:
        """Give the renderer back as it was."""
        self.renderer.ctx.__enter__()
        self.renderer.graph.gpu_timing = False
        self._backend.create_timers = self._kept
        self.renderer.gpu.leave(self._target)
        self._target.release()


def time_passes(
    renderers: Mapping[str, Renderer], views: Mapping[str, Sequence[Camera]], runs: int
) -> dict[tuple[str, str], dict[str, Cost]]:
    """By renderer and view: cost of each pass, "" of the whole frame. Renderers take turns, frame by frame; each frame
    of a view takes the next of its cameras."""
    clocked = {name: _Clocked(renderer) for name, renderer in renderers.items()}
    samples: dict[tuple[str, str], dict[str, list[tuple[float, float]]]] = {}
    names = list(clocked)
    try:
        for view, cameras in views.items():
            for turn in range(-2, runs):
                shift = turn % len(names)
                for name in names[shift:] + names[:shift]:
                    if turn == -2:
                        clocked[name].settle(cameras[0])
                    costs = clocked[name].frame(cameras[turn % len(cameras)])
                    if turn >= 0:
                        kinds = samples.setdefault((name, view), {})
                        for what, cost in costs.items():
                            kinds.setdefault(what, []).append(cost)
    finally:
        for each in clocked.values():
            each.release()
    return {key: {what: cost_of(found) for what, found in kinds.items()} for key, kinds in samples.items()}


def total(costs: Mapping[str, Cost], names: Sequence[str]) -> Cost:
    """The sum of some passes' medians; those that did not run are free."""
    chosen = [costs[name] for name in names if name in costs]
    wall = Timing(
        sum(c.wall.ms for c in chosen),
        sum(c.wall.low_ms for c in chosen),
        sum(c.wall.high_ms for c in chosen),
        min((c.wall.runs for c in chosen), default=0),
    )
    return Cost(wall, sum(c.cpu_ms for c in chosen))


# -- tables -----------------------------------------------------------------------------------------------------------


def time_tables(gpu: Gpu, scene: Any, quality: str, overrides: Mapping[str, Any] | None = None) -> dict[str, Cost]:
    """Cost of computing the tables of a quality, by table and in all ("total"); shaders are compiled before."""
    settings = resolve_quality(quality, overrides)
    with probe_scope(gpu, scene) as scope:
        if settings.get("atmosphere.method") == "paper":
            return _paper_stages(gpu, PaperTables(scope, paper_sizes(settings)))
        return _stages(gpu, AirTables(scope, table_sizes(settings)))


def time_quick_tables(gpu: Gpu, scene: Any, quality: str) -> Cost:
    """The small tables that a first picture and a live change show."""
    degree = table_sizes(resolve_quality(quality)).degree
    with probe_scope(gpu, scene) as scope:
        return _stages(gpu, AirTables(scope, TableSizes(**{**vars(QUICK), "degree": degree})))["total"]


@contextmanager
def probe_scope(gpu: Gpu, scene: Any) -> Iterator[GpuScope]:
    from ... import Atmosphere, Planet

    class _Dark:
        night_light = 0.0

    handle = scene.planet
    model = AirModel.from_components(handle[Planet], handle[Atmosphere], scene.sun.angular_radius_rad)
    scope = gpu.scope("bench")
    try:
        block = scope.uniform_block(AirBlock, AIR_BLOCK, "air_model")
        block.write(air_block(model, _Dark()))
        block.bind()
        yield scope
    finally:
        scope.release()


def _stages(gpu: Gpu, tables: AirTables) -> dict[str, Cost]:
    """Depth first; then orders, each ended by a step that looks at no points of air."""
    _run(gpu, tables)
    tables.restart()
    stage = "optical depth"
    spent: dict[str, tuple[float, float]] = {}
    while not tables.done:
        share, cost = tables.share, _step(gpu, tables)
        spent[stage] = tuple(np.add(spent.get(stage, (0.0, 0.0)), cost))
        if stage == "optical depth":
            stage = "first order"
        elif stage == "first order" and tables.share == share:
            stage = "later orders"
    return _with_total(spent)


def _paper_stages(gpu: Gpu, tables: PaperTables) -> dict[str, Cost]:
    _run(gpu, tables)
    tables.restart()
    spent: dict[str, tuple[float, float]] = {}
    while not tables.done:
        stage = tables.stage.removesuffix(" first")
        spent[stage] = tuple(np.add(spent.get(stage, (0.0, 0.0)), _step(gpu, tables)))
    return _with_total(spent)


def _run(gpu: Gpu, tables: AirTables | PaperTables) -> None:
    while not tables.done:
        tables.step(_SLICE)
    gpu.ctx.finish()


def _step(gpu: Gpu, tables: AirTables | PaperTables) -> tuple[float, float]:
    gpu.ctx.finish()
    wall, cpu = time.perf_counter(), time.process_time()
    tables.step(_SLICE)
    gpu.ctx.finish()
    return 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - cpu)


def _with_total(spent: Mapping[str, tuple[float, float]]) -> dict[str, Cost]:
    found = {stage: cost_of([cost]) for stage, cost in spent.items()}
    return {**found, "total": cost_of([tuple(np.sum(list(spent.values()), axis=0))])}


# -- first pictures, and frames in which nothing is to be done ---------------------------------------------------------


@dataclass(frozen=True)
class Start:
    """Milliseconds of a renderer that shows an air for the first time."""

    first_picture_ms: float
    """Making the renderer and its first picture, with the small tables."""
    final_ms: float
    """From then until the final tables are shown."""
    cached_ms: float
    """Making another renderer and its first picture, with the final tables from disk."""


def time_start(scene: Any, size: tuple[int, int], quality: str, camera: Camera) -> Start:
    """In an empty cache folder; shaders may be in the driver's own cache."""
    with tempfile.TemporaryDirectory() as folder, _environment("PLANETFALL_CACHE", folder):
        started = time.perf_counter()
        renderer = Renderer(scene, size, quality)
        try:
            renderer.render(camera)
            first = time.perf_counter()
            renderer.settle(camera)
            final = time.perf_counter()
        finally:
            renderer.release()
        again = time.perf_counter()
        renderer = Renderer(scene, size, quality)
        try:
            renderer.render(camera)
            cached = time.perf_counter() - again
            if not all(system.settled(renderer.views[0]) for system in renderer.systems if system.name == "atmosphere"):
                raise RuntimeError("the second renderer didn't find the tables on disk")
        finally:
            renderer.release()
    return Start(1e3 * (first - started), 1e3 * (final - first), 1e3 * cached)


@contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


def air_passes_run(renderer: Renderer, camera: Camera) -> list[str]:
    """The air's passes that run in the second of two equal frames."""
    renderer.settle(camera)
    renderer.render(camera)
    renderer.render(camera)
    return [p.name for p in renderer.passes() if p.ran and p.name.startswith("atmosphere.")]


def sky_fragments(renderer: Renderer, camera: Camera) -> int:
    """How many fragments the pass sky.shade draws in a frame."""
    renderer.render(camera)
    return _SampleTimers(renderer, renderer.ctx.query(samples=True)).count(camera)


class _SampleTimers:
    """Counts the samples of one pass, from where its timer would begin to where it would end."""

    def __init__(self, renderer: Renderer, query: moderngl.Query) -> None:
        self._renderer, self._query = renderer, query
        self._place = [p.name for p in renderer.passes()].index("sky.shade")
        self._samples = 0

    def count(self, camera: Camera) -> int:
        """Samples that passed in one frame."""
        backend: Any = self._renderer.own.backend
        kept, backend.create_timers = backend.create_timers, lambda count: self
        try:
            self._renderer.graph.gpu_timing = True
            self._renderer.render(camera)
            self._renderer.graph.gpu_timing = False
        finally:
            backend.create_timers = kept
        return self._samples

    def begin(self, slot: int) -> None:
        """Start of a pass."""
        if slot == self._place:
            self._query.__enter__()

    def end(self, slot: int) -> None:
        """End of a pass."""
        if slot == self._place:
            self._query.__exit__()
            self._samples = int(self._query.samples)

    def collect(self, out: list[float | None]) -> None:
        """End of a frame."""

    def release(self) -> None:
        """Nothing to free: the query goes with the context."""
