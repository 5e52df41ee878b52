"""Guest in somebody else's window: takes the host's moderngl context, never makes one, and leaves no trace in it.

    host = attach(ctx, [ASSETS / "shaders"])      # once
    with host.guest(framebuffer):                 # every frame
        ...draw with host.gpu...

A second `moderngl.create_context()` would give another Context object on the same GL context, with its own idea of
what is bound; so the host's object is asked for. Hosts without moderngl (pyglet, pygame, Qt) make one themselves, once,
with `moderngl.create_context()` while their context is current.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType

import moderngl

from ..blocks.bindings import POINTS
from ..gpu import Gpu
from ..gpu.guard import StateGuard

__all__ = ["ForeignHost", "attach"]


class ForeignHost:
    """A host's context with what we need to render in it. Made by `attach`.

    Attributes:
        ctx: the host's moderngl context.
        gpu: our Gpu on it.
        guard: the StateGuard around our frames; replaced by `fit`.
    """

    def __init__(self, gpu: Gpu, guard: StateGuard) -> None:
        self.gpu = gpu
        self.guard = guard
        self.ctx: moderngl.Context = gpu.ctx

    def fit(
        self,
        texture_units: int = POINTS["texture unit"],
        ubo_bindings: int = POINTS["uniform block"],
        ssbo_bindings: int = POINTS["storage buffer"],
        image_units: int = POINTS["image"],
    ) -> None:
        """Guard only the bindings that a compiled plan uses: every unit less saves about 2 us a frame."""
        self.guard = StateGuard(self.gpu, texture_units, ubo_bindings, ssbo_bindings, image_units)

    @contextlib.contextmanager
    def guest(self, framebuffer: moderngl.Framebuffer | None = None) -> Iterator[StateGuard]:
        """Draw inside: afterwards the host's GL state, its framebuffer's settings and GL's error flag are as before.

        framebuffer: what we draw into, if its viewport, scissor and masks should be kept as well. The framebuffer that
        is bound on entry always is. Setting up, hot reload and release belong into a `guest` too: they bind things.
        """
        self.guard.framebuffers = () if framebuffer is None else (framebuffer,)
        with self.guard:
            yield self.guard

    def release(self) -> None:
        """Free all GL objects of ours. The context stays: it is the host's."""
        with self.guard:
            self.gpu.release()

    def __enter__(self) -> ForeignHost:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


def attach(ctx: moderngl.Context, shader_roots: Iterable[Path | str] = (), compile_ahead: bool = False) -> ForeignHost:
    """Become a guest in the host's context, which must be current. compile_ahead: as Gpu has it.

    Raises:
        GLVersionError: the context is older than OpenGL 4.3 core; names what was found.
        TypeError: not a moderngl context; says how to make one in a host without moderngl.
    """
    if not isinstance(ctx, moderngl.Context):
        raise TypeError(
            f"expected the host's moderngl.Context, found {type(ctx).__name__}. In a host without moderngl call "
            "moderngl.create_context() once, while its OpenGL context is current, and pass the result."
        )
    gpu = Gpu(ctx, shader_roots, compile_ahead=compile_ahead)
    return ForeignHost(gpu, StateGuard(gpu))
