"""What the ground's height function costs on the GPU: nanoseconds a vertex, with and without craters and maps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ...engine.blocks.bindings import TERRAIN_TABLE_BLOCK
from ...engine.gpu import Gpu
from ...systems.terrain.height import TerrainParams
from ...systems.terrain.height_table import octave_table
from ...systems.terrain.map_textures import MapTextures

VERTICES = 65536

_SHADER = """
#include "terrain/height.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 6) readonly buffer Feet { vec4 feet[]; };
layout(std430, binding = 7) writeonly buffer Found { vec4 found[]; };
void main() {
    vec4 foot = feet[gl_GlobalInvocationID.x];
    TerrainPoint point = terrain_point(foot.xyz, foot.w);
    found[gl_GlobalInvocationID.x] = vec4(point.gradient, point.dh);
}
"""


@contextmanager
def height_runs(gpu: Gpu, worlds: Mapping[str, TerrainParams], spacing_m: float) -> Any:
    """{name: a function that evaluates heights and gradients of a square of VERTICES, spacing_m apart, and waits}."""
    scope = gpu.scope("ground_cost")
    gpu.shaders.add_virtual("bench/ground_cost.comp", _SHADER)
    side = int(VERTICES**0.5)
    up = np.array([0.48, 0.6, 0.64])
    east = np.array([0.8, 0.0, -0.6])
    north = np.cross(up, east)
    at = (np.arange(side) - 0.5 * side) * spacing_m
    flat = at[None, :, None] * east + at[:, None, None] * north
    found = scope.buffer(reserve=16 * VERTICES)
    runs: dict[str, Callable[[], None]] = {}
    for name, params in worlds.items():
        # On the sphere below the square's points.
        place = up * params.radius_m + flat
        place *= params.radius_m / np.linalg.norm(place, axis=2)[..., None]
        feet = np.full((VERTICES, 4), spacing_m, dtype=np.float32)
        feet[:, :3] = (place - up * params.radius_m).reshape(-1, 3)
        buffer, table = scope.buffer(feet), scope.buffer(octave_table(params, up).tobytes())
        maps = MapTextures(scope)
        maps.show(params.height_map, None)

        defines = {"TERRAIN_SOURCES_CHOSEN": 1}  # as the terrain system compiles it for this ground
        defines |= {"TERRAIN_CRATERED": 1} if params.craters > 0.0 else {}
        defines |= {"TERRAIN_MAPPED": 1} if params.height_map is not None else {}
        compute = scope.compute("bench/ground_cost.comp", defines)

        def run(buffer: Any = buffer, table: Any = table, maps: MapTextures = maps, compute: Any = compute) -> None:
            table.bind_to_uniform_block(TERRAIN_TABLE_BLOCK)
            maps.bind()
            buffer.bind_to_storage_buffer(6)
            found.bind_to_storage_buffer(7)
            compute.run(VERTICES // 64)
            gpu.ctx.finish()

        runs[name] = run
    try:
        yield runs
    finally:
        scope.release()
