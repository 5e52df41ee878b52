"""The pages of real ground that stream, on the GPU: those that views need, loaded by threads, a few taken in a frame.

A page that has come is faded in over a moment, and out again before its slots are used for another. What a level weighs
at a corner of pages is the least of what the pages around it do, so that it passes into the next coarser level over the
pages beside those that aren't there: no edge shows, whatever is there.

A picture that stands for itself waits for all of its pages, and shows those alone that it needs: it is the same
whatever was looked at before.
"""

from __future__ import annotations

import logging
import os
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ...engine.frame import View
from ...engine.gpu import GpuScope
from ...engine.real_ground.pages import PAGE, SLOT, MadePage
from ...engine.real_ground.streamed_ground import StreamedGround
from ...engine.real_ground.streamed_level import StreamedLevel
from .real_texture import POOL_RECORD, fixed_unit_m, pool_record, real_layout, real_texels
from .real_wanted import Eye, PageReach

__all__ = ["RealStream"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Key = tuple[int, int]
"""Number of the level, and of the page."""

PAGES_A_FRAME = 4
"""0.3 MB at most are taken in in a frame that somebody looks at."""
_UNDER_WAY = 8
_FADE_S = 0.5
_MOST_WAIT_S = 2.0
"""So long vertices wait for pages that still fade in."""


class _Asked:
    """What a view asked for last. wanted: keys, the most urgent first; stamp: see RealStream.stamp."""

    def __init__(self) -> None:
        self.eye: Eye | None = None
        self.spacing_rad = 0.0
        self.wanted: list[tuple[float, Key]] = []
        self.stamp = 0
        self.due = False  # what its vertices show has changed


class _Pages:
    """Of one level: how much pages (P,) weigh, what they shall, and their slots (P, 2), -1: none."""

    def __init__(self, reach: PageReach) -> None:
        level, count = reach.level, len(reach.level.where)
        self.level, self.reach = level, reach
        self.weight = np.zeros(count, np.float32)
        self.target = np.zeros(count, np.float32)
        self.slots = np.full((count, 2), -1, np.int64)
        self._columns = -(-level.lattice.period // PAGE)

    def around(self, pages: Ints) -> Ints:
        """(N, 3, 3) numbers of the pages around, -1: none."""
        where = self.level.where[pages]
        step = np.arange(-1, 2)
        row = where[:, 0, None, None] + step[:, None]
        column = where[:, 1, None, None] + step[None, :]
        if self._columns:
            column = column % self._columns
        row, column = np.broadcast_arrays(row, column)
        inside = row >= 0
        return np.where(inside, self.level.numbers(np.maximum(row, 0), column), -1)

    def corners(self, pages: Ints) -> NDArray[np.float32]:
        """(N, 4): north-west, north-east, south-west, south-east."""
        around = self.around(pages)
        weight = np.where(around >= 0, self.weight[np.maximum(around, 0)], np.float32(1.0))
        both = np.minimum(weight[:, :, :2], weight[:, :, 1:])
        return np.minimum(both[:, :2], both[:, 1:]).reshape(-1, 4).astype(np.float32)


class RealStream:
    """One planet's. radius_m: of the planet."""

    def __init__(self, gpu: GpuScope, ground: StreamedGround, radius_m: float) -> None:
        self.ground, self._radius_m, self._unit_m = ground, radius_m, fixed_unit_m(radius_m)
        self._layout = real_layout(ground)
        words = real_texels(ground, self._unit_m, radius_m)
        self.texture: Any = gpu.texture(words.shape[::-1], "r32ui", words)
        self._levels: dict[int, _Pages] = {}
        for number, (level, factor) in enumerate(zip(ground.levels, ground.factors, strict=True)):
            if isinstance(level, StreamedLevel):
                self._levels[number] = _Pages(PageReach(level, number, factor, radius_m, ground.highest_m))
        self._free = list(range(self._layout.pool - 1, -1, -1))
        self._corners = np.zeros((self._layout.pool, 4), np.float32)
        self._there: dict[Key, int] = {}
        """Pages that have slots, and in which frame each was last wanted."""
        self._moving: set[Key] = set()
        self._under_way: dict[Key, Future[MadePage | None]] = {}
        self._asked: WeakKeyDictionary[View, _Asked] = WeakKeyDictionary()
        self._queue: list[Key] = []
        self._chosen: dict[Key, None] = {}
        self._late: list[Key] = []
        """Pages that came when there was no room yet."""
        self._since_s = 0.0
        self._frame = 0
        self._workers = ThreadPoolExecutor(max(min((os.cpu_count() or 2) - 1, 4), 1), "terrain-pages")
        self.taken = 0
        """Pages taken in so far."""

    def release(self) -> None:
        """Let go of the threads; the scope frees the texture."""
        self._workers.shutdown(wait=False, cancel_futures=True)

    # -- frame ---------------------------------------------------------------------------------------------------------

    def update(self, view: View, eye: Eye, spacing_rad: float, dt_s: float, at_once: bool) -> None:
        """Before anything of a frame reads heights. spacing_rad: between vertices, as the eye sees them, at least;
        at_once: the picture shows all that it needs."""
        self._frame += 1
        asked = self._asked.setdefault(view, _Asked())
        if asked.eye is None or asked.eye.key != eye.key:
            asked.wanted = self._wanted(eye)
            asked.eye, asked.spacing_rad = eye, spacing_rad
            self._choose()
        if at_once:
            self._load_all()
        elif self._queue or self._under_way or self._late:
            self._load_some()
        self._fade(1.0 if at_once else dt_s / _FADE_S)
        self._since_s += dt_s
        if at_once or not self._moving or self._since_s > _MOST_WAIT_S:
            self._since_s = 0.0
            for each in self._asked.values():
                each.stamp, each.due = each.stamp + each.due, False

    def stamp(self, view: View) -> int:
        """Differs when vertices that were made before would show what they lack."""
        asked = self._asked.get(view)
        return 0 if asked is None else asked.stamp

    def settled(self, view: View) -> bool:
        """Whether all that a view needs is there, and nothing fades."""
        asked = self._asked.get(view)
        return asked is None or not (self._queue or self._under_way or self._late or self._moving or asked.due)

    def progress(self, view: View) -> float:
        """How much of what views need is there, 0..1."""
        left = len(self._queue) + len(self._under_way)
        return len(self._there) / max(len(self._there) + left, 1)

    def _wanted(self, eye: Eye) -> list[tuple[float, Key]]:
        found: list[tuple[float, Key]] = []
        for number, pages in self._levels.items():
            wanted = pages.reach.wanted(eye)
            entries = zip(wanted.sample_px.tolist(), wanted.pages.tolist(), strict=True)
            found += [(-px, (number, page)) for px, page in entries]
        found.sort()
        return found

    def _choose(self) -> None:
        """Of what views want as much as there is room for: pages get their targets, and the queue those that are not
        there."""
        wanted = [entry for asked in self._asked.values() for entry in asked.wanted]
        if len(self._asked) > 1:
            wanted.sort()
        chosen: dict[Key, None] = {}
        left = self._layout.pool
        for _, key in wanted:
            if key in chosen:
                continue
            level = self._levels[key[0]].level
            left -= 2 if level.maybe_weighed[key[1]] else 1
            if left < 0:
                break
            chosen[key] = None
        for key in self._there:
            if key in chosen:
                self._there[key] = self._frame
            target = 1.0 if key in chosen else 0.0
            pages = self._levels[key[0]]
            if pages.target[key[1]] != target:
                pages.target[key[1]] = target
                self._moving.add(key)
        self._queue = [
            key for key in chosen
            if key not in self._there and key not in self._under_way and not self._known_empty(key)
        ]  # fmt: skip
        self._queue.reverse()  # taken from its end
        self._late = []
        self._chosen = chosen
        for key in [key for key in self._under_way if key not in chosen]:
            if self._under_way[key].cancel():
                del self._under_way[key]

    def _known_empty(self, key: Key) -> bool:
        pages = self._levels[key[0]]
        if not pages.level.empty(key[1]):
            return False
        if pages.target[key[1]] == 0.0:  # nothing is missing there
            pages.target[key[1]] = 1.0
            self._moving.add(key)
        return True

    def _load_some(self) -> None:
        taken, late = 0, self._late
        self._late = []
        self._queue += [key for key in late if key in self._chosen and key not in self._there]
        for key in list(self._under_way):
            if taken == PAGES_A_FRAME:
                break
            if self._under_way[key].done():
                taken += self._take(key, self._under_way.pop(key).result())
        while self._queue and len(self._under_way) < _UNDER_WAY:
            self._begin(self._queue.pop())

    def _load_all(self) -> None:
        self._fade(1.0)  # what is not wanted makes room
        while self._queue or self._under_way:
            while self._queue and len(self._under_way) < 8 * _UNDER_WAY:
                self._begin(self._queue.pop())
            key = next(iter(self._under_way))
            self._take(key, self._under_way.pop(key).result())

    def _begin(self, key: Key) -> None:
        level = self._levels[key[0]].level
        self._under_way[key] = self._workers.submit(level.page, key[1], True)

    def _take(self, key: Key, found: MadePage | None) -> bool:
        """Whether a page was written to the texture."""
        pages, number = self._levels[key[0]], key[1]
        if found is None:
            self._known_empty(key)
            return False
        if key not in self._chosen:
            return False
        slots = self._slots(1 if found.weights is None else 2)
        if not slots:
            self._late.append(key)  # others fade out first
            return False
        pages.slots[number, : len(slots)] = slots
        pages.weight[number], pages.target[number] = 0.0, 1.0
        first = self._layout.first_slot
        for slot, values in zip(slots, (found.heights, found.weights), strict=False):
            if values is not None:
                self._write(np.ascontiguousarray(values).view(np.uint32), *self._layout.slot(first + slot), SLOT, SLOT)
        both = first + slots[0], first + slots[1] if len(slots) > 1 else -1
        record = pool_record(pages.level, number, found.roughness, both, self._unit_m, self._radius_m)
        self._write(record, *self._layout.place(self._record_word(key[0], slots[0])), POOL_RECORD, 1)
        self._tell(key, slots[0])
        self._there[key] = self._frame
        self._moving.add(key)
        self.taken += 1
        return True

    def _record_word(self, number: int, slot: int) -> int:
        return int(self._layout.words[number, 2]) + POOL_RECORD * slot

    def _tell(self, key: Key, record: int) -> None:
        """The table says which record a page has; -1: none."""
        level = self._levels[key[0]].level
        word = int(self._layout.words[key[0], 1]) + level.table_place(key[1])
        self._write(np.array([record], np.int32), *self._layout.place(word), 1, 1)

    def _write(self, values: NDArray[Any], x: int, y: int, width: int, height: int) -> None:
        self.texture.write(np.ascontiguousarray(values).tobytes(), viewport=(x, y, width, height))

    def _slots(self, count: int) -> list[int]:
        """Free slots, of pages that have faded out if need be; nothing where there are none."""
        if len(self._free) < count:
            gone = sorted(
                (frame, key) for key, frame in self._there.items()
                if self._levels[key[0]].weight[key[1]] == 0.0 and self._levels[key[0]].target[key[1]] == 0.0
            )  # fmt: skip
            for _, key in gone[: max(count, self._layout.pool // 16)]:
                self._drop(key)
        if len(self._free) < count:
            return []
        return [self._free.pop() for _ in range(count)]

    def _drop(self, key: Key) -> None:
        pages, number = self._levels[key[0]], key[1]
        self._free += [slot for slot in pages.slots[number].tolist() if slot >= 0]
        pages.slots[number] = -1
        del self._there[key]
        self._moving.discard(key)
        self._tell(key, -1)

    # -- weights -------------------------------------------------------------------------------------------------------

    def _fade(self, step: float) -> None:
        if not self._moving:
            return
        done: list[Key] = []
        for key in self._moving:
            pages, number = self._levels[key[0]], key[1]
            now, target = float(pages.weight[number]), float(pages.target[number])
            now = min(now + step, target) if now < target else max(now - step, target)
            pages.weight[number] = now
            if now == target:
                done.append(key)
        self._write_corners()
        self._moving.difference_update(done)
        for asked in self._asked.values():
            if asked.eye is None or asked.due:
                continue
            for number, pages in self._levels.items():
                changed = np.array([page for level, page in done if level == number], np.int64)
                if len(changed) and pages.reach.shows(changed, asked.eye, asked.spacing_rad).any():
                    asked.due = True

    def _write_corners(self) -> None:
        for number, pages in self._levels.items():
            there = np.array([page for level, page in self._there if level == number], np.int64)
            if len(there):
                self._corners[pages.slots[there, 0]] = pages.corners(there)
        width = 1 << self._layout.width_bits
        rows = -(-self._corners.size // width)
        words = np.zeros(rows * width, np.uint32)
        words[: self._corners.size] = self._corners.view(np.uint32).ravel()
        rows = min(rows, self.texture.size[1] - (self._layout.first_fade >> self._layout.width_bits))
        x, y = self._layout.place(self._layout.first_fade)
        self._write(words[: rows * width], x, y, width, rows)
