"""The map of trails that cirrus is made of: made in compute on first use, kept on disk."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...engine.gpu import Compute, GpuScope
from ...engine.gpu.kept_maps import KeptMaps
from ...engine.table_cache import TableCache

__all__ = ["fibres_texture"]

_STAGES = 4
_VERSION = "1"
_BRIGHTEST = 0.997
"""Share of the map below what counts as full: a handful of crossings are brighter still."""


def fibres_texture(gpu: GpuScope, size: int, cache: TableCache | None = None) -> moderngl.Texture:
    """clouds/fibres.comp with `size` texels a side, a power of two: rgba8, wrapping, with all mip levels.

    Red: fibres, green: hooks, blue: soft patches, each 0..1.
    """
    programs = [gpu.compute("clouds/fibres.comp", {"STAGE": stage}) for stage in range(_STAGES)]
    sources = [program.linked.key for program in programs]
    levels = size.bit_length()
    texture = gpu.texture((size, size), "rgba8", None, levels, 1, "linear", "repeat")
    whole = KeptMaps(gpu, cache)  # its levels, too, as this driver has them
    whole_key = whole.key("fibres", _VERSION, size, *sources)
    if not whole.load(whole_key, texture):
        values = _texels(gpu, programs, sources, size, cache)
        texture.write(np.concatenate([values, np.full((size, size, 1), 255, np.uint8)], axis=2))
        texture.build_mipmaps(max_level=levels - 1)
        whole.save(whole_key, texture)
    for program in programs:
        gpu.free(program)
    texture.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
    return texture


def _texels(
    gpu: GpuScope, programs: list[Compute], sources: list[str], size: int, cache: TableCache | None
) -> NDArray[np.uint8]:
    """(size, size, 3), whichever driver made it first."""
    cache = TableCache("clouds") if cache is None else cache
    key = cache.key(_VERSION, str(size), *sources)
    held = cache.load(key, {"map": (size, size, 3)})
    if held is not None:
        return held["map"].astype(np.uint8)
    made = _computed(gpu, programs, size)
    values = np.round(255.0 * np.clip(made / np.quantile(made, _BRIGHTEST, axis=(0, 1)), 0.0, 1.0)).astype(np.uint8)
    cache.save(key, {"map": values})
    return values


def _computed(gpu: GpuScope, programs: list[Compute], size: int) -> NDArray[np.float32]:
    """(size, size, 3) of the last stage."""

    def pair() -> list[moderngl.Texture]:
        return [gpu.texture((size, size), "rgba32f", filter="linear", wrap="repeat") for _ in range(2)]

    maps, winds = pair(), pair()
    for stage, program in enumerate(programs):
        to = stage % 2
        maps[1 - to].use(0)
        winds[1].use(1) if stage > 1 else winds[0].use(1)
        maps[to].bind_to_image(0, read=False, write=True)
        winds[to].bind_to_image(1, read=False, write=True)
        program.run_over(size, size)
        gpu.barrier()
    made = np.frombuffer(maps[1].read(), np.float32).reshape(size, size, 4)[..., :3]
    for texture in (*maps, *winds):
        gpu.free(texture)
    return made
