"""The pages of pictures of the ground that stream, on the GPU."""

from __future__ import annotations

import numpy as np

from ...engine.gpu import GpuScope
from ...engine.real_ground.color_ground import SLOT
from ...engine.real_ground.color_level import SIDE, Pixels
from ...engine.real_ground.streamed_color_level import StreamedColorLevel
from ...engine.real_ground.streamed_colors import StreamedColors
from .level_pages import LevelPages
from .page_stream import Key, PageStream
from .real_colors import POOL_RECORD, color_layout, color_texels, pool_record, stub_word
from .real_wanted import ColorReach

__all__ = ["ColorStream"]

_PAGES_A_FRAME = 8
"""0.5 MB at most are taken in in a frame that somebody looks at."""


class ColorStream(PageStream[Pixels]):
    """One planet's pictures. radius_m: of the planet; highest_m: its ground."""

    what = "pictures of the ground"

    def __init__(self, gpu: GpuScope, colors: StreamedColors, radius_m: float, highest_m: float) -> None:
        self._radius_m = radius_m
        self._layout = color_layout(colors)
        words = color_texels(colors, radius_m)
        self._colors: dict[int, StreamedColorLevel] = {}
        levels, number = {}, 0
        for each in colors.sets:
            for k, level in enumerate(each.levels):
                if isinstance(level, StreamedColorLevel):
                    # The coarsest of a set doesn't stream: there is a next one.
                    factor = 2.0 ** (each.octaves[k + 1] - each.octaves[k])
                    self._colors[number] = level
                    reach = ColorReach(level, number, SIDE, factor, radius_m, highest_m)
                    levels[number] = LevelPages(level, reach)
                number += 1
        super().__init__(gpu, words, self._layout, levels, _PAGES_A_FRAME, "terrain-pictures")

    def show(self, key: Key, page: Pixels, slots: list[int]) -> None:
        layout, slot = self._layout, slots[0]
        self.write(page, *layout.slot(layout.first_slot + slot), SLOT, SLOT)
        record = pool_record(self._colors[key[0]], key[1], self._radius_m, layout.first_slot + slot)
        self.write(record, *layout.place(layout.first_record + POOL_RECORD * slot), POOL_RECORD, 1)

    def tell(self, level: int, page: int, record: int) -> None:
        word = -1 if record < 0 else self._layout.first_record + POOL_RECORD * record
        self.write(np.array([word], np.int32), *self._layout.place(stub_word(self._layout, level, page)), 1, 1)
