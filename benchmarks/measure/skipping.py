"""What a scene doesn't need: passes, calls and GL objects of scenes that lack something, beside the full scene's."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ... import Atmosphere, Camera, Clouds, Ocean, Planet, Renderer, Scene, Sun, Terrain, view
from ..child import answer_of
from ..scenes import preset_scene
from ..timing import Timing, time_variants
from .motion import turned

__all__ = [
    "BARE",
    "FULL",
    "LIGHT_SYSTEMS",
    "SKY_STAGES",
    "STAGES",
    "Case",
    "Counts",
    "Paired",
    "RunningCase",
    "counts",
    "imports_of",
    "pass_times",
    "planet_systems",
    "running_case",
    "timed_together",
    "update_times",
]

REST_FRAMES = 200
TURN_DEG = 0.01
_FRAME_S = 1.0 / 60.0
LIGHT_SYSTEMS = ("proxy", "light", "gbuffer", "terrain", "shadows", "sky", "stars", "composite")
"""Terrain, light and composite: all that a world without sea, air and clouds has."""


@dataclass(frozen=True)
class Case:
    """A scene and a view that need less than everything."""

    name: str
    planet: str = "earth"
    view: str = "near"
    without: tuple[type, ...] = ()
    """Components of the planet that are taken away."""
    knobs: Mapping[type, Mapping[str, str]] = field(default_factory=dict)
    """Of components of the planet, where they are not its own."""
    camera: Callable[[Scene, int], Camera] | None = None
    """From the scene and the picture's rows; None: the view's own."""
    sun_elevation_deg: float | None = None
    """Over the view's place; None: the view's own sun."""
    paused: bool = False
    """The camera stands still and time does not pass."""
    runs: bool = False
    """Time passes, a frame of _FRAME_S after the other."""


def _pixel(rows: int) -> float:
    """Tangent of a pixel's angle in the middle of a picture of 60 degrees."""
    return 2.0 * math.tan(math.radians(30.0)) / rows


def _behind(scene: Scene, rows: int) -> Camera:
    """From 2000 km, looking straight up."""
    state = view("orbit", scene.planet).resolve(scene, 16.0 / 9.0)
    up = state.position_m / np.linalg.norm(state.position_m)
    return Camera(state.position_m, up, state.up)


def _from_afar(distance_radii: Callable[[int], float]) -> Callable[[Scene, int], Camera]:
    def camera(scene: Scene, rows: int) -> Camera:
        state = view("space", scene.planet).resolve(scene, 16.0 / 9.0)
        up = state.position_m / np.linalg.norm(state.position_m)
        return Camera(up * (scene.planet.radius_m * distance_radii(rows)), -up, state.up)

    return camera


def _looking_up(altitude_m: float, above: str, pitch_deg: float) -> Callable[[Scene, int], Camera]:
    return lambda _scene, _rows: Camera.at(45.0, 10.0, altitude_m, pitch_deg=pitch_deg, above=above)


FULL = Case("full scene")
BARE = Case(
    "planet without anything, behind the camera",
    view="orbit",
    without=(Terrain, Ocean, Atmosphere, Clouds),
    camera=_behind,
)
STAGES = (
    Case("airless moon", planet="moon"),
    Case("earth without sea, air and clouds", without=(Ocean, Atmosphere, Clouds)),
    Case("dry world", without=(Ocean,)),
    Case("cloudless", without=(Clouds,)),
    Case("paused, still camera", paused=True),
    Case("planet behind the camera", view="orbit", camera=_behind),
    Case("planet of 3 px", camera=_from_afar(lambda rows: 2.0 / (3.0 * _pixel(rows)))),
    Case("night side", sun_elevation_deg=-40.0),
    Case("under water", view="under"),
    Case("deep space", camera=_from_afar(lambda rows: 20.0 / _pixel(rows))),
)
"""The full scene and BARE are what these are measured against."""
_TILED = {Terrain: {"backend": "quadtree"}}
_PRINTED = {Terrain: {"method": "paper"}, Ocean: {"method": "paper_2019"}}
SKY_STAGES = (
    Case("sky alone, 100 m up", camera=_looking_up(100.0, "ground", 90.0), runs=True),
    Case("sky alone, 20 km up", camera=_looking_up(2e4, "sphere", 86.0), runs=True),
    Case("sky alone, 400 km up", camera=_looking_up(4e5, "sphere", 60.0), runs=True),
    Case("sky alone, tiled ground", knobs=_TILED, camera=_looking_up(100.0, "ground", 90.0), runs=True),
    Case("sky alone, printed ground and sea", knobs=_PRINTED, camera=_looking_up(2e4, "sphere", 86.0), runs=True),
)
"""Air is in the picture, ground and sea are not."""


