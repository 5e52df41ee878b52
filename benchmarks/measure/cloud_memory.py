"""What clouds hold on the GPU, and how long their volumes of noise take to be made."""

from __future__ import annotations

import time

from ... import ASSETS, Camera, Renderer
from ...engine.gpu import Gpu
from ...engine.gpu.textures import texture_bytes
from ...engine.hosts.headless import create_headless
from ...engine.table_cache import TableCache
from ...systems.clouds.ours import OurClouds
from ...systems.clouds.volumes import make_volume
from .air_speed import Cost, cost_of
from .cloud_pictures import scene_of_weather

__all__ = ["gpu_memory", "volume_cost"]

_GRAPH = {
    "shadows": ("clouds.shadow", "clouds.sun", "clouds.shaded"), "sky": ("clouds.sky",),
    "picture": ("clouds.rays", "clouds.distance", "clouds.tile_flags", "clouds.tiles", "clouds.full"),
}  # fmt: skip


def gpu_memory(quality: str, size: tuple[int, int]) -> dict[str, float]:
    """MB by what holds them, and of all together, after a frame of a picture of this size."""
    with Renderer(scene_of_weather(), size, quality) as renderer:
        renderer.render(Camera.at(20.0, 10.0, 1e4, pitch_deg=-5.0))
        clouds = getattr(renderer.system("clouds"), "method", None)
        assert isinstance(clouds, OurClouds)
        found = {name: sum(texture_bytes(t) for t in textures) for name, textures in clouds.field.textures().items()}
        for name, parts in _GRAPH.items():
            found[name] = sum(renderer.graph.bytes_of(part) for part in parts)
    found["all"] = sum(found.values())
    return {name: 1e-6 * count for name, count in found.items()}


def volume_cost(texels: int) -> Cost:
    """Of the shape's volume with so many texels a side, without the cache."""
    context = create_headless()
    gpu = Gpu(context, [ASSETS / "shaders"])
    scope = gpu.scope("bench")
    make_volume(scope, 0, 32, TableCache("clouds", ""))  # the shader is compiled at its first dispatch
    wall, cpu = time.perf_counter(), time.process_time()
    make_volume(scope, 0, texels, TableCache("clouds", ""))
    context.finish()
    found = 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - cpu)
    scope.release()
    gpu.release()
    context.release()
    return cost_of([found])
