"""RenderView: one more picture of a renderer's scene, for split screens, maps and mirrors. It shares tiles and tables.

    map_view = renderer.add_view((256, 256))
    renderer.render_to(framebuffer, camera, viewport=(0, 0, 640, 720))
    map_view.render_to(framebuffer, from_above, viewport=(640, 464, 256, 256))

A renderer draws one view at a time. What belongs to a view alone (its frame graph with its textures, what the last
frame showed, where its camera stood) is put in the renderer's place while the view draws; what systems keep for a view
goes by the view's index in their own tables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike, NDArray

from ..camera.arguments import check_size
from ..errors import SettingError
from ..systems.composite import CompositeSystem
from .rest import Rest
from .standpoint import Standpoint
from .stillness import Stillness

if TYPE_CHECKING:
    import moderngl

    from ..camera.camera import Camera
    from ..camera.views import View
    from ..engine.graph import Plan
    from ..engine.space import CameraState
    from .host_space import HostDepth
    from .renderer import Renderer
    from .snapshot import Snapshot

__all__ = ["RenderView"]


class RenderView:
    """A further view of a renderer's scene. Made by `Renderer.add_view`; has the renderer's own methods for pictures.

    Shared with the renderer and its other views: scene, quality, programs, ground tiles, the air's tables, clouds'
    volumes, meshes, maps. Its own: size, textures of the frame, exposure and anti-aliasing, meshes of what it sees.
    release() frees those; releasing the renderer does too. One thread, the renderer's.
    """

    def __init__(self, renderer: Renderer, size: tuple[int, int], inner: bool = False) -> None:
        """inner: for a picture that another planet's camera needs; nobody else sees it."""
        check_size(size, renderer.gpu.caps.max_texture_size)
        self.inner = inner
        taken = {view.index for view in renderer._views}
        self.renderer = renderer
        self.index = next(n for n in range(1, len(taken) + 2) if n not in taken)
        """The systems' own number for it, the lowest that is free: what they keep for a view serves the next one."""
        self.released = False
        # Named as the renderer's own attributes, in whose place they are put.
        self._held: dict[str, Any] = {
            "size": (int(size[0]), int(size[1])),
            "_view_index": self.index,
            "_plan": None,
            "_plan_key": (),
            "_exports": frozenset({"composite.ldr"}),
            "_frame": None,
            "_frame_index": 0,
            "_cut": True,
            "_host_depth": None,
            "_stand": Standpoint(renderer.scene, renderer._ground),
            "_stillness": Stillness(renderer.scene),
            "_rest": Rest(renderer.scene),
        }
        renderer._views.append(self)

    @contextmanager
    def _drawing(self) -> Iterator[Renderer]:
        renderer = self.renderer
        if self.released or renderer.released:
            raise SettingError("this view has been released: make a new one with renderer.add_view(size)")
        outer = {name: getattr(renderer, name) for name in self._held}
        vars(renderer).update(self._held)
        try:
            yield renderer
        finally:
            self._held = {name: getattr(renderer, name) for name in outer}
            vars(renderer).update(outer)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self._held["size"]

    def render(
        self,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Any = None,
        outputs: Sequence[str] = ("color",),
        dt_s: float | None = None,
    ) -> dict[str, NDArray[Any]]:
        """As Renderer.render."""
        with self._drawing() as renderer:
            return renderer.render(camera, time_s, sun, outputs, dt_s)

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
        """As Renderer.render_to."""
        with self._drawing() as renderer:
            renderer.render_to(framebuffer, camera, time_s, sun, viewport, dt_s, depth)

    def settle(
        self,
        camera: Camera | View,
        time_s: float | None = None,
        sun: Any = None,
        timeout_s: float | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """As Renderer.settle."""
        with self._drawing() as renderer:
            renderer.settle(camera, time_s, sun, timeout_s, progress)

    def snapshot(self, camera: Camera | View, time_s: float | None = None, settle: bool = True) -> Snapshot:
        """As Renderer.snapshot."""
        with self._drawing() as renderer:
            return renderer.snapshot(camera, time_s, settle)

    def resize(self, size: tuple[int, int]) -> None:
        """As Renderer.resize; the other views keep their sizes."""
        with self._drawing() as renderer:
            renderer.resize(size)

    def project(self, camera: Camera | View, points_m: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """As Renderer.project."""
        with self._drawing() as renderer:
            return renderer.project(camera, points_m)

    def pick(self, camera: Camera | View, x: float, y: float) -> tuple[NDArray[Any], str] | None:
        """As Renderer.pick."""
        with self._drawing() as renderer:
            return renderer.pick(camera, x, y)

    def height_drawn(self, directions: ArrayLike) -> NDArray[Any]:
        """As Renderer.height_drawn, of what this view shows."""
        with self._drawing() as renderer:
            return renderer.height_drawn(directions)

    def camera_state(self, camera: Camera | View) -> CameraState:
        """As Renderer.camera_state."""
        with self._drawing() as renderer:
            return renderer.camera_state(camera)

    def passes(self) -> list[Any]:
        """As Renderer.passes, of this view's last frame."""
        with self._drawing() as renderer:
            return renderer.passes()

    @property
    def graph(self) -> Plan:
        """As Renderer.graph: this view's own."""
        with self._drawing() as renderer:
            return renderer.graph

    def outdated(self) -> None:
        """A shader has changed: what was made with the old one is made again."""
        plan = self._held["_plan"]
        if plan is not None:
            plan.invalidate_persistent()
        self._held["_rest"].forget()

    def release(self) -> None:
        """Free what is this view's alone; may be called twice."""
        if self.released:
            return
        if not self.renderer.released:
            with self._drawing() as renderer, renderer.current():
                if renderer._plan is not None:
                    renderer._plan.release()
                composite = renderer.system("composite")
                if isinstance(composite, CompositeSystem):
                    composite.view_gone()
                renderer.views.release(self.index)
            renderer = self.renderer
            renderer._rest.forget()
            renderer._stillness.forget()  # what systems said last, they said of this view
            self.renderer._views.remove(self)
        self.released = True

    def __enter__(self) -> RenderView:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def __repr__(self) -> str:
        width, height = self.size
        return f"<RenderView {self.index} of {self.renderer.scene.name!r}: {width} x {height}>"
