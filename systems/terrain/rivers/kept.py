"""Finished tables of rivers on disk: a planet like Earth's takes half a second to make from its streams."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np

from ....engine.table_cache import TableCache
from ..drainage.solve import across_of
from ..drainage.stored import key_of
from .river_key import RiverKey
from .table import RiverTable

__all__ = ["keep_table", "kept_table"]

FEW_NODES = 20_000
_PLAIN = (bool, int, float, tuple, type(None))


def kept_table(key: RiverKey, cache: TableCache | None = None) -> RiverTable | None:
    """The table of these rivers, if somebody has made it before. cache: the folder, instead of the user's."""
    name = _name_of(key)
    if name is None:
        return None
    cache = TableCache("rivers") if cache is None else cache
    sizes = cache.load(name, {"sizes": (3,)}, np.int64)
    if sizes is None:
        return None
    nodes, cells, entries = sizes["sizes"].tolist()
    numbers = {"place": (nodes, 3), "to": (nodes,), "keys": (cells,), "begin": (cells + 1,), "lines": (entries,)}
    whole = cache.load(name, numbers, np.int32)
    rest = cache.load(name, {"values": (nodes, 8), "cell_m": ()}, np.float32)
    if whole is None or rest is None:
        return None
    place, to, keys, begin, lines = (whole[name] for name in numbers)
    radius_m, cell_m, seed = key.params.radius_m, float(rest["cell_m"]), key.params.seed
    keys = keys.astype(np.int64)
    return RiverTable(radius_m, cell_m, seed, place, to, rest["values"], keys, begin, lines, uneven=key.banks)


def keep_table(key: RiverKey, table: RiverTable, cache: TableCache | None = None, least: int = FEW_NODES) -> None:
    """Write a table of so many nodes at least for the next start: with fewer it is made as fast as a file is read."""
    name = _name_of(key)
    if name is None or len(table.to) < least:
        return
    arrays = {"place": table.place, "to": table.to, "values": table.values, "begin": table.begin, "lines": table.lines}
    sizes = np.array([len(table.to), len(table.keys), len(table.lines)])
    cell_m = np.array(table.cell_m, np.float32)  # a power of two
    cache = TableCache("rivers") if cache is None else cache
    cache.save(name, {"sizes": sizes, "cell_m": cell_m, "keys": table.keys.astype(np.int32), **arrays})


def _name_of(key: RiverKey) -> str | None:
    """What a table depends on; None for ground of which maps say more than `key_of` takes in."""
    params = key.params
    given = [(f.name, getattr(params, f.name)) for f in fields(params) if f.name != "height_map"]
    if not all(isinstance(value, _PLAIN) for _, value in given):
        return None
    ground = key_of(params, key.climate, across_of(key.cells))
    asked = repr((key.cells, key.strength, key.banks))
    return TableCache.key("table", _sources(), ground, repr(given), asked)


@cache
def _sources() -> str:
    """All modules that make streams and tables: whoever changes one finds other tables."""
    here = Path(__file__).parent
    files = sorted([*here.glob("*.py"), *here.with_name("drainage").glob("*.py")])
    return "\0".join(file.read_text(encoding="utf-8") for file in files)
