"""The clouds' own picture: its size beside the frame's, and the surfaces that its rays end at."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...engine.frame import ViewInfo
from ...engine.gpu import Fullscreen, GpuScope
from ...engine.gpu import gl as G
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.settings import Settings

__all__ = ["SURFACE", "CloudPicture", "Surface"]

SURFACE = "clouds.surface"


@dataclass(frozen=True)
class CloudPicture:
    """pixel_px: pixels of the frame that one of the clouds' has a side; stride: of the clouds' own that share a ray."""

    pixel_px: int
    stride: int

    @classmethod
    def of(cls, settings: Settings) -> CloudPicture:
        """From the settings' knobs."""
        return cls(int(settings["clouds.picture_px"]), int(settings["clouds.stride"]))

    @property
    def defines(self) -> Mapping[str, Any]:
        """Of clouds/view_ray.glsl."""
        return {"STRIDE": self.stride, "PICTURE_PX": self.pixel_px}

    @property
    def block_px(self) -> int:
        """Pixels of the frame a side for each ray."""
        return self.pixel_px * self.stride

    @property
    def depth(self) -> str:
        """The resource that rays end at."""
        return "gbuffer.depth" if self.pixel_px == 1 else SURFACE

    def size(self, frame: tuple[int, int]) -> tuple[int, int]:
        """Of the clouds' picture."""
        return -(-frame[0] // self.pixel_px), -(-frame[1] // self.pixel_px)

    def rays(self, frame: tuple[int, int]) -> tuple[int, int]:
        """How many rays across and down."""
        across, down = self.size(frame)
        return -(-across // self.stride), -(-down // self.stride)


class Surface:
    """The depth up to which a frame's clouds were followed, kept for the next one: the frame's own, copied; or pass
    ``clouds.surface`` draws it for a coarser picture before any ray asks for it."""

    def __init__(self, gpu: GpuScope, picture: CloudPicture) -> None:
        self._gpu, self._picture = gpu, picture
        self._coarse: Fullscreen | None = None
        if picture.pixel_px > 1:
            self._coarse = gpu.fullscreen("clouds/surface.frag")
            self._plain = gpu.state()

    def declare(self, builder: GraphBuilder, view: ViewInfo, system: str) -> tuple[TextureSpec, ...]:
        """What is left to be created by whoever copies it."""
        size = self._picture.size(view.size)
        if self._coarse is None:
            return (TextureSpec(SURFACE, "depth32f", size, "history", help="depth up to which they were followed"),)
        builder.add_pass(
            "clouds.surface",
            bind=self._bind_coarse,
            system=system,
            reads=("gbuffer.depth",),
            creates=(TextureSpec(SURFACE, "r32f", size, "history", help="depth up to which they are followed"),),
            help="depth of the clouds' own, coarser picture",
        )
        return ()

    def _bind_coarse(self, io: PassIO) -> Callable[[], None]:
        target, depth, coarse = io.framebuffer(colors=(SURFACE,)), io.texture("gbuffer.depth"), self._coarse
        assert coarse is not None

        def run() -> None:
            target.use()
            self._plain.apply()
            depth.use(0)
            coarse.render()

        return run

    def bind_copy(self, io: PassIO) -> Callable[[], None]:
        """To be called when all that asks for the last frame's has run."""
        if self._coarse is not None:
            return lambda: None
        gl, depth, surface = self._gpu.gl, io.texture("gbuffer.depth"), io.texture(SURFACE)

        # A copy: storing each pixel's depth in the shader takes twenty times as long without a GPU.
        def run() -> None:
            gl.copy_layers(G.TEXTURE_2D, depth.glo, 0, surface.glo, 0, (*surface.size, 1))

        return run

    def bind_hold(self, io: PassIO) -> Callable[[], None]:
        """To be called instead where the last frame's clouds go on being shown: they end where they did."""
        gl, before, surface = self._gpu.gl, io.history(SURFACE), io.texture(SURFACE)

        def run() -> None:
            gl.copy_layers(G.TEXTURE_2D, before.glo, 0, surface.glo, 0, (*surface.size, 1))

        return run
