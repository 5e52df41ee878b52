"""The printed density texture: noise, cut at a threshold, with a border of zeros around each cloud (Michelic 2018)."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...engine.gpu import GpuScope
from ...engine.table_cache import TableCache

__all__ = ["PREVIEW_TEXELS", "PaperVolume", "border_texels", "deep_path", "threshold_for"]

PREVIEW_TEXELS = 128
"""At most, and half of the full size: what there is to see while that is made."""
MOST_BORDER = 32
"""Texels; wider ones leave nothing empty, as a large step is then as long as what lies between clouds."""
_VERSION = "1"
_SLICES = 8
"""In one dispatch: a tenth of a second without a GPU."""
_RAMP = 0.25
"""How far above the threshold cloud is densest, of the noise's deviation: edges, and then bodies."""
_MIDDLE = 0.7
"""Share of the layer's thickness in which there is cloud to speak of, under a parabola: half of the most."""


def border_texels(step_m: float, tile_m: float, texels: int) -> int:
    """Width of the border: a large step, and one texel over which filtering blurs it."""
    return min(math.ceil(step_m / tile_m * texels) + 1, MOST_BORDER)


def threshold_for(raw: NDArray[np.float32], coverage: float, thick_texels: float) -> float:
    """The noise above which there is cloud, so that a share `coverage` of the sky is under some: of columns as long as
    the layer is thick, those that have any. raw (n, n, n)."""
    long = max(round(_MIDDLE * thick_texels), 1)
    starts = range(0, len(raw), max(len(raw) // 4, 1)) if long < len(raw) else (0,)
    most = np.stack([raw.take(range(start, start + long), 0, mode="wrap").max(0) for start in starts])
    return float(np.quantile(most, 1.0 - min(coverage, 1.0 - 1e-6)))


def deep_path(tile: NDArray[np.float16] | NDArray[np.float64], thick_texels: float) -> float:
    """Density times way straight up through the layer, in texels: of the columns that have any, nine in ten have less.

    tile (n, n, n): the texture, of which a layer `thick_texels` thick takes a part under its parabola. 0 without cloud.
    """
    count = max(round(thick_texels), 1)
    weights = 1.0 - ((np.arange(count) + 0.5) * 2.0 / count - 1.0) ** 2
    found = []
    for start in range(0, len(tile), max(len(tile) // 4, 1)):
        planes = (start + np.arange(count)) % len(tile)
        column = np.zeros(tile.shape[1:])
        for plane, weight in zip(planes, weights, strict=True):
            column += weight * np.maximum(tile[plane].astype(np.float64), 0.0)
        found.append(column[column > 0.0])
    columns = np.concatenate(found)
    return float(np.quantile(columns, 0.9)) * thick_texels / count if columns.size else 0.0


class PaperVolume:
    """One density texture (r16f, repeats, linear, mip levels), -1, 0 or up to 1; a preview until the full one is done.

    gpu: owner. texels: a side. tile_m: its width. thickness_m: of the layer. step_m: the large step. Without `coverage`
    it is all cloud. depth: what deep columns take straight up (`deep_path`); 0: extinction_per_m as it is given.
    Attribute extinction_per_m: of density 1, as that depth wants it.
    """

    def __init__(
        self,
        gpu: GpuScope,
        texels: int,
        coverage: float | None,
        tile_m: float,
        thickness_m: float,
        step_m: float,
        cache: TableCache | None = None,
        *,
        extinction_per_m: float = 0.0,
        depth: float = 0.0,
    ) -> None:
        self.extinction_per_m, self._depth = extinction_per_m, depth
        self._gpu, self._cache = gpu, TableCache("clouds") if cache is None else cache
        self._coverage, self._tile_m, self._thickness_m, self._step_m = coverage, tile_m, thickness_m, step_m
        self._texels = texels
        self._work: Iterator[float] | None = None
        self.share = 1.0
        if coverage is None:
            self.texture = self._texture(1, np.ones((1, 1, 1), np.float16))
            return
        self._mip = gpu.compute("clouds/paper/mip.comp")
        self._noise = gpu.compute("clouds/paper/noise.comp")
        self._fill = [gpu.compute("clouds/paper/fill.comp", {"AXIS": axis}) for axis in range(3)]
        held = self._held(texels)
        if held is not None:
            self.texture = self._texture(texels, held)
            self._finish(self.texture, held)
            return
        for _ in self._made(min(PREVIEW_TEXELS, texels // 2)):
            pass
        self._work, self.share = self._made(texels), 0.0

    @property
    def done(self) -> bool:
        return self._work is None

    def step(self, budget_s: float) -> None:
        """Go on with the full one for about so long; it takes the preview's place once it is whole."""
        until = time.perf_counter() + budget_s
        while self._work is not None:
            share = next(self._work, None)
            self._work = None if share is None else self._work
            self.share = 1.0 if share is None else share
            if time.perf_counter() > until:
                return

    def release(self) -> None:
        """Let go of an unfinished one; the caller frees its scope."""
        self._work = None

    def _key(self, size: int) -> str:
        border = border_texels(self._step_m, self._tile_m, size)
        about = (self._coverage, round(self._thickness_m / self._tile_m, 6), border, size)
        return self._cache.key(_VERSION, repr(about), *(p.linked.key for p in (self._noise, *self._fill)))

    def _held(self, size: int) -> NDArray[np.float16] | None:
        found = self._cache.load(self._key(size), {"tile": (size, size, size)})
        return None if found is None else found["tile"].astype(np.float16)

    def _texture(self, size: int, data: NDArray[np.float16] | None = None) -> moderngl.Texture:
        levels = size.bit_length()
        return self._gpu.texture((size, size, size), "r16f", data, levels=levels, filter="linear", wrap="repeat")

    def _finish(self, texture: moderngl.Texture, tile: NDArray[np.float16]) -> None:
        """The extinction that the wanted depth needs, and the texture's mip levels."""
        size, texel_m = len(tile), self._tile_m / len(tile)
        path_m = texel_m * deep_path(tile, self._thickness_m / texel_m) if self._depth > 0.0 else 0.0
        if path_m > 0.0:
            self.extinction_per_m = self._depth / path_m
        for level in range(1, size.bit_length()):
            self._gpu.barrier()
            ways_m = (min(texel_m * 2.0**k, self._thickness_m) for k in (level - 1, level))
            self._mip.set("u_finer", level - 1)
            for name, way_m in zip(("u_finer_depth", "u_depth"), ways_m, strict=True):
                self._mip.set(name, max(self.extinction_per_m * way_m, 1e-6))
            texture.use(0)
            texture.bind_to_image(0, read=False, write=True, level=level)
            groups = -(-(size >> level) // 4)
            self._mip.run(groups, groups, groups)
        self._gpu.barrier()

    def _made(self, size: int) -> Iterator[float]:
        """Makes the texture of a size, and says after each dispatch how much is done."""
        gpu, border = self._gpu, border_texels(self._step_m, self._tile_m, size)
        raw = gpu.texture((size, size, size), "r32f")
        for first in range(0, size, _SLICES):
            raw.bind_to_image(0, read=False, write=True)
            self._noise.set("u_first", first)
            self._noise.run(-(-size // 8), -(-size // 8), min(_SLICES, size - first))
            yield 0.6 * (first + _SLICES) / size
        gpu.ctx.memory_barrier()
        noise = np.frombuffer(raw.read(), np.float32).reshape(size, size, size)
        cut = threshold_for(noise, self._coverage or 0.0, size * self._thickness_m / self._tile_m)
        ramp = 1.0 / max(_RAMP * float(noise.std()), 1e-6)
        made = [gpu.texture((size, size, size), "r16f") for _ in range(2)] + [self._texture(size)]
        for axis, (program, target) in enumerate(zip(self._fill, made, strict=True)):
            program.set("u_border", border)
            program.set("u_threshold", cut)
            program.set("u_per_ramp", ramp)
            for first in range(0, size, _SLICES):
                raw.use(0)
                made[max(axis - 1, 0)].use(1)
                target.bind_to_image(0, read=False, write=True)
                program.set("u_first", first)
                program.run(-(-size // 8), -(-size // 8), min(_SLICES, size - first))
                yield 0.6 + 0.4 * (axis + (first + _SLICES) / size) / 3.0
            gpu.ctx.memory_barrier()
        tile = np.frombuffer(made[2].read(), np.float16).reshape(size, size, size)
        self._finish(made[2], tile)
        if size == self._texels:
            self._cache.save(self._key(size), {"tile": tile})
        for texture in (raw, *made[:2]):
            gpu.free(texture)
        before = getattr(self, "texture", None)
        self.texture = made[2]
        if before is not None:
            gpu.free(before)
