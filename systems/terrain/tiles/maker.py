"""TileMaker: heights of tiles, made on the GPU within a time a frame, and what is measured of them on the way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....engine.blocks.bindings import TERRAIN_TABLE_BLOCK, TILE_REQUEST_BUFFER, TILE_SLOT_BUFFER, TILE_TABLE_BUFFER
from ....engine.gpu import GpuScope
from ....engine.gpu.readback import ReadbackRing
from ....engine.space.vectors import split_pair
from ..height import TerrainParams
from ..height_table import canonical_table
from .shape import TileShape
from .slots import FACTS_DTYPE, REQUEST_DTYPE, VERTEX_BYTES

__all__ = ["Made", "TileMaker", "height_steps_per_m"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BATCH = 64
"""Tiles in one dispatch at most."""
_FIRST_GUESS_S = 0.5e-3


@dataclass(frozen=True, eq=False)
class Made:
    """Tiles that were made (N,), and their facts in metres."""

    keys: Ints
    low_m: Floats
    high_m: Floats
    error_m: Floats


def height_steps_per_m(params: TerrainParams) -> float:
    """Steps of a stored height, a power of two: 31 bits span twice the relief. 2^17 on Earth."""
    reach = max(abs(params.highest_m), abs(params.lowest_m), 1e-3)
    return 2.0 ** min(math.floor(math.log2(2.0**30 / reach)), 20)


class TileMaker:
    """Makes tiles of a shape into the slots of one buffer, in batches.

    work(): as many of the wanted tiles as fit into the time, by what earlier ones took on the GPU. Results come back by
    collect(), some frames later where there is a real GPU. use(): the ground, before anything is made.
    """

    def __init__(self, gpu: GpuScope, shape: TileShape, slots: int) -> None:
        self._gpu = gpu
        self.shape = shape
        defines = shape.defines
        self._make = gpu.compute("terrain/tiles/make.comp", defines=defines)
        self._measure = gpu.compute("terrain/tiles/measure.comp", defines=defines)
        self.slots = gpu.buffer(reserve=slots * shape.vertices * VERTEX_BYTES, dynamic=True)
        self._requests = gpu.buffer(reserve=BATCH * REQUEST_DTYPE.itemsize, dynamic=True)
        self._tables = gpu.buffer(reserve=BATCH * shape.table_pairs * 8, dynamic=True)
        self._ring = ReadbackRing(gpu, BATCH * FACTS_DTYPE.itemsize)
        self._octaves: Any = None
        self.steps_per_m = 1.0
        self.generation = 0
        """Grows with use(): what was begun before counts for nothing."""
        self.tile_s = _FIRST_GUESS_S
        """What a tile takes on the GPU, a running mean."""

    def use(self, params: TerrainParams, complete_table: Callable[[NDArray[Any]], None] = lambda table: None) -> None:
        """Tiles of this ground from now on. complete_table: completes the table of octaves."""
        table = canonical_table(params)
        complete_table(table)
        if self._octaves is not None:
            self._gpu.free(self._octaves)
        self._octaves = self._gpu.buffer(table.tobytes())
        self.steps_per_m = height_steps_per_m(params)
        self.generation += 1

    @property
    def under_way(self) -> int:
        """Batches whose facts have not come back."""
        return self._ring.pending

    def room(self, budget_s: float) -> int:
        """How many tiles fit into a frame's time; at least one."""
        return max(int(budget_s / self.tile_s), 1)

    def make(self, keys: Ints, slots: Ints, radius_m: float) -> bool:
        """Make up to BATCH tiles into slots; False, and nothing, while too many results are under way."""
        count = len(keys)
        assert 0 < count <= BATCH
        facts = self._ring.begin()
        if facts is None:
            return False
        shape = self.shape
        request = np.zeros(count, REQUEST_DTYPE)
        request["name"], request["slot"] = shape.names(keys), slots
        request["table"] = np.arange(count) * shape.table_pairs
        request["spacing_m"] = radius_m * shape.scheme.spacing_rad(shape.scheme.level(keys), shape.segments)
        self._requests.write(request.tobytes())
        self._tables.write(np.stack(split_pair(shape.tables(keys)), axis=-1).tobytes())
        self._requests.bind_to_storage_buffer(TILE_REQUEST_BUFFER)
        self.slots.bind_to_storage_buffer(TILE_SLOT_BUFFER)
        self._tables.bind_to_storage_buffer(TILE_TABLE_BUFFER)
        facts.bind_to_storage_buffer(1)
        self._octaves.bind_to_uniform_block(TERRAIN_TABLE_BLOCK)
        for program in (self._make, self._measure):
            program.set("u_steps_per_m", self.steps_per_m)
        self._gpu.barrier()  # what was assembled from these slots has been read
        self._make.run(count, -(-shape.vertices // 64), 1)
        self._gpu.barrier()
        self._measure.run(count, 1, 1)
        self._gpu.barrier()
        self._ring.end((self.generation, keys.copy()), count * FACTS_DTYPE.itemsize)
        return True

    def collect(self, wait: bool = False) -> list[Made]:
        """Facts of what has been made since the last call."""
        found = []
        for (generation, keys), data, seconds in self._ring.poll(wait):
            if generation != self.generation:
                continue
            self.tile_s += 0.25 * (max(seconds / len(keys), 1e-6) - self.tile_s)
            facts = np.frombuffer(data, FACTS_DTYPE)
            error = facts["error_m"].astype(np.float64)
            step = 1.0 / self.steps_per_m
            # Ground between the vertices reaches farther by as much as they miss it.
            low, high = facts["low"] * step - error, facts["high"] * step + error
            found.append(Made(keys, low, high, error))
        return found

    def release(self) -> None:
        """What the scope doesn't own."""
        self._ring.release()
