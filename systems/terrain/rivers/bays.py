"""Where the sea comes in on a river's way: bays that the cells of the drainage don't show.

The ground in a bay is not raised to a river's line, so its water would stand there as a wall above the sea. Lines end
where the sea first comes in, and from there to the mouth their water is the sea's: a node at the shore, and level 0
downstream. Levels only fall by this, so no river climbs.

What is found depends on the ground and the nodes alone. As the rest of the drainage it is kept in a file, of the
package or of the user.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....engine.table_cache import TableCache
from ..drainage.solve import uncarved
from ..drainage.stored import SHIPPED
from ..height import height
from ..height_octaves import model_of
from ..height_params import TerrainParams
from ..height_steps import smoothstep
from ..height_surface import SUBMERGED_M
from .bends import unbent
from .node_arrays import RiverNodes

__all__ = ["Bays", "bays_of", "find_bays", "keep", "with_bays"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_VERSION = "1"
"""Part of the keys: change it with what is found here."""
PARTS = 256
"""Of a line: by these the shore's place is told."""
_LEAST_PART = 4
"""No new node is nearer than this to those there were."""
_STEP_M = 600.0
"""Between the places that are looked at along lines, on a planet of Earth's size."""
_HIGHEST_M = 150.0
"""Lines that end higher are not looked at: no bay is so deep in the land."""
_WALL_M = 0.25
"""Water that stands no higher than this over the ground beside it stays."""
_INLAND_CELLS, _DEEP_M = 6.0, 2.5
"""Hollows further from the mouth, in the drainage's cells, are no bays: for them the river would lie in a trench all
the way, deeper than this."""
_BLOCK = 1 << 15


@dataclass(frozen=True, eq=False)
class Bays:
    """Where the sea comes in, K of them."""

    line: NDArray[np.int32]
    """(K,) the nodes that these lines begin with, rising"""
    part: NDArray[np.uint8]
    """(K,) where on them, in PARTS; 0: at the node itself"""


def bays_of(
    nodes: Callable[[], RiverNodes], params: TerrainParams, cells: int, key: str, cache: TableCache | None = None
) -> Bays:
    """`find_bays`, from a file where somebody has looked before. nodes: those with all of their water. key: one name
    for all that they depend on. cache: the folder, instead of the package's and the user's."""
    name = TableCache.key("bays", _VERSION, key)
    for place in (SHIPPED, TableCache("drainage")) if cache is None else (cache,):
        size = place.load(name, {"size": ()}, np.int64)
        if size is not None:
            held = place.load(name, {part: (int(size["size"]),) for part in ("line", "part")}, np.int32)
            if held is not None:
                return Bays(held["line"], held["part"].astype(np.uint8))
    found = find_bays(nodes(), params, cells)
    keep(TableCache("drainage") if cache is None else cache, key, found)
    return found


def keep(cache: TableCache, key: str, found: Bays) -> None:
    """Writes the file that `bays_of` reads."""
    name = TableCache.key("bays", _VERSION, key)
    cache.save(name, {"size": np.array(len(found.line)), "line": found.line, "part": found.part})


def find_bays(nodes: RiverNodes, params: TerrainParams, cells: int) -> Bays:
    """Looks along all lines near the sea: 4 s for Earth. cells: of the drainage, on the whole planet."""
    ground = uncarved(params)
    level, to, lake = nodes.level_m.astype(np.float64), nodes.to.astype(np.int64), nodes.lake
    line = np.flatnonzero((to >= 0) & (level > 0.0))
    below = to[line]
    wet = nodes.half_width_m[below] > 0.0
    line = line[wet & (level[below] <= _HIGHEST_M * params.scale) & ~(lake[line] & lake[below])]
    if not line.size:
        return Bays(np.empty(0, np.int32), np.empty(0, np.uint8))
    a, way = nodes.direction[line], nodes.direction[to[line]] - nodes.direction[line]
    x, y, z = way.T
    many = np.ceil(np.sqrt(x * x + y * y + z * z) * (params.radius_m / (_STEP_M * params.scale)))
    many = np.maximum(many, 1.0).astype(np.int64)
    first = np.cumsum(many) - many
    which = np.repeat(np.arange(len(line)), many)
    share = (np.arange(len(which)) - first[which]) / many[which]
    ground_m = _heights(a[which] + way[which] * share[:, None], ground)
    level_m = level[line][which] + (level[to[line]] - level[line])[which] * share
    # What is filled of a dip below a river, see height_surface.carve.
    open_share = 1.0 - smoothstep(1.0 + ground_m * (1.0 / SUBMERGED_M))
    wall = (ground_m < 0.0) & (open_share * (level_m - ground_m) > _WALL_M)
    number = np.arange(len(which))
    at = np.minimum.reduceat(np.where(wall, number, len(which)), first)
    found = np.flatnonzero(at < len(which))
    at = at[found]
    # Back to the shore of this bay.
    dry = np.maximum.accumulate(np.where(ground_m >= 0.0, number, -1))[at]
    inside = dry >= first[found]
    before, after = ground_m[np.maximum(dry, 0)], ground_m[np.minimum(dry + 1, len(which) - 1)]
    shore = dry - first[found] + np.where(inside, before / np.maximum(before - after, 1e-9), 0.0)
    part = np.where(inside, np.minimum(np.rint(shore / many[found] * PARTS), PARTS - _LEAST_PART), 0).astype(np.uint8)
    # An edge of a lake stays as high as the lake.
    least = np.where(lake[line[found]], np.uint8(_LEAST_PART), np.uint8(0))
    part = np.maximum(np.where(part < _LEAST_PART, np.uint8(0), part), least)
    length_m = _lengths(nodes, params.radius_m)
    above_lake, left_m = _downstream(to[line[found]], to, lake, length_m)
    left_m += (1.0 - part * (1.0 / PARTS)) * length_m[line[found]]
    cell_m = params.radius_m * np.sqrt(4.0 * np.pi / cells)
    near = (left_m <= _INLAND_CELLS * cell_m) | (level_m[at] <= _DEEP_M)
    kept = ~above_lake & near
    log.info("the sea comes in on the ways of %d of %d lines", int(kept.sum()), len(line))
    return Bays(line[found[kept]].astype(np.int32), part[kept])