@dataclass(frozen=True)
class Counts:
    """One frame of a case, after what is made once has been made."""

    ran: Mapping[str, str]
    """Passes, and the system of each."""
    skipped: int
    """Passes that are in the plan and did not run, or were culled."""
    draws: int
    dispatches: int
    uploads: int
    programs_built: int
    objects: Mapping[str, int]
    """Live GL objects by owner: a system, or the graph."""
    programs: int
    """Linked GL programs alive."""
    systems: tuple[str, ...]

    @property
    def gl_objects(self) -> int:
        return sum(self.objects.values())


@dataclass(frozen=True)
class RunningCase:
    """A renderer with a case's scene, and one of its frames after the other."""

    case: Case
    renderer: Renderer
    frame: Callable[[], None]


@contextmanager
def running_case(
    case: Case, size: tuple[int, int], quality: str = "medium", overrides: Mapping[str, Any] | None = None
) -> Iterator[RunningCase]:
    """A case, shown until what is made once has been made; released afterwards.

    A paused case has come to rest, or RuntimeError names what still ran. All others turn the camera by 0.01 degrees
    a frame: culled and drawn, proxy held.
    """
    scene = preset_scene(case.planet, clouds=True)
    for kind in case.without:
        if scene.planet.has(kind):
            scene.planet.remove(kind)
    for kind, values in case.knobs.items():
        for name, value in values.items():
            setattr(scene.planet[kind], name, value)
    renderer = Renderer(scene, size, quality, overrides)
    target = None
    try:
        target = renderer.ctx.simple_framebuffer(size)
        seen = view(case.view, scene.planet)
        shot = seen if case.camera is None else case.camera(scene, size[1])
        sun: Any = seen.sun or scene.sun
        if case.sun_elevation_deg is not None:
            state, angle = renderer.camera_state(shot), math.radians(case.sun_elevation_deg)
            x, y, z = map(float, state.direction * math.sin(angle) + state.right * math.cos(angle))
            sun = Sun(direction=(x, y, z), irradiance=scene.sun.irradiance)
        moment: dict[str, Any] = {"sun": sun, "time_s": seen.time_s}
        renderer.settle(shot, **moment)
        state = renderer.camera_state(shot)
        still = Camera(state.position_m, state.forward, state.up, seen.fov_y_deg if case.camera is None else 60.0)
        cameras = [still] if case.paused else turned(renderer.camera_state(still), TURN_DEG, 4)

        def frame() -> None:
            cameras.append(cameras.pop(0))
            moment["time_s"] += _FRAME_S if case.runs else 0.0
            renderer.render_to(target, cameras[0], **moment)
            renderer.ctx.finish()

        for _ in range(REST_FRAMES if case.paused else 8):
            frame()
            if case.paused and _resting(renderer):
                break
        if case.paused and not _resting(renderer):
            ran = [p.name for p in renderer.passes() if p.ran]
            raise RuntimeError(f"{case.name}: no rest after {REST_FRAMES} frames; still running: {', '.join(ran)}")
        yield RunningCase(case, renderer, frame)
    finally:
        if target is not None:
            renderer.gpu.leave(target)
            target.release()
        renderer.release()
        scene.release()


def _resting(renderer: Renderer) -> bool:
    return [p.name for p in renderer.passes() if p.ran] == ["outputs.present"]


def counts(case: RunningCase) -> Counts:
    """What one more frame of it does."""
    renderer = case.renderer
    before = renderer.gpu.work.snapshot()
    case.frame()
    after = renderer.gpu.work.snapshot()
    reports = renderer.passes()
    done = {name: after[name] - before[name] for name in before}
    return Counts(
        ran={p.name: p.system for p in reports if p.ran},
        skipped=sum(not p.ran for p in reports),
        draws=done["draws"],
        dispatches=done["dispatches"],
        uploads=done["uploads"],
        programs_built=done["programs_built"],
        objects={owner: sum(kinds.values()) for owner, kinds in renderer.gpu.counts().items()},
        programs=renderer.gpu.shaders.program_count,
        systems=tuple(system.name for system in renderer.running),
    )


@dataclass(frozen=True)
class Paired:
    """Frames of several stages that took turns."""

    timing: Timing
    """By the clock."""
    cpu_ms: float
    """Processor time of all cores, median: hardly changed by what else a machine does."""


