"""Renderer: pictures, arrays and embedding for one scene."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

import moderngl

from .. import ASSETS, extend
from ..camera.arguments import check_scene, check_size
from ..engine.frame import Views
from ..engine.gpu import Gpu, ShaderError
from ..engine.surface.field import HeightField
from ..engine.system import System
from ..engine.world import World
from ..errors import SettingError
from ..quality import checked_live, resolve_quality
from ..scene.scene import Scene
from .context import RenderContext
from .context_loss import Place
from .faults import Faults
from .memory_budget import plan_memory
from .outputs import OUTPUTS
from .picture import Picture
from .planet import PlanetRenderer
from .planets import Planets
from .queries import statistics
from .view import RenderView
from .watch import Watch

__all__ = ["OUTPUTS", "Renderer"]


class Renderer(Picture):
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
        self.released, self.python_ms, self._render_scale = False, 0.0, 1.0
        self.tolerant = False
        """Whether `render_to` goes on without a system that raises, instead of raising itself."""
        self.watch = Watch()
        """Functions to be called when the scene has changed, or all has settled."""
        self._game_systems = (*extend.registered_systems(), *systems)
        folders = [ASSETS / "shaders", *extend.shader_folders()]
        self.context = RenderContext(scene, ctx, guard, folders, self._camera_place)
        self.gpu, self.ctx = self.context.gpu, self.context.ctx
        self.own = PlanetRenderer(
            scene, self.gpu, self.settings, self.memory, size, self._game_systems, self._other_faults
        )
        """The renderer of the scene's own planet."""
        self.planets = Planets(self.own, self._planet_renderer)
        """The renderers of all planets by name; those of companions from the first frame on that they are there."""
        self._added: list[RenderView] = []
        super().__init__(self, size, is_added=False)

    def _planet_renderer(self, scene: Scene) -> PlanetRenderer:
        scene.validate(self.settings)
        memory = plan_memory(dict(self.settings), scene, self.size)
        gpu = self.context.another_gpu()
        return PlanetRenderer(scene, gpu, self.settings, memory, self.size, self._game_systems)

    def _other_faults(self) -> list[Faults]:
        return self.planets.faults()

    def _camera_place(self) -> Place:
        last = self.own.first_view.latest
        return None if last is None else last.camera.position_m

    # -- views and contexts --------------------------------------------------------------------------------------------

    def add_view(self, size: tuple[int, int]) -> RenderView:
        """One more picture of the same scene, of any size: split screen, map, mirror. It shares tiles and tables."""
        self._added = [view for view in self._added if not view.released]
        self._added.append(RenderView(self, size))
        return self._added[-1]

    def current(self, framebuffer: moderngl.Framebuffer | None = None) -> AbstractContextManager[object]:
        """Our GL context current, a host's state safe: for reading back between frames. framebuffer: of the host's, if
        it is to be drawn into."""
        self._check()
        return self.context.current(framebuffer)

    def _check(self) -> None:
        if self.released:
            raise SettingError("this renderer has been released: make a new one")

    def reload_shaders(self) -> list[str]:
        """Compile what has changed on disk; a broken shader leaves the last good one running. Names of what was
        reloaded."""
        with self.current():
            return list(dict.fromkeys(name for planet in self.planets.values() for name in planet.reload_shaders()))

    def retune(self, changes: Mapping[str, Any]) -> None:
        """Change quality knobs that are read each frame (`LIVE`): nothing is made anew. SettingError for others."""
        checked = checked_live(changes)
        if any(self.settings[key] != value for key, value in checked.items()):
            self.settings.update(checked)
            for planet in self.planets.values():
                planet.retuned()

    def try_again(self) -> None:
        """Switch on again what was switched off because it raised."""
        for planet in self.planets.values():
            planet.try_again()

    def release(self) -> None:
        """Free every GL object; may be called twice. With a lost context they are gone already."""
        if self.released:
            return
        if not self.context.watch.lost:
            with self.current():
                for view in self._added:
                    view.release()
                self.planets.release()
        self.released = True
        self.context.release()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    # -- looking inside ------------------------------------------------------------------------------------------------

    @property
    def render_scale(self) -> float:
        """Rows that `render_to` draws for each row of the viewport, which it then fills; with `depth` always 1."""
        return self._render_scale

    @render_scale.setter
    def render_scale(self, scale: float) -> None:
        if not 0.05 <= scale <= 4.0:  # nan is neither
            raise SettingError(f"render_scale: expected a number from 0.05 to 4, found {scale!r}")
        self._render_scale = scale

    def gate_again(self) -> None:
        """With the next frame, look again at which systems run, and compile."""
        for planet in self.planets.values():
            planet.gate_again()

    @property
    def systems(self) -> tuple[System, ...]:
        """All systems that the scene's own planet needs or has needed, running or not, in the order of updates."""
        return self.own.systems

    @property
    def running(self) -> tuple[System, ...]:
        """The systems that draw the scene's own planet as it is."""
        return self.own.running

    @property
    def views(self) -> Views:
        """What systems of the scene's own planet keep for each view."""
        return self.own.views

    @property
    def faults(self) -> Faults:
        """Systems that are switched off because they raised; see `tolerant`."""
        return self.own.faults

    def system(self, name: str) -> System | None:
        """The active system of that name, or None; in a scene of several planets that of the planet which the last
        frame's camera was near, as for all below."""
        return self._planet.system(name)

    @property
    def world(self) -> World:
        """The entities of the planet that is drawn, with what its systems publish, such as "height_field"
        (`resource`): the scene's own world holds none of this, since a scene may have several renderers."""
        return self._planet.world

    def height_field(self) -> HeightField | None:
        """The ground that is drawn, at full detail on the CPU; None without Terrain. See Scene.height_field."""
        return self._planet.ground.field()

    @property
    def stats(self) -> dict[str, int]:
        """Cells, vertices and triangles drawn in the last frame, ground and sea together. Reads back from the GPU."""
        with self.current():
            return statistics(self._planet.running)

    @property
    def memory_bytes(self) -> dict[str, int]:
        """GPU memory of textures and buffers by owner: systems by name, "graph" for what frames share; in a scene of
        several planets the sum over all."""
        found: Counter[str] = Counter()
        for gpu in self._gpus:
            found.update(gpu.memory_bytes())
        return dict(found)

    @property
    def shader_errors(self) -> list[ShaderError]:
        """The current error of each program that could not be rebuilt after a change on disk, of all planets."""
        found = {str(error): error for gpu in self._gpus for error in gpu.shaders.errors}
        return list(found.values())

    @property
    def _gpus(self) -> list[Gpu]:
        return [planet.gpu for planet in self.planets.values()]
