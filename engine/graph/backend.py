"""What the frame graph asks of a graphics API. The graph itself knows no GL: it talks to a `GraphBackend`.

Two implementations: `NullBackend` here (counts and records, for tests and for drawing the graph), and the OpenGL one
in engine/gpu. All objects that cross this border are opaque to the graph: it keeps them, hands them to passes and gives
them back to `release`.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntFlag
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from .resources import BufferSpec, TextureSpec

if TYPE_CHECKING:
    from .touches import PassWatch


class BarrierKind(IntFlag):
    """What a storage barrier must make visible: stores of compute passes into textures, into buffers, or both.

    The graph knows which resource a pass reads, not how. So TEXTURE stands for image access, sampling, attachment,
    copy and read-back; BUFFER for storage, uniform, vertex, index, indirect command, copy and read-back.
    """

    TEXTURE = 1
    BUFFER = 2


class PassTimers(Protocol):
    """GPU timers of one plan: a ring over frames with `count` slots a frame. Nothing here may ever block."""

    def begin(self, slot: int) -> None:
        """Mark the start of the pass `slot` in the current frame."""
        ...

    def end(self, slot: int) -> None:
        """Mark the end of the pass `slot` in the current frame."""
        ...

    def collect(self, out: list[float | None]) -> None:
        """Once at the end of each frame: move the ring on and write the milliseconds of the oldest frame whose
        results are there into `out` (length `count`; None for a slot that did not run in that frame). Leaves `out`
        alone when nothing is ready yet. A slot may have begun without an end when its pass raised."""
        ...

    def release(self) -> None:
        """Free the queries."""
        ...


@runtime_checkable
class GraphBackend(Protocol):
    """Creates and frees what the graph owns, and orders storage. One backend may serve several plans (views)."""

    @property
    def max_texture_size(self) -> int:
        """The largest width or height in texels; a larger resource is a GraphError before anything is created."""
        ...

    def create_texture(self, spec: TextureSpec, size: tuple[int, ...]) -> object:
        """A texture of `size` texels: (w, h) or (w, h, d); array when spec.layers > 1; `spec.levels_for(size)` levels.
        The content is undefined. spec.name is for labels only: transients of other names may share the object."""
        ...

    def create_buffer(self, spec: BufferSpec) -> object:
        """A buffer of spec.size_bytes, content undefined."""
        ...

    def framebuffer(self, colors: Sequence[Any], depth: Any | None) -> object:
        """A framebuffer on textures made by this backend. The graph owns it and releases it before its textures."""
        ...

    def release(self, obj: Any) -> None:
        """Free a texture, buffer or framebuffer made by this backend; called exactly once for each."""
        ...

    def bytes_of(self, obj: Any) -> int:
        """Bytes of a texture or buffer made by this backend."""
        ...

    def barrier(self, kinds: int) -> None:
        """Make stores of earlier compute passes visible to what follows. kinds: BarrierKind bits as an int."""
        ...

    def begin_frame(self) -> None:
        """Called first in every execute."""
        ...

    def end_frame(self) -> None:
        """Called last in every execute, also when a pass raised: put default state back."""
        ...

    @property
    def barriers_everywhere(self) -> bool:
        """Whether every pass waits for all stores before it: a picture that differs then lacks a barrier."""
        ...

    @property
    def watch(self) -> PassWatch | None:
        """Hears what passes touch, for authors; None: nobody listens."""
        ...

    def create_timers(self, count: int) -> PassTimers:
        """GPU timers for a plan of `count` passes; called only when GPU timing is switched on."""
        ...
