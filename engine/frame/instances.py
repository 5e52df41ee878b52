"""InstancePass: numbers of things that stand on their own, into the texture outputs.instance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..blocks.bindings import INSTANCE_BUFFER
from ..gpu import GpuScope, Program
from ..gpu.growing import GrowingBuffer
from ..graph import GraphBuilder, PassIO
from .gbuffer import Surface
from .labels import LABELS

__all__ = ["InstancePass"]

_INSTANCE = LABELS[1]


class InstancePass:
    """Draws a system's things a second time, while somebody reads their numbers.

    vertex: file of a shader that has v_instance of instance k as `numbers[k]`. surface: what the G-buffer has where
    such a thing is seen.
    """

    def __init__(self, gpu: GpuScope, vertex: str, surface: Surface) -> None:
        self._gpu, self._vertex, self._surface = gpu, vertex, surface
        self._made: tuple[Program, GrowingBuffer] | None = None
        self._state = gpu.state(depth_test=False, cull=None, blend=None)

    def declare(
        self,
        builder: GraphBuilder,
        system: str,
        numbers: Callable[[], NDArray[np.uint32]],
        draw: Callable[[Program], None],
        stage: str,
        only_while: Callable[[], bool] | None = None,
    ) -> None:
        """numbers: (N,) of this frame's instances. draw: all of them, with a program. stage: as they are drawn in."""
        builder.add_pass(
            f"{system}.instance",
            system=system,
            bind=lambda io: self._bind(io, numbers, draw),
            reads=("gbuffer.depth", "gbuffer.surface"),
            writes=(_INSTANCE,),
            stage=stage,
            only_while=only_while,
            help="which one each pixel shows",
        )

    def _bind(
        self, io: PassIO, numbers: Callable[[], NDArray[np.uint32]], draw: Callable[[Program], None]
    ) -> Callable[[], None]:
        if self._made is None:  # most programs do without
            defines = {"INSTANCE_SURFACE": f"SURFACE_{self._surface.name}"}
            program = self._gpu.program(self._vertex, "outputs/instance.frag", defines=defines)
            self._made = program, GrowingBuffer(self._gpu, 4)
        program, buffer = self._made
        target = io.framebuffer(colors=(_INSTANCE,))
        depth, surface = io.texture("gbuffer.depth"), io.texture("gbuffer.surface")

        def run() -> None:
            shown = numbers()
            if not len(shown):
                return
            buffer.write(shown)
            target.use()
            self._state.apply()
            depth.use(0)
            surface.use(1)
            buffer.buffer.bind_to_storage_buffer(INSTANCE_BUFFER)
            draw(program)

        return run
