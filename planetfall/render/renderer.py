"""Renderer: pictures, arrays and embedding for one scene."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import moderngl
from numpy.typing import NDArray

from .. import ASSETS, extend
from ..camera.arguments import check_moment, check_scene, check_size
from ..camera.camera import Camera
from ..camera.views import View
from ..components import DebugView, Planet
from ..engine.frame import Frame, SunState, ViewInfo, Views
from ..engine.gpu import Gpu
from ..engine.gpu.graph_backend import GLBackend
from ..engine.graph import GraphBuilder, Plan
from ..engine.hosts.foreign import ForeignHost, attach
from ..engine.settings import revision
from ..engine.space import CameraState
from ..engine.system import Setup, System
from ..errors import SettingError
from ..quality import checked_live, resolve_quality
from ..scene.scene import Scene
from ..systems.light import resolve_sun
from .context_loss import ContextWatch
from .drawn_ground import DrawnGround
from .faults import Faults, draw_without_faults
from .host_space import HostDepth
from .looking import Looking
from .memory_budget import plan_memory
from .outputs import OUTPUTS, exports_for, read_output
from .rest import Rest
from .settling import settle
from .several_planets import SeveralPlanets, by_nearest
from .snapshot import Snapshot
from .standpoint import Standpoint
from .stillness import Stillness
from .system_list import SystemList
from .view import RenderView
from .watch import Watch

log = logging.getLogger(__name__)

_TARGETS = frozenset({"target", "target_with_depth"})


class Renderer(Looking):
    """Renders a scene to arrays, or into a host's framebuffer.

    scene: see load_scene. size: (width, height) in pixels. quality: low, medium, high, ultra, reference or paper.
    overrides: {"terrain.edge_px": 8.0, ...}, any knob by its dotted key. ctx: a host's current moderngl context, or
    None for a headless one of its own. systems: further System classes of a game, beside those of `extend.register`.
    guard: with a host's ctx, give the host its GL state back after every call; a host that sets all its own state each
    frame may say False (docs/embedding.md). One thread a renderer; release() frees every GL object.

    Raises SizeError, SettingError, NoEGLError, GLVersionError before any GPU work.
    """

    def __init__(
        self,
        scene: Scene,
        size: tuple[int, int] = (1280, 720),
        quality: str = "high",
        overrides: Mapping[str, Any] | None = None,
        ctx: moderngl.Context | None = None,
        systems: Sequence[type[System]] = (),
        guard: bool = True,
    ) -> None:
        check_scene(scene, "Renderer")
        check_size(size, None)
        self.settings = resolve_quality(quality, overrides)
        scene.validate(self.settings)
        self.memory = plan_memory(self.settings, scene, size)
        """What "memory.budget_mib" came to: what is expected, and which knobs gave way."""
        self.quality = quality
        self.scene = scene
        self._ground = DrawnGround(scene, self.settings)
        self._stand = Standpoint(scene, self._ground)
        self._stillness = Stillness(scene)
        self._rest = Rest(scene)
        self._resources = scene.world.own_resources()
        self._host: ForeignHost | None = None
        if ctx is None:
            from ..engine.hosts.headless import create_headless

            self.gpu = Gpu(create_headless(), [ASSETS / "shaders", *extend.shader_folders()])
        else:
            host = attach(ctx, [ASSETS / "shaders", *extend.shader_folders()])
            self.gpu = host.gpu
            self._host = host if guard else None
        self._own_context, self.ctx = ctx is None, self.gpu.ctx
        self._context = ContextWatch(self)
        check_size(size, self.gpu.caps.max_texture_size)
        self.size = (int(size[0]), int(size[1]))
        self._views: list[RenderView] = []
        self._several = SeveralPlanets(self)
        self._made_with = (quality, dict(overrides or {}), tuple(systems))
        self.views = Views()
        """What systems keep for each view."""
        self._view_index, self._gates = 0, 0  # gates: how often systems came or went
        self._system_list = SystemList((*extend.registered_systems(), *systems))
        self.systems: tuple[System, ...] = self._system_list.needed(scene.world)
        """All systems that the scene needs or has needed, running or not, in the order of their updates."""
        self._scopes: dict[str, Any] = {}
        self._graph_scope = self.gpu.scope("graph")
        self._backend = GLBackend(self._graph_scope)
        self._plan: Plan | None = None
        self._plan_key: tuple[Any, ...] = ()
        self._gate_key: tuple[Any, ...] = ()
        self._exports: frozenset[str] = frozenset({"composite.ldr"})
        self._frame: Frame | None = None
        self._frame_index, self._dt_s = 0, 1.0 / 60.0
        self._sun_key: tuple[Any, ...] = ()
        self._sun_held: SunState | None = None
        self._host_depth: tuple[float, float] | None = None
        self._cut, self.python_ms = True, 0.0
        self.faults = Faults(scene.planet.name, self._several.faults)
        """Systems that are switched off because they raised; see `tolerant`."""
        self.watch = Watch()
        """Functions to be called when the scene has changed, or all has settled."""
        self._render_scale = 1.0
        self.tolerant = False
        """Whether `render_to` goes on without a system that raises, instead of raising itself."""
        self.released = False

    # -- pictures ----------------------------------------------------------------------------------------------------

    @by_nearest
    def render(
        self,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Any = None,
        outputs: Sequence[str] = ("color",),
        dt_s: float | None = None,
    ) -> dict[str, NDArray[Any]]:
        """One frame as arrays of shape (H, W[, C]), row 0 on top; never blocks on streaming.

        outputs: any of color (u8, 3, sRGB), radiance (f32, 3, W m^-2 sr^-1 nm^-1 before exposure), distance (f32, m
        along the ray, inf where nothing was hit), position (f32, 3, m from the camera in planet axes, NaN), normal
        (f32, 3, 0), surface (u8: 0 none, 1 terrain, 2 sea, 3 props), or the name of any texture of the frame graph.
        camera: a Camera, or a View, which brings its own sun, time and exposure. time_s: moves water and weather, and
        an epoch sun. sun: a Sun component that replaces the scene's.
        dt_s: time since the last frame, for a frame of a sequence: exposure adapts, and anti-aliasing builds on the
        frames before. Without it the picture stands for itself, the same whatever was rendered before, unless this
        very moment was settled: then it shows the settled picture.
        """
        exports = exports_for(outputs)
        wanted = tuple(outputs)
        exact = bool(exports - {"composite.ldr"})
        with self._guest():
            self._draw(camera, time_s, sun, exports, dt_s, None, one_shot=dt_s is None, exact=exact)
            plan = self._require_plan()
            return {name: read_output(plan, name, self.size) for name in wanted}

    @by_nearest
    def render_to(
        self,
        framebuffer: moderngl.Framebuffer,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Any = None,
        viewport: tuple[int, int, int, int] | None = None,
        dt_s: float | None = None,
        depth: HostDepth | None = None,
    ) -> None:
        """One frame into a framebuffer of the host's, at viewport (x, y, width, height; default: all of it).

        The renderer takes the viewport's size, times `render_scale`. The host's GL state stays (see `guard`).
        depth: how the framebuffer's depth buffer stores distances (`HostSpace.depth`): what the host has drawn before
        stays where it is nearer, and what it draws afterwards stands in the planet's world. None: over everything.
        """
        x, y, width, height = viewport or (0, 0, *framebuffer.size)
        with self._guest(framebuffer):
            scale = min(self.render_scale, self.memory.scale((width, height))) if depth is None else 1.0
            self._resize((max(round(scale * width), 1), max(round(scale * height), 1)))
            framebuffer.viewport = (x, y, width, height)
            self._host_depth = None if depth is None else (depth.offset, depth.scale_m)
            name = "target" if depth is None else "target_with_depth"

            def draw() -> None:
                self._draw(camera, time_s, sun, frozenset({name}), dt_s, framebuffer)

            if self.tolerant:
                draw_without_faults(self, draw)
            else:
                draw()

    @by_nearest
    def settle(
        self,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Any = None,
        timeout_s: float | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Render until exposure and everything that refines over frames has converged: pictures become deterministic.

        progress(share) is called after each frame. NotSettled after timeout_s, naming what had not settled.
        """
        self._cut = True

        def frame() -> None:
            exports = self._exports - _TARGETS | {"composite.ldr"}
            self._draw(camera, time_s, sun, exports, 10.0, None, settling=True)

        settle(self, frame, timeout_s, progress)

    def snapshot(self, camera: Camera | View, time_s: float | None = None, settle: bool = True) -> Snapshot:
        """A picture that shows itself in notebooks; .array, .save(path)."""
        if settle:
            self.settle(camera, time_s)
        return Snapshot(self.render(camera, time_s)["color"])

    def add_view(self, size: tuple[int, int]) -> RenderView:
        """One more picture of the same scene, of any size: split screen, map, mirror. It shares tiles and tables."""
        return RenderView(self, size)

    def resize(self, size: tuple[int, int]) -> None:
        """A new picture size; history (exposure) starts again only where it must."""
        with self._guest():
            self._resize(size)

    def _resize(self, size: tuple[int, int]) -> None:
        check_size(size, self.gpu.caps.max_texture_size)
        size = (int(size[0]), int(size[1]))
        if size != self.size:
            if self._plan is not None:
                self._plan.resize(size)
            self.size = size
            self._plan_key = ()  # lists of tiles have the picture's size

    @by_nearest
    def camera_state(self, camera: Camera | View) -> CameraState:
        """The camera in f64 as the renderer uses it: resolved against the scene's ground, lifted out of it if need
        be."""
        return self._stand.state(camera, self.size)

    def reload_shaders(self) -> list[str]:
        """Compile what has changed on disk; a broken shader leaves the last good one running. Names of what was
        reloaded."""
        with self._guest():
            changed = self.gpu.shaders.reload_changed()
            if changed:
                self.faults.shaders_reloaded()
            if changed and self._plan is not None:
                self._plan.invalidate_persistent()
                self._rest.forget()
            for view in self._views if changed else ():
                view.outdated()
            return [*changed, *(name for name in self._several.reload_shaders() if name not in changed)]

    def release(self) -> None:
        """Free every GL object; may be called twice. With a lost context they are gone already."""
        if self.released:
            return
        if not self._context.lost:
            with self._guest():
                self._several.release()
                for view in list(self._views):
                    view.release()
                if self._plan is not None:
                    self._plan.release()
                for system in self.systems:
                    self._deactivate(system)
                self.gpu.release()
        self.released = True
        if self._own_context:
            self.ctx.release()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def current(self) -> AbstractContextManager[Any]:
        """Our GL context current, a host's state safe: for reading back between frames."""
        return self._guest()

    def _guest(self, framebuffer: moderngl.Framebuffer | None = None) -> AbstractContextManager[Any]:
        if self.released:
            raise SettingError("this renderer has been released: make a new one")
        self._context.check()
        self.scene.world.resources = self._resources  # a scene may have several renderers
        if self._own_context:
            # A program may have several renderers, each with its own context. It stays current: reading a buffer
            # between frames then works as with a single one.
            self.ctx.__enter__()
            return nullcontext()
        return nullcontext() if self._host is None else self._host.guest(framebuffer)

    # -- a frame -----------------------------------------------------------------------------------------------------

    def _require_plan(self) -> Plan:
        front = self._several.front
        if front is not self:
            return front.graph
        if self._plan is None:
            raise SettingError("nothing has been rendered yet: call render() first")
        return self._plan

    def _draw(
        self,
        camera: Camera | View,
        time_s: float | None,
        sun: Any,
        exports: frozenset[str],
        dt_s: float | None,
        target: Any,
        settling: bool = False,
        one_shot: bool = False,
        exact: bool = False,
    ) -> None:
        started = time.perf_counter()
        check_moment(camera, time_s, sun)
        view = camera if isinstance(camera, View) else None
        if time_s is None:
            time_s = view.time_s if view is not None else 0.0
        state = self._stand.state(camera, self.size)
        own_sun = self._stand.sun
        sun_component = sun if sun is not None else self.scene.sun if own_sun is None else own_sun
        sun_state = self._sun_state(sun_component, time_s)
        self._gate()
        frame = self._frame_for(state, sun_state, time_s, dt_s)
        frame.ev100 = camera.ev100
        frame.settling, frame.one_shot, frame.exact = settling, one_shot, exact
        running = self.running
        several = bool(self._views)
        frame.still = self._stillness.same_as_before(frame, running, several)
        rests = self._rest.may_repeat(frame, lambda: self._stillness.settled(running, several), exports)
        if rests and self._repeat(exports, running, target):
            self.python_ms = (time.perf_counter() - started) * 1e3
            return
        for system in running:
            system.begin(frame)
        for system in running:
            system.update(frame)
        plan = self._compiled(exports)
        if target is not None:
            plan.bind_import(next(iter(exports)), target)
        if frame.cut:
            plan.invalidate_history()
        self.python_ms = (time.perf_counter() - started) * 1e3
        plan.execute()
        self._cut = False
        self._frame_index += 1
        self._stillness.drawn(running, frame.still, several)
        self.watch.after_frame(self.scene, running)

    def _repeat(self, exports: frozenset[str], running: Sequence[System], target: Any) -> bool:
        """The last picture once more, into the target of this frame; False: it has to be made, or passes are timed."""
        if self._plan is None or self._plan_key != self._structure(exports, running) or self._plan.gpu_timing:
            return False
        if target is not None:
            self._plan.bind_import(next(iter(exports)), target)
        done = self._plan.repeat()
        self._frame_index += done
        return done

    def _sun_state(self, sun: Any, time_s: float) -> SunState:
        planet = self.scene.planet.planet
        key = (id(sun), revision(sun), revision(planet), time_s if sun.mode == "epoch" else 0.0)
        if key != self._sun_key:
            self._sun_key, self._sun_held = key, resolve_sun(sun, planet, time_s)
        assert self._sun_held is not None
        return self._sun_held

    def _frame_for(self, state: CameraState, sun: SunState, time_s: float, dt_s: float | None) -> Frame:
        planet = self.scene.planet.entity
        if self._frame is None:
            self._frame = Frame(self.scene.world, planet, self.size, state, sun, settings=self.settings)
        frame = self._frame
        frame.planet, frame.size, frame.camera, frame.sun, frame.time_s = planet, self.size, state, sun, time_s
        frame.view, frame.dt_s = self.views[self._view_index], self._dt_s if dt_s is None else dt_s
        frame.frame_index = self._frame_index
        frame.cut, frame.host_depth = self._cut, self._host_depth
        frame.star_axes, frame.backdrop = None, True
        frame.frozen = any(shown.freeze for _, (shown,) in self.scene.world.query(DebugView))
        frame.left_out = set()  # a new one: views keep the last
        return frame

    def _gate(self) -> None:
        """Set up what the world now has, let go of what it no longer has."""
        world = self.scene.world
        key = (world.structure_revision, self.scene.planet.entity)
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
                    self._gate_key = ()  # tried again in the next frame
                    raise
                self._scopes[system.name] = scope
                self._gates += 1
            elif running and not wanted:
                self._deactivate(system)
                self._gates += 1

    def _deactivate(self, system: System) -> None:
        scope = self._scopes.pop(system.name, None)
        if scope is not None:
            try:
                system.release()
            except Exception:
                if system.name not in self.faults:
                    raise
                log.warning(
                    "system %r, which had raised, raised again when it was released", system.name, exc_info=True
                )
            self.views.forget(system)
            scope.release()

    @property
    def running(self) -> tuple[System, ...]:
        """The systems that draw the scene as it is."""
        return tuple(s for s in self.systems if s.name in self._scopes)

    @property
    def failed_system(self) -> str:
        """The system whose pass raised in the last frame; "" where none did."""
        return "" if self._plan is None else self._plan.failed_system

    @property
    def render_scale(self) -> float:
        """Rows that `render_to` draws for each row of the viewport, which it then fills; with `depth` always 1."""
        return self._render_scale

    @render_scale.setter
    def render_scale(self, scale: float) -> None:
        if not 0.05 <= scale <= 4.0:  # nan is neither
            raise SettingError(f"render_scale: expected a number from 0.05 to 4, found {scale!r}")
        self._render_scale = scale

    def retune(self, changes: Mapping[str, Any]) -> None:
        """Change quality knobs that are read each frame (`LIVE`): nothing is made anew. SettingError for others."""
        checked = checked_live(changes)
        self._several.retune(checked)
        if any(self.settings[key] != value for key, value in checked.items()):
            self.settings.update(checked)
            self._stillness.forget()

    def try_again(self) -> None:
        """Switch on again what was switched off because it raised."""
        self.faults.forget()
        self.gate_again()
        self._several.try_again()

    def gate_again(self) -> None:
        """With the next frame, look again at which systems run, and compile."""
        self._gate_key = ()
        self._gates += 1

    def _structure(self, exports: frozenset[str], running: Sequence[System]) -> tuple[Any, ...]:
        view = self.views[self._view_index]
        return exports, self._gates, tuple((s.name, s.structure_of(view)) for s in running)

    def _compiled(self, exports: frozenset[str]) -> Plan:
        running = self.running
        key = self._structure(exports, running)
        if self._plan is not None and key == self._plan_key:
            return self._plan
        builder = GraphBuilder()
        view = ViewInfo(self.size, self.views[self._view_index], exports, self.scene.planet.entity)
        of_view = builder.scope(view=0, home=view.planet_index)  # each view has a graph of its own
        of_planet = of_view.scope(planet=view.planet_index)
        for system in running:
            # What needs a planet belongs to that planet in this view, the rest to the view.
            system.declare(of_planet if Planet in system.needs else of_view, view)
        for name in sorted(exports):
            of_view.export(name)
        old = self._plan
        self._plan = builder.compile(self._backend, self.size, previous=old)
        self._plan_key = key
        self._exports = exports
        return self._plan


__all__ = ["OUTPUTS", "Renderer"]
