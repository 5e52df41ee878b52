"""Picture: one picture of a scene, from whichever planet its camera is near; what Renderer and RenderView share."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera.arguments import check_moment, check_size
from ..camera.camera import Camera
from ..engine.frame.gbuffer import Surface
from ..engine.space import CameraState, pixel_rays, project, ray_sphere_from
from ..engine.uncollected import uncollected
from ..engine.wavelengths import wavelengths_of
from ..query.arguments import checked_directions
from ..scene.companions import bodies
from ..systems.composite import CompositeSystem
from .drawn_camera import CameraResolver
from .drawn_view import LDR, PICTURE, DrawnView
from .faults import draw_without_faults
from .labels import material_names
from .lens_picture import FaceView, LensPicture
from .outputs import Shot, exports_for, read_outputs
from .planet import Moment, Wanted
from .queries import height_drawn
from .settling import settle
from .snapshot import Snapshot

if TYPE_CHECKING:
    import moderngl

    from ..camera.views import View
    from ..components import Sun
    from ..engine.frame import Frame
    from ..engine.gpu import Gpu
    from ..engine.graph import PassReport, Plan
    from ..scene.scene import Scene
    from .host_space import HostDepth
    from .planet import PlanetRenderer
    from .planets import DrawRequest, Planets
    from .watch import Watch

__all__ = ["Picture", "PictureOwner"]

_TARGETS = frozenset({"target", "target_with_depth"})
_Y_DOWN = np.array([1.0, -1.0, 1.0])
"""From our camera axes to those of Intrinsics, and back."""


class PictureOwner(Protocol):
    """What the pictures of one renderer share."""

    settings: dict[str, Any]
    scene: Scene
    gpu: Gpu
    planets: Planets
    watch: Watch
    tolerant: bool
    python_ms: float
    released: bool

    @property
    def render_scale(self) -> float: ...
    def current(self, framebuffer: moderngl.Framebuffer | None = None) -> AbstractContextManager[object]: ...
    def add_view(self, size: tuple[int, int]) -> FaceView: ...


class Picture:
    """One picture: its size, and for each planet that it was taken near what lasts from frame to frame."""

    def __init__(self, owner: PictureOwner, size: tuple[int, int], is_added: bool) -> None:
        """is_added: made by add_view, not the renderer's own."""
        check_size(size, owner.gpu.caps.max_texture_size)
        self._owner, self._is_added = owner, is_added
        self.size = (int(size[0]), int(size[1]))
        """(width, height) in pixels, for cameras without intrinsics, which bring their own."""
        self._resolved = CameraResolver(owner.scene)
        self._views: dict[str, DrawnView] = {}
        self._front = ""  # until the first frame
        self._request_ms = 0.0
        self._given: tuple[str, CameraState] | None = None
        """The planet and the camera of the last frame that was given out."""
        self._lens = LensPicture(self, owner)
        self._view_of(self.main)
        owner.planets.gone.append(self._forget)

    # -- pictures ----------------------------------------------------------------------------------------------------

    @property
    def wavelengths_nm(self) -> tuple[float, float, float]:
        """At which wavelengths light is carried and radiance given out, red first: the knob "light.wavelengths"."""
        return wavelengths_of(self._owner.settings)

    @property
    def materials(self) -> dict[int, str]:
        """Number -> name of what the output `material` tells apart: "none", "water" and others, and the ground's
        materials, those that a game has registered among them."""
        return material_names()

    def render(
        self,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Sun | None = None,
        outputs: Sequence[str] = ("color",),
        dt_s: float | None = None,
    ) -> dict[str, NDArray[Any]]:
        """One frame as arrays of shape (H, W[, C]), row 0 on top; never blocks on streaming.

        outputs: any of color (u8, 3, sRGB), radiance (f32, 3, W m^-2 sr^-1 nm^-1 at `wavelengths_nm`, before exposure),
        distance (f32, m along the ray, inf where nothing was hit), position (f32, 3, m from the camera in planet axes,
        NaN), normal (f32, 3, 0), surface (u8: 0 none, 1 terrain, 2 sea, 3 props, 4 trees), or the name of any texture
        of the frame graph. And labels, for the sky as said: depth (f32, m along the axis, inf), slope_deg (f32, of the
        surface to the horizontal, NaN), flow (f32, 2, pixels right and down to the camera of the frame before, of
        directions), sunlit (f32, 0..1 of the sun's disc, 0), albedo (f32, 3, at `wavelengths_nm`, 0), material (u8, see
        `materials`, 0), instance (u32: a prop's entity, a tree's number, 0 for all else).
        camera: a Camera, or a View, which brings its own sun, time and exposure. One with intrinsics brings the size of
        the picture; where its lens has no ray, distance, depth and position are NaN, all else is 0. Through a lens that
        bends there is no flow. time_s: moves water and weather, and an epoch sun. sun: a Sun component that replaces
        the scene's.
        dt_s: time since the last frame, for a frame of a sequence: exposure adapts, and anti-aliasing builds on the
        frames before. Without it the picture stands for itself, the same whatever was rendered before, unless this
        very moment was settled: then it shows the settled picture.
        """
        exports = exports_for(outputs)
        if _has_lens(camera):
            return self._lens.render(camera, time_s, sun, outputs, dt_s)
        wanted = Wanted(exports, dt_s, one_shot=dt_s is None, exact=bool(exports - PICTURE))
        names = tuple(outputs)
        with self._current():
            request = self._request(camera, time_s, sun)
            view = self._drawn(request, wanted)
            shot = self._shot(request, view)
            return request.arrays_in_scene(read_outputs(view.compiled(), names, shot))

    def render_to(
        self,
        framebuffer: moderngl.Framebuffer,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Sun | None = None,
        viewport: tuple[int, int, int, int] | None = None,
        dt_s: float | None = None,
        depth: HostDepth | None = None,
    ) -> None:
        """One frame into a framebuffer of the host's, at viewport (x, y, width, height; default: all of it).

        The renderer takes the viewport's size, times `render_scale`; a camera with intrinsics keeps its own, and fills
        the viewport with that picture. The host's GL state stays (see `guard`).
        depth: how the framebuffer's depth buffer stores distances (`HostSpace.depth`): what the host has drawn before
        stays where it is nearer, and what it draws afterwards stands in the planet's world. None: over everything.
        CameraError with depth for a lens that bends straight lines.
        """
        owner = self._owner
        x, y, width, height = viewport or (0, 0, *framebuffer.size)
        if _has_lens(camera):
            self._lens.check_depth(camera, depth)
            color = self._lens.render(camera, time_s, sun, ("color",), dt_s)["color"]
            with self._current(framebuffer):
                framebuffer.viewport = (x, y, width, height)
                self._lens.draw(owner.gpu, color, framebuffer)
            return
        with self._current(framebuffer):
            request = self._request(camera, time_s, sun)
            if camera.optics.size is None:
                limit = request.planet.memory.scale((width, height))
                scale = 1.0 if depth is not None else min(owner.render_scale, limit)
                self._resize((max(round(scale * width), 1), max(round(scale * height), 1)))
                self._front_view.resize(self.size)
            framebuffer.viewport = (x, y, width, height)
            name = "target" if depth is None else "target_with_depth"
            shared = None if depth is None else (depth.offset, depth.scale_m)
            wanted = Wanted(frozenset({name}), dt_s, framebuffer, shared)
            if owner.tolerant:
                view = self._view_of(request.planet.scene.planet.name)
                draw_without_faults(request.planet, lambda: self._draw(request, view, wanted), view.failed_system)
            else:
                view = self._drawn(request, wanted)
            self._shot(request, view)

    def settle(
        self,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Sun | None = None,
        timeout_s: float | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Render until exposure and everything that refines over frames has converged: pictures become deterministic.

        progress(share) is called after each frame. NotSettled after timeout_s, naming what had not settled.
        """
        if _has_lens(camera):
            return self._lens.settle(camera, time_s, sun, timeout_s, progress)
        with self._current():
            request = self._request(camera, time_s, sun)
        view = self._front_view
        view.cut = True

        def frame() -> None:
            self._draw(request, view, Wanted(view.exports - _TARGETS | {LDR}, 10.0, settling=True))

        settle(frame, view, lambda: request.planet.running, self._current, timeout_s, progress)

    def snapshot(
        self, camera: Camera | View, time_s: float | None = None, settle: bool = True, sun: Sun | None = None
    ) -> Snapshot:
        """A picture that shows itself in notebooks; .array, .save(path). settle: first, as `settle` does."""
        if settle:
            self.settle(camera, time_s, sun)
        return Snapshot(self.render(camera, time_s, sun)["color"])

    def resize(self, size: tuple[int, int]) -> None:
        """A new picture size; history (exposure) starts again only where it must. Other views keep theirs."""
        with self._current():
            self._resize(size)
            self._front_view.resize(self.size)

    def _current(self, framebuffer: moderngl.Framebuffer | None = None) -> AbstractContextManager[object]:
        self._check()
        current = self._owner.current(framebuffer)
        return current if self._front else uncollected(current)  # the first picture sets up all there is

    def _check(self) -> None:
        """Raise SettingError where it has been released."""

    def _resize(self, size: tuple[int, int]) -> None:
        check_size(size, self._owner.gpu.caps.max_texture_size)
        self.size = (int(size[0]), int(size[1]))

    def _request(self, camera: Camera | View, time_s: float | None, sun: Sun | None, draws: bool = True) -> DrawRequest:
        """Which planet is drawn, with its view ready if something is. The context is current. SizeError for a picture
        that the GPU can't draw."""
        started = time.perf_counter()
        check_moment(camera, time_s, sun)
        planets = self._owner.planets
        if planets.several and planets.take_company_change():
            planets.keep_up()
        request = planets.request(self._resolved.resolve(camera), time_s, sun)
        before, self._front = self._front, request.planet.scene.planet.name
        if before not in ("", self._front) and not self._is_added:
            planets.hand_over(before, self._front)
        if draws:
            size = self._size_for(camera)
            check_size(size, self._owner.gpu.caps.max_texture_size)
            self._front_view.resize(size)
        self._request_ms = (time.perf_counter() - started) * 1e3
        return request

    def _size_for(self, camera: Camera) -> tuple[int, int]:
        """(width, height) of a camera's picture."""
        return camera.optics.size or self.size

    def _drawn(self, request: DrawRequest, wanted: Wanted) -> DrawnView:
        view = self._front_view
        self._draw(request, view, wanted)
        return view

    def _draw(self, request: DrawRequest, view: DrawnView, wanted: Wanted) -> None:
        owner, planet = self._owner, request.planet
        state = view.camera.state(request.camera, view.size)
        moment = Moment(state, request.sun, request.time_s, request.camera.optics.ev100)
        if planet.draw(view, moment, wanted):
            owner.watch.after_frame(owner.scene, view, planet.running)
        owner.python_ms = self._request_ms + planet.python_ms

    def _shot(self, request: DrawRequest, view: DrawnView) -> Shot:
        """What the frame that was just given out was taken with; it is then the one before."""
        name, state = request.planet.scene.planet.name, view.camera.state(request.camera, view.size)
        before, self._given = self._given, (name, state)
        return Shot(state, before[1] if before is not None and before[0] == name else None, view.size)

    def _view_of(self, name: str) -> DrawnView:
        """This picture over one of the planets."""
        self._check()
        view = self._views.get(name)
        if view is None:
            planet = self._owner.planets[name]
            view = self._views[name] = planet.add_view(self.size) if self._is_added else planet.first_view
        return view

    def _forget(self, name: str) -> None:
        """A planet's renderer is to be released."""
        self._views.pop(name, None)
        if self._front == name:
            self._front = ""

    def _release_views(self) -> None:
        """Free what belongs to this picture alone. The context is current."""
        self._lens.release()
        planets = self._owner.planets
        for name, view in self._views.items():
            planets[name].release_view(view)
        self._views.clear()
        planets.gone.remove(self._forget)

    @property
    def _planet(self) -> PlanetRenderer:
        """The renderer of the planet that the last frame's camera was near."""
        return self._owner.planets[self.main]

    @property
    def _front_view(self) -> DrawnView:
        """Over that planet."""
        return self._view_of(self.main)

    # -- questions ----------------------------------------------------------------------------------------------------

    @property
    def main(self) -> str:
        """The name of the planet that the last frame's camera was near: the only one, or the one that no other planet
        can stand before."""
        return self._front or self._owner.planets.own_name

    def camera_state(self, camera: Camera | View) -> CameraState:
        """The camera in f64 as the renderer uses it: resolved against the scene's ground, lifted out of it if need
        be."""
        with self._current():
            request = self._request(camera, None, None, draws=False)
            return request.camera_in_scene(self._front_view.camera.state(request.camera, self._size_for(camera)))

    def project(self, camera: Camera | View, points_m: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Pixels (N, 2), row 0 on top, of points (N, 3) in planet axes, and which lie in front of the camera; of a
        camera with intrinsics: which its lens sees."""
        state, points = self.camera_state(camera), np.atleast_2d(np.asarray(points_m, np.float64))
        lens = camera.optics.intrinsics
        if lens is None:
            return project(state, points, self.size)
        return lens.project((points - state.position_m) @ state.axes.T * _Y_DOWN)

    def pick(self, camera: Camera | View, x: float, y: float) -> tuple[NDArray[np.float64], str] | None:
        """What pixel (x, y) shows: position_m (3,) f64 in planet axes and "terrain", "sea" or "props"; None for the
        sky."""
        check_moment(camera, None, None)
        width, height = self._size_for(camera)
        if not (0.0 <= x < width and 0.0 <= y < height):
            raise ValueError(f"pick: pixel ({x}, {y}) is outside the picture of {width} x {height}")
        column, row = int(x), int(y)
        lens, outputs = camera.optics.lens, ("position", "surface")
        if lens is None:
            given = self._given
            arrays = self.render(camera, outputs=outputs)
            self._given = given  # a question is no frame of a sequence
        elif np.isnan(lens.rays([(column + 0.5, row + 0.5)])).any():
            return None
        else:
            arrays = self._lens.render(camera, None, None, outputs, None, pixel=row * width + column)
        surface = int(arrays["surface"][row, column])
        if surface == 0:
            return None
        position = self.camera_state(camera).position_m + arrays["position"][row, column].astype(np.float64)
        return position, Surface(surface).name.lower()

    def planet_at(self, camera: Camera | View, x: float, y: float, time_s: float = 0.0) -> str | None:
        """The name of the planet whose sphere pixel (x, y) shows, or shows next behind hills; None for the sky."""
        scene = self._owner.scene
        found = {body.name: body for body in bodies(scene, time_s)}
        home = found[camera.planet_in(scene).name]
        state = self.camera_state(camera)
        lens = camera.optics.intrinsics
        ray = (
            pixel_rays(state, self.size, [(x, y)])[0] if lens is None else lens.rays([(x, y)])[0] * _Y_DOWN @ state.axes
        )
        if np.isnan(ray[0]):
            return None
        look = home.axes @ ray
        eye = home.outside(state.position_m)
        hits = {b.name: float(ray_sphere_from(eye - b.centre_m, look, b.radius_m).near_m) for b in found.values()}
        first = min(hits, key=lambda name: hits[name])
        return first if math.isfinite(hits[first]) else None

    def height_drawn(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Heights (N,) in metres of the ground as the last frame's level of detail shows it; NaN where it drew none.

        ValueError for anything but directions (N, 3), finite and not zero.
        """
        unit = checked_directions("directions", directions)
        with self._current():
            return height_drawn(self._planet, self._front_view, unit)

    # -- looking inside ------------------------------------------------------------------------------------------------

    @property
    def exposure(self) -> float | None:
        """EV100 of the last picture; None before the first and after one without colours. Reads back from the GPU."""
        composite = self._planet.system("composite")
        if not isinstance(composite, CompositeSystem) or not composite.exposed(self._front_view):
            return None
        with self._current():
            return composite.reading(self._front_view).ev100

    def passes(self) -> list[PassReport]:
        """What ran in the last frame and what was skipped, and why: PassReport objects of the frame graph."""
        return list(self.graph.passes)

    @property
    def refining(self) -> tuple[str, ...]:
        """What is still being made of what the last frame showed, such as "ground 63 %"; empty when all is there."""
        view = self._front_view
        return tuple(text for system in self._planet.running if (text := system.refining(view)))

    @property
    def graph(self) -> Plan:
        """The compiled frame graph: explain(), to_mermaid(), memory_bytes(), resource()."""
        return self._front_view.compiled()

    @property
    def frame(self) -> Frame | None:
        """What the systems were told of the last frame; None before the first."""
        return self._front_view.latest

    @property
    def frames(self) -> int:
        """Frames that were shown over the planet that the last one was near."""
        return self._front_view.frames


def _has_lens(camera: Any) -> bool:
    """Whether its picture is resampled; False for what isn't a camera, which `check_moment` refuses."""
    return isinstance(camera, Camera) and camera.optics.lens is not None
