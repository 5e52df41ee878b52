"""Noise volumes of clouds: made in compute on first use, spread evenly over 0..1, kept on disk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...engine.gpu import Compute, GpuScope
from ...engine.gpu.kept_maps import KeptMaps
from ...engine.table_cache import TableCache

__all__ = ["NoiseVolume", "even_spread", "level_deviations"]

_SLICES = 8
"""In one dispatch: software rasterisers end loops after 65536 turns in all."""
_VERSION = "1"


@dataclass(frozen=True)
class NoiseVolume:
    """A 3D texture that wraps, with mip levels; deviations: standard deviation of what each level holds."""

    texture: moderngl.Texture
    deviations: tuple[float, ...]


def even_spread(values: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    """The same order of values, as shares of the volume that are below them: uniform in 0..1."""
    quantiles = np.quantile(values, np.linspace(0.0, 1.0, 4097))
    return np.interp(values, quantiles, np.linspace(0.0, 1.0, 4097)).astype(np.float32)


def level_deviations(volume: NDArray[np.float32], levels: int) -> tuple[float, ...]:
    """Standard deviations of the levels of a cube (n, n, n), each the mean of 2 x 2 x 2 of the one before."""
    found = []
    for _ in range(levels):
        found.append(float(volume.std()))
        n = len(volume) // 2
        if n:
            volume = volume.reshape(n, 2, n, 2, n, 2).mean(axis=(1, 3, 5))
    return tuple(found)


def make_volume(gpu: GpuScope, kind: int, size: int, cache: TableCache | None = None) -> NoiseVolume:
    """The volume of VOLUME `kind` (clouds/volume.comp) with `size` texels a side, a power of two.

    r16f, or without a GPU r32f of the same values, whose coarser levels are exact: to make one of the other takes
    longer there than to fetch it.
    """
    program = gpu.compute("clouds/volume.comp", {"VOLUME": kind})
    levels = size.bit_length()
    stored, kept = ("r32f", np.float32) if gpu.caps.is_software else ("r16f", np.float16)
    # All of it as the driver has it, levels and all, else its texels, else nothing.
    whole = KeptMaps(gpu, cache)
    whole_key = whole.key("volume", _VERSION, kind, size, stored, program.linked.key)
    measured = whole.key("deviations", whole_key)
    held = whole.cache.load(measured, {"deviations": (levels,)}, np.float64)
    texture = gpu.texture((size, size, size), stored, None, levels, 1, "linear", "repeat")
    if held is None or not whole.load(whole_key, texture):
        volume = _texels(gpu, program, kind, size, cache)
        texture.write(volume.astype(kept, copy=False))
        texture.build_mipmaps(max_level=levels - 1)
        held = {"deviations": np.array(level_deviations(volume, levels))}
        whole.save(whole_key, texture)
        whole.cache.save(measured, held)
    gpu.free(program)
    texture.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
    return NoiseVolume(texture, tuple(held["deviations"].tolist()))


def _texels(gpu: GpuScope, program: Compute, kind: int, size: int, cache: TableCache | None) -> NDArray[np.float32]:
    """(size, size, size), whichever driver made it first."""
    cache = TableCache("clouds") if cache is None else cache
    key = cache.key(_VERSION, str(kind), str(size), program.linked.key)
    held = cache.load(key, {"volume": (size, size, size)})
    if held is not None:
        return held["volume"]
    # As the texture and the file have it: a first start shows the same as all that follow.
    half = _compute(gpu, program, size).astype(np.float16)
    cache.save(key, {"volume": half})
    return half.astype(np.float32)


def _compute(gpu: GpuScope, program: Compute, size: int) -> NDArray[np.float32]:
    raw = gpu.texture((size, size, size), "r32f")
    raw.bind_to_image(0, read=False, write=True)
    for first in range(0, size, _SLICES):
        program.set("u_first", first)
        program.run(-(-size // 8), -(-size // 8), min(_SLICES, size - first))
    gpu.barrier()
    values = np.frombuffer(raw.read(), np.float32).reshape(size, size, size)
    gpu.free(raw)
    return even_spread(values)
