"""A backend without a GPU: counts, records and checks. For tests, benches and drawing the graph."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass

from .backend import BarrierKind
from .resources import BufferSpec, TextureSpec
from .touches import PassWatch


@dataclass(eq=False, slots=True)
class NullTexture:
    """Stands for a texture; `label` is the name of the first resource that lived in it."""

    label: str
    format: str
    size: tuple[int, ...]
    levels: int
    layers: int
    bytes: int
    released: bool = False


@dataclass(eq=False, slots=True)
class NullBuffer:
    """Stands for a buffer."""

    label: str
    size_bytes: int
    released: bool = False

    @property
    def bytes(self) -> int:
        """size_bytes."""
        return self.size_bytes


@dataclass(eq=False, slots=True)
class NullFramebuffer:
    """Stands for a framebuffer."""

    colors: tuple[NullTexture, ...]
    depth: NullTexture | None
    released: bool = False


NullObject = NullTexture | NullBuffer | NullFramebuffer


class NullTimers:
    """Timers that answer 0.0 ms for what ran, `delay` frames late like the real ones."""

    def __init__(self, count: int, delay: int = 3) -> None:
        self.count = count
        self.delay = delay
        self.released = False
        self._frame: list[float | None] = [None] * count
        self._ring: deque[list[float | None]] = deque()

    def begin(self, slot: int) -> None:
        """Start of a pass."""
        self._frame[slot] = None

    def end(self, slot: int) -> None:
        """End of a pass."""
        self._frame[slot] = 0.0

    def collect(self, out: list[float | None]) -> None:
        """End of a frame."""
        self._ring.append(self._frame)
        self._frame = [None] * self.count
        if len(self._ring) > self.delay:
            out[:] = self._ring.popleft()

    def release(self) -> None:
        """Mark as freed."""
        self.released = True


class NullBackend:
    """Implements GraphBackend with plain objects.

    counts: how often each call was made ("create_texture", "barrier", ...); calls: the last 10 000 calls as tuples;
    live: objects created and not yet released. Releasing twice raises AssertionError. `fail_on`: names of resources
    whose creation raises MemoryError, for tests.
    """

    def __init__(self, max_texture_size: int = 16384) -> None:
        self.max_texture_size = max_texture_size
        self.watch: PassWatch | None = None
        self.barriers_everywhere = False
        self.counts: Counter[str] = Counter()
        self.calls: deque[tuple[object, ...]] = deque(maxlen=10_000)
        self.live: list[NullObject] = []
        self.timers: list[NullTimers] = []
        self.fail_on: set[str] = set()

    def _record(self, call: str, *details: object) -> None:
        self.counts[call] += 1
        self.calls.append((call, *details))

    def _may_fail(self, name: str) -> None:
        if name in self.fail_on:
            raise MemoryError(f"NullBackend was told to fail on {name!r}")

    def create_texture(self, spec: TextureSpec, size: tuple[int, ...]) -> NullTexture:
        """A NullTexture of that size."""
        self._record("create_texture", spec.name, size)
        self._may_fail(spec.name)
        levels = spec.levels_for(size)
        texture = NullTexture(spec.name, spec.format, size, levels, spec.layers, spec.bytes_for(size))
        self.live.append(texture)
        return texture

    def create_buffer(self, spec: BufferSpec) -> NullBuffer:
        """A NullBuffer."""
        self._record("create_buffer", spec.name, spec.size_bytes)
        self._may_fail(spec.name)
        buffer = NullBuffer(spec.name, spec.size_bytes)
        self.live.append(buffer)
        return buffer

    def framebuffer(self, colors: Sequence[NullTexture], depth: NullTexture | None) -> NullFramebuffer:
        """A NullFramebuffer; its textures must be alive."""
        assert not any(t.released for t in colors) and not (depth and depth.released), "attachment was released"
        self._record("framebuffer", *(t.label for t in colors), depth.label if depth else None)
        framebuffer = NullFramebuffer(tuple(colors), depth)
        self.live.append(framebuffer)
        return framebuffer

    def release(self, obj: NullObject) -> None:
        """Forget an object; a framebuffer has to go before its textures."""
        assert not obj.released, f"released twice: {obj}"
        obj.released = True
        self._record("release", getattr(obj, "label", "framebuffer"))
        self.live.remove(obj)
        if isinstance(obj, NullTexture):
            for other in self.live:
                if isinstance(other, NullFramebuffer):
                    assert obj not in other.colors and obj is not other.depth, f"{obj.label} is still attached"

    def bytes_of(self, obj: NullTexture | NullBuffer) -> int:
        """Bytes of texel or buffer data."""
        return obj.bytes

    def barrier(self, kinds: int) -> None:
        """Recorded."""
        self._record("barrier", BarrierKind(kinds))

    def begin_frame(self) -> None:
        """Counted."""
        self.counts["begin_frame"] += 1

    def end_frame(self) -> None:
        """Counted."""
        self.counts["end_frame"] += 1

    def create_timers(self, count: int) -> NullTimers:
        """NullTimers, kept in `timers`."""
        self._record("create_timers", count)
        timers = NullTimers(count)
        self.timers.append(timers)
        return timers
