"""PlanetRenderer: draws one planet of a scene, with its ground, sea, air and clouds, for any number of views."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import moderngl

from ..components import DebugView, Planet, Sun
from ..engine.display import WAVELENGTHS_FILE, shader
from ..engine.frame import Frame, SunState, ViewInfo, Views
from ..engine.gpu import Gpu, GpuScope
from ..engine.gpu.graph_backend import GLBackend
from ..engine.graph import GraphBuilder, Plan
from ..engine.settings import revision
from ..engine.space import CameraState
from ..engine.system import Setup, System
from ..engine.wavelengths import carried_sunlight, wavelengths_of
from ..scene.scene import Scene
from ..systems.light import resolve_sun
from .drawn_ground import DrawnGround
from .drawn_view import LDR, DrawnView, PlanKey
from .faults import Faults
from .memory_budget import MemoryPlan
from .system_list import SystemList

__all__ = ["Moment", "PlanetRenderer", "Wanted"]

log = logging.getLogger(__name__)


class _GateKey(NamedTuple):
    """What decides which systems run: the world's structure, and the planet's entity."""

    structure: int
    planet: int


class _SunKey(NamedTuple):
    """What a sun's state follows from. sun: its id; revision: its own; planet: the planet's; time_s: 0 where the sun
    stands."""

    sun: int
    revision: int
    planet: int
    time_s: float


@dataclass(frozen=True, eq=False)
class Moment:
    """What a frame shows: camera and sun in the planet's axes, and the time of water and weather. ev100: a fixed
    exposure, or None."""

    camera: CameraState
    sun: SunState
    time_s: float
    ev100: float | None = None


@dataclass(frozen=True)
class Wanted:
    """What a frame is drawn for.

    exports: resources of the frame graph that have to be there afterwards. dt_s: time since the last frame, or None.
    target: the framebuffer of the single export where that is a host's. host_depth, settling, one_shot, exact: as in
    Frame.
    """

    exports: frozenset[str] = frozenset({LDR})
    dt_s: float | None = None
    target: moderngl.Framebuffer | None = None
    host_depth: tuple[float, float] | None = None
    settling: bool = False
    one_shot: bool = False
    exact: bool = False


class PlanetRenderer:
    """The systems of one planet, their GL objects, and the views that they draw.

    scene: whose own planet it draws. gpu: which its objects are counted under. settings: all quality knobs; shared by
    whoever changes them. memory: what its pictures may take. systems: classes of a game. others: gives the faults of
    further planets' renderers.
    """

    def __init__(
        self,
        scene: Scene,
        gpu: Gpu,
        settings: dict[str, Any],
        memory: MemoryPlan,
        size: tuple[int, int],
        systems: Sequence[type[System]] = (),
        others: Callable[[], Iterable[Faults]] = tuple,
    ) -> None:
        self.scene, self.gpu, self.settings, self.memory = scene, gpu, settings, memory
        self.nm = wavelengths_of(settings)
        """At which wavelengths light is carried."""
        gpu.shaders.add_virtual(WAVELENGTHS_FILE, shader(self.nm))
        self.ground = DrawnGround(scene, settings)
        self.world = scene.world.with_own_resources()
        """The scene's, with what the systems of this renderer publish: a scene may have several."""
        self._system_list = SystemList(systems)
        self.systems: tuple[System, ...] = self._system_list.needed(self.world)
        """All that the scene needs or has needed, running or not, in the order of their updates."""
        self._scopes: dict[str, GpuScope] = {}
        self._gates = 0  # how often systems came or went
        self._gate_key: _GateKey | None = None
        self.backend = GLBackend(gpu.scope("graph"))
        self.faults = Faults(scene.planet.name, others)
        self._sun: tuple[_SunKey, SunState] | None = None
        self.python_ms = 0.0
        """What the last frame took before the GPU's work began."""
        self.views = Views()
        """What systems keep for each view."""
        self.first_view = self._made_view(0, size)
        """The renderer's own; further ones come and go."""

    # -- views ---------------------------------------------------------------------------------------------------------

    def _made_view(self, index: int, size: tuple[int, int]) -> DrawnView:
        view = DrawnView(index, size, self.scene, self.ground)
        self.views.add(view)
        return view

    def add_view(self, size: tuple[int, int]) -> DrawnView:
        """One more, under the lowest index that is free."""
        taken = {view.index for view in self.views}
        return self._made_view(next(n for n in range(1, len(taken) + 2) if n not in taken), size)

    def release_view(self, view: DrawnView) -> None:
        """Free what is that view's alone."""
        self.views.release(view)

    def _drawn(self) -> list[DrawnView]:
        return [view for view in self.views if isinstance(view, DrawnView)]

    # -- a frame -------------------------------------------------------------------------------------------------------

    def draw(self, view: DrawnView, moment: Moment, wanted: Wanted) -> bool:
        """A frame of a view; False where the last one was shown once more."""
        started = time.perf_counter()
        self._gate()
        frame = self._frame_for(view, moment, wanted)
        running = self.running
        frame.still = view.stillness.same_as_before(frame, running)
        rests = view.rest.may_repeat(frame, lambda: view.stillness.settled(view, running), wanted.exports)
        if rests and self._repeat(view, wanted, running):
            self.python_ms = (time.perf_counter() - started) * 1e3
            return False
        for system in running:
            system.begin(frame)
        for system in running:
            system.update(frame)
        plan = self._compiled(view, wanted.exports)
        if wanted.target is not None:
            plan.bind_import(next(iter(wanted.exports)), wanted.target)
        if frame.cut:
            plan.invalidate_history()
        self.python_ms = (time.perf_counter() - started) * 1e3
        plan.execute()
        if not (wanted.one_shot or wanted.settling or self.gpu.caps.is_software):
            self.gpu.shaders.link_another()
        view.cut = False
        view.frames += 1
        view.stillness.drawn(view, running)
        return True

    def _repeat(self, view: DrawnView, wanted: Wanted, running: Sequence[System]) -> bool:
        """The last picture once more, into the target of this frame; False: it has to be made, or passes are timed."""
        plan = view.plan
        if plan is None or view.plan_key != self._structure(view, wanted.exports, running) or plan.gpu_timing:
            return False
        if wanted.target is not None:
            plan.bind_import(next(iter(wanted.exports)), wanted.target)
        done = plan.repeat()
        view.frames += done
        return done

    def sun_state(self, sun: Sun, time_s: float) -> SunState:
        """A sun over this planet, its light at `nm`; the same object while it stands."""
        planet = self.scene.planet.planet
        key = _SunKey(id(sun), revision(sun), revision(planet), time_s if sun.mode == "epoch" else 0.0)
        if self._sun is None or self._sun[0] != key:
            state = resolve_sun(sun, planet, time_s)
            carried = carried_sunlight(state.irradiance, self.nm)
            self._sun = (key, replace(state, irradiance=carried))
        return self._sun[1]

    def _frame_for(self, view: DrawnView, moment: Moment, wanted: Wanted) -> Frame:
        world, planet = self.world, self.scene.planet.entity
        frame = view.latest
        if frame is None:
            frame = Frame(world, planet, view.size, moment.camera, moment.sun, settings=self.settings, view=view)
        frame.planet, frame.size, frame.camera, frame.sun = planet, view.size, moment.camera, moment.sun
        frame.time_s, frame.ev100 = moment.time_s, moment.ev100
        frame.dt_s = 1.0 / 60.0 if wanted.dt_s is None else wanted.dt_s
        frame.frame_index, frame.cut, frame.host_depth = view.frames, view.cut, wanted.host_depth
        frame.settling, frame.one_shot, frame.exact = wanted.settling, wanted.one_shot, wanted.exact
        frame.star_axes, frame.backdrop = None, True
        frame.frozen = any(shown.freeze for _, (shown,) in world.query(DebugView))
        frame.checkered = set()  # a new one: views keep the last
        return frame

    def _structure(self, view: DrawnView, exports: frozenset[str], running: Sequence[System]) -> PlanKey:
        return PlanKey(exports, self._gates, view.structure, tuple((s.name, s.structure_of(view)) for s in running))

    def _compiled(self, view: DrawnView, exports: frozenset[str]) -> Plan:
        running = self.running
        key = self._structure(view, exports, running)
        if view.plan is not None and key == view.plan_key:
            return view.plan
        builder = GraphBuilder()
        info = ViewInfo(view.size, view, exports, self.scene.planet.entity)
        of_view = builder.scope(view=0, home=0)  # each view has a graph of its own
        of_planet = of_view.scope(planet=0)
        for system in running:
            # What needs a planet belongs to that planet in this view, the rest to the view.
            system.declare(of_planet if Planet in system.needs else of_view, info)
        for name in sorted(exports):
            of_view.export(name)
        view.plan = builder.compile(self.backend, view.size, previous=view.plan)
        view.plan_key, view.exports = key, exports
        return view.plan

    # -- systems that come and go --------------------------------------------------------------------------------------

    def _gate(self) -> None:
        """Set up what the world now has, let go of what it no longer has."""
        world = self.world
        key = _GateKey(world.structure_revision, self.scene.planet.entity)
        if key == self._gate_key:
            return
        self._gate_key = key
        self.systems = self._system_list.needed(world)
        for system in self.systems:
            running = system.name in self._scopes
            wanted = system.name not in self.faults and system.active(world)
            if wanted and not running:
                scope = self.gpu.scope(system.name)
                try:
                    system.setup(Setup(world, scope, self.settings, self.scene.planet.entity, self.views))
                except BaseException:
                    scope.release()
                    self._gate_key = None  # tried again in the next frame
                    raise
                self._scopes[system.name] = scope
                self._gates += 1
            elif running and not wanted:
                self.switch_off(system)
                self._gates += 1

    def switch_off(self, system: System) -> None:
        """Free what a system has; it is set up again when it is wanted."""
        scope = self._scopes.pop(system.name, None)
        if scope is None:
            return
        try:
            system.release()
        except Exception:
            if system.name not in self.faults:
                raise
            log.warning("system %r, which had raised, raised again when it was released", system.name, exc_info=True)
        self.views.forget(system)
        scope.release()

    def gate_again(self) -> None:
        """With the next frame, look again at which systems run, and compile."""
        self._gate_key = None
        self._gates += 1

    def try_again(self) -> None:
        """Switch on again what was switched off because it raised."""
        self.faults.forget()
        self.gate_again()

    @property
    def running(self) -> tuple[System, ...]:
        """The systems that draw the scene as it is."""
        return tuple(s for s in self.systems if s.name in self._scopes)

    def system(self, name: str) -> System | None:
        """The running system of that name, or None."""
        return next((s for s in self.systems if s.name == name and name in self._scopes), None)

    # -- changes -------------------------------------------------------------------------------------------------------

    def retuned(self) -> None:
        """Settings have changed."""
        for view in self._drawn():
            view.stillness.forget()

    def reload_shaders(self) -> list[str]:
        """Compile what has changed on disk; its names."""
        changed = self.gpu.shaders.reload_changed()
        if changed:
            self.faults.shaders_reloaded()
            for view in self._drawn():
                view.outdated()
        return changed

    def release(self) -> None:
        """Free every GL object. The context has to be current."""
        for view in self._drawn():
            if view is not self.first_view:
                self.release_view(view)
        self.first_view.release_plan()
        for system in self.systems:
            self.switch_off(system)
        self.gpu.release()