def timed_together(stages: Mapping[str, Callable[[], None]], runs: int) -> dict[str, Paired]:
    """Frames that end with the GPU's work, in turns."""
    used: dict[str, list[float]] = {name: [] for name in stages}

    def clocked(name: str, frame: Callable[[], None]) -> Callable[[], None]:
        def run() -> None:
            before = time.process_time()
            frame()
            used[name].append((time.process_time() - before) * 1e3)

        return run

    times = time_variants({name: clocked(name, frame) for name, frame in stages.items()}, runs, 2)
    return {name: Paired(times[name], float(np.median(used[name][-runs:]))) for name in stages}


def pass_times(case: RunningCase, runs: int, systems: Sequence[str] | None = None) -> dict[str, float]:
    """Processor time in ms of each pass, all cores, each waited for: the median over frames.

    systems: of these alone; None: of all. An empty pass counts what waiting costs, 0.02 ms.
    """
    renderer = case.renderer
    samples: dict[str, list[float]] = {}
    with _waiting(renderer):
        for _ in range(runs + 1):
            case.frame()
            for report in renderer.passes():
                if report.gpu_ms is not None and (systems is None or report.system in systems):
                    samples.setdefault(report.name, []).append(report.gpu_ms)
    return {name: float(np.median(found[1:] or found)) for name, found in samples.items()}


def update_times(case: RunningCase, runs: int, systems: Sequence[str]) -> dict[str, float]:
    """Processor time in ms of what these systems do in a frame before its passes: the median over frames, less what
    reading the clock takes."""
    samples: dict[str, list[float]] = {name: [] for name in ("", *systems)}

    def clocked(name: str, update: Callable[..., None]) -> Callable[..., None]:
        def run(*frame: Any) -> None:
            before = time.process_time()
            update(*frame)
            samples[name].append((time.process_time() - before) * 1e3)

        return run

    held = [system for system in case.renderer.running if system.name in systems]
    nothing = clocked("", lambda: None)
    try:
        for system in held:
            vars(system)["update"] = clocked(system.name, system.update)
        for _ in range(runs):
            nothing()
            case.frame()
    finally:
        for system in held:
            vars(system).pop("update", None)
    empty_ms = float(np.median(samples.pop("")))
    return {name: max(float(np.median(found)) - empty_ms, 0.0) for name, found in samples.items() if found}


class _CpuTimers:
    """Timers for a frame graph: processor time from one finished pass to the next."""

    def __init__(self, finish: Callable[[], None], count: int) -> None:
        self._finish = finish
        self._began = [0.0] * count
        self._ms: list[float | None] = [None] * count

    def begin(self, slot: int) -> None:
        self._finish()
        self._began[slot] = time.process_time()

    def end(self, slot: int) -> None:
        self._finish()
        self._ms[slot] = (time.process_time() - self._began[slot]) * 1e3

    def collect(self, out: list[float | None]) -> None:
        out[:] = self._ms
        self._ms = [None] * len(self._ms)

    def release(self) -> None:
        """Nothing to free."""


@contextmanager
def _waiting(renderer: Renderer) -> Iterator[None]:
    backend: Any = renderer.own.backend
    kept = backend.create_timers
    backend.create_timers = lambda count: _CpuTimers(renderer.ctx.finish, count)
    try:
        renderer.graph.gpu_timing = True
        yield
        renderer.graph.gpu_timing = False
    finally:
        backend.create_timers = kept


_IMPORTS = """
import json, sys
import planetfall as pf
scene = pf.load_scene(sys.argv[1])
for kind in (pf.Clouds, pf.Ocean, pf.Atmosphere):
    if sys.argv[2] == "bare" and scene.planet.has(kind):
        scene.planet.remove(kind)
with pf.Renderer(scene, (16, 9), "low") as renderer:
    renderer.render(pf.view("near", scene.planet))
print(json.dumps(sorted(sys.modules)))
"""


def imports_of(planet: str, bare: bool = False) -> frozenset[str]:
    """Modules that a fresh process has after it has rendered a picture of a planet. bare: without sea, air, clouds."""
    return frozenset(answer_of("-c", _IMPORTS, planet, "bare" if bare else "whole"))


def planet_systems(renderer: Renderer) -> tuple[str, ...]:
    """Systems that are there for a planet; the proxy places the camera and draws nothing."""
    return tuple(s.name for s in renderer.running if Planet in s.needs and s.name != "proxy")
