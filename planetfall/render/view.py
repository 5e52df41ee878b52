"""RenderView: one more picture of a renderer's scene, for split screens, maps and mirrors. It shares tiles and tables.

map_view = renderer.add_view((256, 256))
renderer.render_to(framebuffer, camera, viewport=(0, 0, 640, 720))
map_view.render_to(framebuffer, from_above, viewport=(640, 464, 256, 256))
"""

from __future__ import annotations

from ..errors import SettingError
from .picture import Picture, PictureOwner

__all__ = ["RenderView"]


class RenderView(Picture):
    """A further view of a renderer's scene. Made by `Renderer.add_view`; has the renderer's own methods for pictures.

    Shared with the renderer and its other views: scene, quality, programs, ground tiles, the air's tables, clouds'
    volumes, meshes, maps. Its own: size, textures of the frame, exposure and anti-aliasing, meshes of what it sees.
    release() frees those; releasing the renderer does too. One thread, the renderer's.
    """

    def __init__(self, renderer: PictureOwner, size: tuple[int, int]) -> None:
        self.renderer = renderer
        self.released = False
        super().__init__(renderer, size, is_added=True)

    @property
    def index(self) -> int:
        """The systems' number for it over the planet that it was near last: the lowest that was free."""
        return self._front_view.index

    def _check(self) -> None:
        if self.released or self.renderer.released:
            raise SettingError("this view has been released: make a new one with renderer.add_view(size)")

    def release(self) -> None:
        """Free what is this view's alone; may be called twice."""
        if self.released:
            return
        if not self.renderer.released:
            with self.renderer.current():
                self._release_views()
        self.released = True

    def __enter__(self) -> RenderView:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def __repr__(self) -> str:
        width, height = self.size
        return f"<RenderView of {self.renderer.scene.name!r}: {width} x {height}>"
