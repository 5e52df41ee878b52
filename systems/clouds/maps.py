"""Weather maps on the GPU: two moments at a time, made when they are wanted."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ...engine.gpu import GpuScope
from . import weather as w

__all__ = ["BORDER", "WeatherMaps"]

BORDER = 16
"""Texels around the map that repeat what lies across its edges, so that five levels of it can be filtered."""
LEVELS = 5
_ROWS = 64
_BALANCE_TEXELS = 256
_SLOPE = 1.0
"""How sharply the map parts clear sky from cloud."""


class WeatherMaps:
    """Maps by number. size: texels a side without the border."""

    def __init__(self, gpu: GpuScope, size: int, seed: int) -> None:
        self._gpu, self.size, self._seed = gpu, size, seed
        defines = {"CYCLONES": w.CYCLONES}
        self._program = gpu.compute("clouds/weather.comp", defines)
        side = size + 2 * BORDER
        self._textures = [gpu.texture((side, side), "rgba8", levels=LEVELS, filter="linear") for _ in range(2)]
        self._held: list[int | None] = [None, None]
        self._coverage = -1.0
        self._balance = (0.0, 1.0)
        self.made = 0

    def balance(self, coverage: float) -> None:
        """From now on maps have this mean cover."""
        if coverage == self._coverage:
            return
        self._coverage = coverage
        program = self._gpu.compute("clouds/weather.comp", {"CYCLONES": w.CYCLONES, "BALANCE": 1})
        texture = self._gpu.texture((_BALANCE_TEXELS, _BALANCE_TEXELS), "rgba32f")
        self._run(program, texture, 0, 0.0)
        raw = np.frombuffer(texture.read(), np.float32).reshape(_BALANCE_TEXELS, _BALANCE_TEXELS, 4)[..., 0]
        self._balance = w.balance_for(raw, w.octahedral_weights(_BALANCE_TEXELS), coverage, _SLOPE)
        self._gpu.free(texture)
        self._gpu.free(program)
        self._held = [None, None]

    def want(self, moment: w.Moment) -> tuple[Any, Any]:
        """The two textures of a moment."""
        for number in moment.maps if moment.share > 0.0 else (moment.first,):
            slot = number % 2
            if self._held[slot] != number:
                self._program.set("u_balance", self._balance)
                self._run(self._program, self._textures[slot], BORDER, number * w.STEP_S)
                self._textures[slot].build_mipmaps(max_level=LEVELS - 1)
                self._textures[slot].filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
                self._held[slot] = number
                self.made += 1
        return self._textures[moment.first % 2], self._textures[(moment.first + (moment.share > 0.0)) % 2]

    def _run(self, program: Any, texture: Any, border: int, time_s: float) -> None:
        program.set("u_border", border)
        program.set("u_life", w.generations_at(time_s))
        program.set("u_cyclones", w.cyclones_at(time_s, self._seed))
        texture.bind_to_image(0, read=False, write=True)
        width, height = texture.size
        for row in range(0, height, _ROWS):
            program.set("u_first_row", row)
            program.run(-(-width // 8), -(-min(_ROWS, height - row) // 8))
        self._gpu.gpu.ctx.memory_barrier()
