"""The GL context that a renderer draws in: a headless one of its own, or a host's, whose state it gives back."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from ..engine.gpu import Gpu
from ..engine.hosts.foreign import ForeignHost, attach
from .context_loss import ContextWatch, Place

if TYPE_CHECKING:
    import moderngl

    from ..scene.scene import Scene

__all__ = ["RenderContext"]


class RenderContext:
    """ctx: a host's, or None for one of its own. guard: give the host its state back after every call. place: where
    the last frame's camera was, for the message when the context is lost."""

    def __init__(
        self,
        scene: Scene,
        ctx: moderngl.Context | None,
        guard: bool,
        shaders: Iterable[Path],
        place: Callable[[], Place],
    ) -> None:
        self._shaders = list(shaders)
        self.host: ForeignHost | None = None
        """The host whose state is given back; None: nobody waits for it."""
        if ctx is None:
            from ..engine.hosts.headless import create_headless

            self.gpu = Gpu(create_headless(), self._shaders, compile_ahead=True)
        else:
            host = attach(ctx, self._shaders, compile_ahead=True)
            self.gpu, self.host = host.gpu, host if guard else None
        self.own, self.ctx = ctx is None, self.gpu.ctx
        self.watch = ContextWatch(scene, self.gpu.gl, self._errors, place)

    def another_gpu(self) -> Gpu:
        """Programs, objects and counters of their own in the same context, for one more planet."""
        return Gpu(self.ctx, self._shaders, compile_ahead=True)

    def current(self, framebuffer: moderngl.Framebuffer | None = None) -> AbstractContextManager[object]:
        """The context current, a host's state safe. framebuffer: of the host's, if it is to be drawn into.
        ContextLostError when it is gone."""
        self.watch.check()
        if self.own:
            # A program may have several renderers, each with its own context. It stays current: reading a buffer
            # between frames then works as with a single one.
            self.ctx.__enter__()
            return nullcontext()
        return nullcontext() if self.host is None else self.host.guest(framebuffer)

    def release(self) -> None:
        """Let go of a context of our own."""
        if self.own:
            self.ctx.release()

    def _errors(self) -> Iterable[str]:
        guard = None if self.host is None else self.host.guard
        return () if guard is None else (*guard.errors, *guard.errors_before)
