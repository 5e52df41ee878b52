"""Pages that stream, on the GPU, whatever they hold: those that views need, loaded by threads, a few taken in a frame.

A page that has come is faded in over a moment, and out again before its slots are used for another. What a level weighs
at a corner of pages is the least of what the pages around it do, so that it passes into the next coarser level over the
pages beside those that aren't there: no edge shows, whatever is there.

A picture that stands for itself waits for all of its pages, and shows those alone that it needs: it is the same
whatever was looked at before.
"""

from __future__ import annotations

import os
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Generic, Protocol, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ...engine.frame import View
from ...engine.gpu import GpuScope
from .level_pages import LevelPages
from .real_wanted import Eye

__all__ = ["Key", "PageStream"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Key = tuple[int, int]
"""Number of the level, and of the page."""
P = TypeVar("P")

_UNDER_WAY = 8
_NEAR_PX = 8.0
"""Pages whose samples are so wide, and those beside them, are there in the first frame after a leap."""
_FADE_S = 0.5
_MOST_WAIT_S = 2.0
"""So long vertices wait for pages that still fade in."""
_PLAN_S, _MOVED, _TURNED = 0.5, 0.02, np.cos(0.05)
"""What views need is looked for so often at least, and once they have moved by that share of a page or of their height,
or turned by 0.05 rad."""


class _Wants:
    """What a view asked for last. planned: the eye that `px`, `level` and `page` (N,), how wide the samples of which
    pages are, were found for; now: that of its last frame; stamp: see PageStream.stamp."""

    def __init__(self) -> None:
        self.planned: Eye | None = None
        self.now: Eye | None = None
        self.spacing_rad = self.since_s = 0.0
        self.px = np.zeros(0)
        self.level = self.page = np.zeros(0, np.int64)
        self.stamp = 0
        self.due = False  # what its vertices show has changed

    def plans(self, eye: Eye, page_m: float, dt_s: float, at_once: bool) -> bool:
        """Whether to look anew: where the eye has moved far enough, or stands still."""
        before, last, self.now = self.planned, self.now, eye
        self.since_s += dt_s
        if before is None or last is None:
            return True
        if before.key == eye.key:
            return False
        moved_m = float(np.linalg.norm(eye.position_m - before.position_m))
        return (
            at_once
            or last.key == eye.key
            or self.since_s > _PLAN_S
            or moved_m > _MOVED * max(page_m, eye.above_m)
            or float(eye.forward @ before.forward) < _TURNED
            or eye.pixel_rad != before.pixel_rad
        )


class _Layout(Protocol):
    """Of the texture. pool: slots of pages that come and go; first_fade: the word of what they weigh."""

    @property
    def width_bits(self) -> int: ...

    @property
    def pool(self) -> int: ...

    @property
    def first_fade(self) -> int: ...

    def place(self, word: int) -> tuple[int, int]: ...


class PageStream(Generic[P]):
    """One planet's. texels: of the texture of words at first; levels: by their numbers; most_taken: pages in a frame
    that somebody looks at; name: of the threads. What a page holds, and where it lies, those say that are made of
    it."""

    what = "pages"
    """What they are of, for progress."""

    def __init__(
        self, gpu: GpuScope, texels: NDArray[np.uint32], layout: _Layout, levels: dict[int, LevelPages[P]],
        most_taken: int, name: str,
    ) -> None:  # fmt: skip
        self._gpu, self._words, self._levels = gpu, layout, levels
        self.texture: Any = gpu.texture(texels.shape[::-1], "r32ui", texels)
        self._pool, self._most_taken = layout.pool, most_taken
        self._page_m = min(each.reach.side * each.reach.sample_m for each in levels.values())
        self._free = list(range(layout.pool - 1, -1, -1))
        self._corners = np.zeros((layout.pool, 4), np.float32)
        self._under_way: dict[Key, Future[P | None]] = {}
        self._wants: WeakKeyDictionary[View, _Wants] = WeakKeyDictionary()
        self._queue: list[Key] = []
        """Pages that are wanted and not there, the most urgent last."""
        self._urgent = 0
        """How many of these are near the eye."""
        self._frame = 0
        self._fading = False
        self._since_s = 0.0
        self._workers = ThreadPoolExecutor(max(min((os.cpu_count() or 2) - 1, 4), 1), name)
        self.taken = 0
        """Pages taken in so far."""

    def release(self) -> None:
        """Let go of the threads; the scope frees the texture."""
        self._workers.shutdown(wait=False, cancel_futures=True)

    # -- what those say that are made of it ----------------------------------------------------------------------------

    def slots_of(self, page: P) -> int:
        """How many slots a page takes."""
        return 1

    def costs(self, pages: LevelPages[P], numbers: Ints) -> Ints:
        """How many slots pages (N,) of a level may take."""
        return np.ones(len(numbers), np.int64)

    def show(self, key: Key, page: P, slots: list[int]) -> None:
        """Write a page into its slots, and its record into that of the first one."""
        raise NotImplementedError

    def tell(self, level: int, page: int, record: int) -> None:
        """The table says which record a page has; -1: none."""
        raise NotImplementedError

    def changes(self, pages: LevelPages[P], done: Ints, eye: Eye, spacing_rad: float) -> bool:
        """Whether vertices that were made before lack any of pages (N,)."""
        return False

    # -- texture -------------------------------------------------------------------------------------------------------

    def write(self, values: NDArray[Any], x: int, y: int, width: int, height: int) -> None:
        """Words into a part of the texture."""
        self._gpu.upload_part(self.texture, np.ascontiguousarray(values).tobytes(), (x, y, width, height))

    def _write_weights(self) -> None:
        width = 1 << self._words.width_bits
        rows = -(-self._corners.size // width)
        words = np.zeros(rows * width, np.float32)
        words[: self._corners.size] = self._corners.ravel()
        self.write(words, *self._words.place(self._words.first_fade), width, rows)

    # -- frame ---------------------------------------------------------------------------------------------------------

    def update(
        self, view: View, eye: Eye, spacing_rad: float, dt_s: float, at_once: bool, leaps: bool = False
    ) -> None:  # fmt: skip
        """Before anything of a frame reads heights. spacing_rad: of gradients that show what heights of vertices do, as
        the eye sees it, at least;
        at_once: the picture shows all that it needs, and nothing else. leaps: there is no frame before; ground near
        the eye is there at once, or it might look through coarser one that reaches above it."""
        self._frame += 1
        wants = self._wants.get(view)
        if wants is None:
            wants = self._wants[view] = _Wants()
        wants.spacing_rad = spacing_rad
        if wants.plans(eye, self._page_m, dt_s, at_once):
            self._plan(wants, eye)
            self._choose()
        if at_once or leaps:
            self._load_now(len(self._queue) if at_once else self._urgent)
        elif self._queue or self._under_way:
            self._load_some()
        if self._fading:
            self._fade(1.0 if at_once or leaps else dt_s / _FADE_S)
        self._since_s += dt_s
        if at_once or leaps or not self._fading or self._since_s > _MOST_WAIT_S:
            self._since_s = 0.0
            for each in self._wants.values():
                each.stamp, each.due = each.stamp + each.due, False

    def stamp(self, view: View) -> int:
        """Differs when vertices that were made before would show what they lack."""
        wants = self._wants.get(view)
        return 0 if wants is None else wants.stamp

    def settled(self, view: View) -> bool:
        """Whether all that a view needs is there, and nothing fades."""
        wants = self._wants.get(view)
        if wants is None or wants.now is None or wants.planned is None:
            return True
        done = wants.now.key == wants.planned.key and not wants.due
        return done and not (self._queue or self._under_way or self._fading)

    def progress(self) -> float:
        """How much of what views need is there, 0..1."""
        left = len(self._queue) + len(self._under_way)
        there = self._pool - len(self._free)
        return there / max(there + left, 1)

    def _plan(self, wants: _Wants, eye: Eye) -> None:
        found = [pages.reach.wanted(eye) for pages in self._levels.values()]
        wants.planned, wants.since_s = eye, 0.0
        wants.px = np.concatenate([each.sample_px for each in found])
        wants.level = np.concatenate([np.full(len(each.pages), each.level) for each in found])
        wants.page = np.concatenate([each.pages for each in found])

    def _choose(self) -> None:
        """Of what views want as much as there is room for: those with the widest samples."""
        px, level, page = (
            np.concatenate([getattr(wants, name) for wants in self._wants.values()]) for name in ("px", "level", "page")
        )
        order = np.lexsort((page, level, -px))
        px, level, page = px[order], level[order], page[order]
        _, first = np.unique(level << 40 | page, return_index=True)  # each once
        first.sort()
        px, level, page = px[first], level[first], page[first]
        cost = np.ones(len(page), np.int64)
        for number, pages in self._levels.items():
            at = level == number
            cost[at] = self.costs(pages, page[at])
        room = np.cumsum(cost) <= self._pool
        px, level, page = px[room], level[room], page[room]
        missing, near = np.zeros((2, len(page)), np.bool_)
        for number, pages in self._levels.items():
            at = np.flatnonzero(level == number)
            mine = page[at]
            pages.wanted[:] = False
            pages.wanted[mine] = True
            pages.last[mine] = self._frame
            there = pages.there
            pages.target[there] = pages.wanted[there]
            near[at] = np.isin(mine, pages.around(mine[px[at] > _NEAR_PX]))  # pages weigh nothing towards missing ones
            missing[at] = (pages.slots[mine, 0] < 0) & ~self._settle_empty(pages, mine)
        self._fading = self._fading or any(len(pages.moving) for pages in self._levels.values())
        parts = [
            [key for key in zip(level[at].tolist(), page[at].tolist(), strict=True) if key not in self._under_way]
            for at in (np.flatnonzero(missing & near), np.flatnonzero(missing & ~near))
        ]
        self._urgent, self._queue = len(parts[0]), [*parts[0], *parts[1]]
        self._queue.reverse()
        for key in [key for key in self._under_way if not self._levels[key[0]].wanted[key[1]]]:
            if self._under_way[key].cancel():
                del self._under_way[key]

    def _settle_empty(self, level: LevelPages[P], pages: Ints) -> NDArray[np.bool_]:
        """Which of pages (N,) are known to have nothing: nothing is missing there."""
        empty = level.level.empty(pages)
        level.target[pages[empty]] = 1.0
        return empty

    # -- pages ---------------------------------------------------------------------------------------------------------

    def _load_some(self) -> None:
        taken = 0
        for key in list(self._under_way):
            if taken == self._most_taken:
                break
            if self._under_way[key].done():
                page = self._under_way[key].result()
                slots = self._slots_for(page)
                if slots is None:  # others fade out first
                    break
                del self._under_way[key]
                taken += self._take(key, page, slots)
        while self._queue and len(self._under_way) < _UNDER_WAY:
            self._begin(self._queue.pop())

    def _load_now(self, count: int) -> None:
        """The first of the queue, and what is under way."""
        if self._fading:
            self._fade(1.0)  # what is not wanted makes room
        while count or self._under_way:
            while count and len(self._under_way) < 8 * _UNDER_WAY:
                self._begin(self._queue.pop())
                count -= 1
            key = next(iter(self._under_way))
            page = self._under_way.pop(key).result()
            self._take(key, page, self._slots_for(page))

    def _begin(self, key: Key) -> None:
        level = self._levels[key[0]].level
        self._under_way[key] = self._workers.submit(level.page, key[1], True)

    def _take(self, key: Key, found: P | None, slots: list[int] | None) -> bool:
        """Show a page, if anybody wants it still; whether it was."""
        pages, number = self._levels[key[0]], key[1]
        if found is None:
            self._settle_empty(pages, np.array([number]))
            self._fading = True
            return False
        if slots is None or not pages.wanted[number] or pages.slots[number, 0] >= 0:
            self._free += slots or []
            return False
        pages.slots[number, : len(slots)] = slots
        pages.weight[number], pages.target[number] = 0.0, 1.0
        self._fading = True
        self.show(key, found, slots)
        self.tell(key[0], number, slots[0])
        self.taken += 1
        return True

    def _slots_for(self, page: P | None) -> list[int] | None:
        """Free slots for a page, of pages that have faded out if need be; None where there are none."""
        count = 0 if page is None else self.slots_of(page)
        if len(self._free) < count:
            gone = [
                (int(pages.last[page]), level, page)
                for level, pages in self._levels.items()
                for page in np.flatnonzero(
                    (pages.slots[:, 0] >= 0) & (pages.weight == 0.0) & (pages.target == 0.0)
                ).tolist()
            ]
            for _, level, each in sorted(gone)[: max(count, self._pool // 16)]:
                self._drop(level, each)
        return None if len(self._free) < count else [self._free.pop() for _ in range(count)]

    def _drop(self, level: int, page: int) -> None:
        pages = self._levels[level]
        self._free += [slot for slot in pages.slots[page].tolist() if slot >= 0]
        pages.slots[page] = -1
        self.tell(level, page, -1)

    # -- weights -------------------------------------------------------------------------------------------------------

    def _fade(self, step: float) -> None:
        self._fading = False
        for pages in self._levels.values():
            at = pages.moving
            if not len(at):
                continue
            pages.weight[at] += np.clip(pages.target[at] - pages.weight[at], -step, step).astype(np.float32)
            done = at[np.abs(pages.weight[at] - pages.target[at]) < 1e-6]
            pages.weight[done] = pages.target[done]
            self._fading = self._fading or len(done) < len(at)
            for wants in self._wants.values():
                if len(done) and not wants.due and wants.planned is not None:
                    wants.due = self.changes(pages, done, wants.planned, wants.spacing_rad)
        self._write_corners()

    def _write_corners(self) -> None:
        for pages in self._levels.values():
            there = pages.there
            if len(there):
                self._corners[pages.slots[there, 0]] = pages.corners(there)
        self._write_weights()