def with_bays(nodes: RiverNodes, bays: Bays) -> RiverNodes:
    """The nodes with those at the shores, which come last, and with the sea's level from there on."""
    line, part = bays.line.astype(np.int64), bays.part
    to, level = nodes.to.copy(), nodes.level_m.copy()
    here = np.unique(np.concatenate([line[part == 0], nodes.to[line]]))
    while here.size:
        level[here] = np.minimum(level[here], np.float32(0.0))
        here = np.unique(to[here])
        here = here[(here >= 0) & (level[here] > 0.0)]
    line, part = line[part > 0], part[part > 0]
    share = part * (1.0 / PARTS)
    below = nodes.to[line]
    to[line] = len(to) + np.arange(len(line), dtype=np.int32)

    def between(values: NDArray[np.floating]) -> Floats:
        a, b = values[line].astype(np.float64), values[below].astype(np.float64)
        return a + (b - a) * (share if a.ndim == 1 else share[:, None])

    x, y, z = between(nodes.direction).T
    direction = np.stack([x, y, z], axis=1) / np.sqrt(x * x + y * y + z * z)[:, None]
    names = ("half_width_m", "depth_m", "flat_m", "reach_m", "discharge_m3_s")
    rows = {n: np.concatenate([getattr(nodes, n), between(getattr(nodes, n)).astype(np.float32)]) for n in names}
    return replace(
        nodes,
        direction=np.concatenate([nodes.direction, direction]),
        to=np.concatenate([to, below]),
        level_m=np.concatenate([level, np.zeros(len(line), np.float32)]),
        lake=np.concatenate([nodes.lake, np.zeros(len(line), bool)]),
        **rows,
    )


def _heights(ways: Floats, params: TerrainParams) -> Floats:
    """Of the ground where the warp puts the places (N, 3) of straight lines, on all processors."""
    model = model_of(params)

    def part(start: int) -> Floats:
        x, y, z = ways[start : start + _BLOCK].T
        length = np.sqrt(x * x + y * y + z * z)
        places = unbent(np.stack([x, y, z]) * (params.radius_m / length), params.radius_m, params.seed)
        return height(places.T * (1.0 / params.radius_m), model)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return np.concatenate(list(pool.map(part, range(0, len(ways), _BLOCK))))


def _lengths(nodes: RiverNodes, radius_m: float) -> Floats:
    """(N,) m, of the lines that begin at nodes; 0 where none does."""
    x, y, z = (nodes.direction - nodes.direction[nodes.to]).T
    return np.where(nodes.to >= 0, np.sqrt(x * x + y * y + z * z) * radius_m, 0.0)


def _downstream(
    start: Indices, to: Indices, lake: NDArray[np.bool_], length_m: Floats
) -> tuple[NDArray[np.bool_], Floats]:
    """(K,) whether a lake lies downstream of nodes (K,), or at them, and else how far it is to their mouths."""
    found, here, going = np.zeros(len(start), dtype=bool), start.copy(), np.arange(len(start))
    far_m = np.zeros(len(start))
    while going.size:
        found[going] |= lake[here[going]]
        far_m[going] += length_m[here[going]]
        here[going] = to[here[going]]
        going = going[(here[going] >= 0) & ~found[going]]
    return found, far_m
