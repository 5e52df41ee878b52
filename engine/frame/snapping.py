"""The next snap of a view's proxy, prepared over some frames while the last one is drawn.

All vertices of a proxy are made anew at a snap, which takes several times as long as the rest of a frame. So the one
who places the proxy says early where it will be (`begin`); makers of vertices do their part of the work in each frame
into buffers of their own, and once all of them have done it the proxy moves there. What they make is a function of the
proxy alone, so it has the bits that it would have had at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, Protocol

from .proxy import Proxy

if TYPE_CHECKING:
    from ..gpu.cell_mesh import CellMesh
    from ..surface.selection import CellSet

__all__ = ["GroundAhead", "HeldScale", "Scale", "SnapAhead"]

_ZOOMED, _ZOOMED_FAR = 0.05, 0.25
"""Cells are chosen anew when a zoom has changed the angle of a pixel by more than this share; by more than the second,
at once."""
_HURRIED = 6
"""With no more frames than these the one in which cells are chosen does a share, too."""
_WITH_CHOICE = 0.75
"""Of the work of another frame, in that one: the choice takes its time."""
_SHARES = {"ground": 0.45, "sea": 0.35, "fade": 0.2}
"""Phases, in their order, and what share of the frames each takes: by their times along a coast."""


class _Chosen(Protocol):
    @property
    def cells(self) -> CellSet: ...


class GroundAhead(Protocol):
    """The ground's cells for the next snap; engine.snapped.MeshAhead."""

    mesh: CellMesh

    def made(self, snap: SnapAhead) -> _Chosen | None:
        """The choice for that snap, if its cells have their vertices."""
        ...


class SnapAhead:
    """One view's: `frame.view.snap`. Makers say in every update which phases are theirs (`take_part`)."""

    def __init__(self) -> None:
        self.proxy: Proxy | None = None
        """Where the proxy will be; None: nothing is under way."""
        self.number = 0
        """Counts the beginnings."""
        self.possible = False
        """Whether a snap in this frame could wait; says who places the proxy."""
        self.asked = False
        """Makers set it: they would like a snap, although the proxy need not move."""
        self.room = 0
        """For how many cells makers have room: all of them for as many as the one that needs most."""
        self.ground: GroundAhead | None = None
        """Who makes the ground, whose cells are there before the sea's."""
        self.bind_heights: Callable[[], None] | None = None
        """Binds what the height function reads, around the next anchor; the ground sets it."""
        self.bind_anchor: Callable[[], None] = lambda: None
        """Binds the blocks of the next anchor; `restore_anchor` those of the one that is drawn."""
        self.restore_anchor: Callable[[], None] = lambda: None
        self._makers: set[str] = set()
        self._left: list[str] = []
        self._frames: dict[str, int] = {}
        self._count = 0
        self._early = ""
        """The phase that began in the frame of the choice."""

    @property
    def phase(self) -> str:
        """What is to be done now: "ground", "sea" or "fade"; "" when nothing is, or all of it."""
        return self._left[0] if self._left else ""

    @property
    def ready(self) -> bool:
        """Whether everything for `proxy` is there."""
        return self.proxy is not None and not self._left

    @property
    def wanted(self) -> bool:
        """Whether anybody prepares snaps."""
        return "ground" in self._makers

    def take_part(self, part: bool, *phases: str) -> None:
        """A maker's phases; part: whether it prepares them just now."""
        for phase in phases:
            (self._makers.add if part else self._makers.discard)(phase)
        if not part and any(phase in self._left for phase in phases):
            self.drop()

    def begin(self, proxy: Proxy, frames: int) -> None:
        """Prepare for that proxy in so many frames, one a phase at least; the first one comes after this frame, in
        which cells are chosen."""
        self.proxy = proxy
        self.number += 1
        self._left = [phase for phase in _SHARES if phase in self._makers]
        self._frames, self._count, self._early = _shared_out(frames, self._left), frames, ""

    def awaits(self, phase: str) -> bool:
        """Whether that phase is still to be done."""
        return phase in self._left

    @property
    def hurried(self) -> bool:
        """Whether there are so few frames that makers shall begin as soon as they can."""
        return self._count <= _HURRIED

    def begin_early(self) -> None:
        """The maker of the first phase begins in the frame that selects the cells, and so has a frame more."""
        self._early, self._frames = self.phase, _shared_out(self._count + 1, self._left)

    def finish(self, phase: str) -> None:
        """A maker has done this phase."""
        if self.phase == phase:
            del self._left[0]

    def drop(self) -> None:
        """Nothing is under way any more."""
        self.proxy, self._left, self.bind_heights, self.ground = None, [], None, None

    def part(self, phase: str, count: int, step: int, first: bool = False) -> int:
        """How many of `count` cells a frame does in this phase: a multiple of step. first: the phase's first frame."""
        frames, share = float(self._frames[phase]), 1.0
        if phase == self._early and frames > 1.0:
            frames, share = frames - 1.0 + _WITH_CHOICE, _WITH_CHOICE if first else 1.0
        return max(math.ceil(share * count / frames / step), 1) * step


def _shared_out(frames: int, phases: list[str]) -> dict[str, int]:
    """Frames of each phase, by the largest remainders of their shares; one at least."""
    whole = sum(_SHARES[phase] for phase in phases)
    wanted = {phase: frames * _SHARES[phase] / whole for phase in phases}
    found = {phase: max(int(share), 1) for phase, share in wanted.items()}
    for phase in sorted(phases, key=lambda p: found[p] - wanted[p])[: max(frames - sum(found.values()), 0)]:
        found[phase] += 1
    return found


class Scale(NamedTuple):
    """For what length of edges and angle of a pixel cells are made."""

    edge_px: float
    pixel_rad: float


class HeldScale:
    """For what scale a maker's cells are made: that of the frame, or where snaps are prepared, that of the last
    one, so that a zoom or another quality is one more snap."""

    def __init__(self) -> None:
        self.value = Scale(0.0, 0.0)

    def suits(self, snap: SnapAhead, edge_px: float, pixel_rad: float) -> bool:
        """Whether `follow` would leave everything as it is."""
        zoomed = abs(pixel_rad - self.value.pixel_rad)
        return edge_px == self.value.edge_px and zoomed <= (_ZOOMED if snap.possible else 0.0) * self.value.pixel_rad

    def follow(self, snap: SnapAhead, edge_px: float, pixel_rad: float) -> None:
        """In every frame that isn't a snap's."""
        zoomed = abs(pixel_rad - self.value.pixel_rad)
        if not snap.possible or zoomed > _ZOOMED_FAR * self.value.pixel_rad:
            self.value = Scale(edge_px, pixel_rad)
        elif edge_px != self.value.edge_px or zoomed > _ZOOMED * self.value.pixel_rad:
            snap.asked = True
