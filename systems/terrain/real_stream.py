"""The pages of real ground that stream, on the GPU."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.gpu import GpuScope
from ...engine.real_ground.pages import PAGE, SLOT, MadePage
from ...engine.real_ground.streamed_ground import StreamedGround
from ...engine.real_ground.streamed_level import StreamedLevel
from .level_pages import LevelPages
from .page_stream import Key, PageStream
from .real_texture import POOL_RECORD, fixed_unit_m, pool_record, real_layout, real_texels
from .real_wanted import Eye, PageReach

__all__ = ["RealStream"]

Ints = NDArray[np.int64]

_PAGES_A_FRAME = 4
"""0.6 MB at most are taken in in a frame that somebody looks at."""


class RealStream(PageStream[MadePage]):
    """One planet's heights. radius_m: of the planet."""

    what = "real ground"

    def __init__(self, gpu: GpuScope, ground: StreamedGround, radius_m: float) -> None:
        self._radius_m, self._unit_m = radius_m, fixed_unit_m(radius_m)
        self._layout = real_layout(ground)
        words = real_texels(ground, self._unit_m, radius_m)
        self._heights = {k: level for k, level in enumerate(ground.levels) if isinstance(level, StreamedLevel)}
        levels = {
            k: LevelPages(level, PageReach(level, k, PAGE, ground.factors[k], radius_m, ground.highest_m))
            for k, level in self._heights.items()
        }
        super().__init__(gpu, words, self._layout, levels, _PAGES_A_FRAME, "terrain-pages")

    def slots_of(self, page: MadePage) -> int:
        return 1 if page.weights is None else 2

    def costs(self, pages: LevelPages[MadePage], numbers: Ints) -> Ints:
        weighed: Ints = 1 + self._heights[pages.reach.number].maybe_weighed[numbers]
        return weighed

    def show(self, key: Key, page: MadePage, slots: list[int]) -> None:
        first, layout = self._layout.first_slot, self._layout
        for slot, values in zip(slots, (page.heights, page.weights), strict=False):
            if values is not None:
                self.write(values, *layout.slot(first + slot), SLOT, SLOT)
        both = first + slots[0], first + slots[1] if len(slots) > 1 else -1
        level = self._heights[key[0]]
        record = pool_record(level, key[1], page.roughness, both, self._unit_m, self._radius_m)
        self.write(record, *layout.place(int(layout.words[key[0], 2]) + POOL_RECORD * slots[0]), POOL_RECORD, 1)

    def tell(self, level: int, page: int, record: int) -> None:
        word = int(self._layout.words[level, 1]) + self._heights[level].table_place(page)
        self.write(np.array([record], np.int32), *self._layout.place(word), 1, 1)

    def changes(self, pages: LevelPages[MadePage], done: Ints, eye: Eye, spacing_rad: float) -> bool:
        return bool(pages.reach.shows(done, eye, spacing_rad).any())
