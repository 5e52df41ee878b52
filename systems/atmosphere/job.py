"""TableJob: keeps an air's tables ready. A change shows at once with small tables, then refines to the full size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

from ...engine.gpu import GpuScope
from .block import AirBlock
from .cache import TableCache
from .model import AirModel
from .paper import PaperSizes, PaperTables
from .tables import AirTables, Directions, TableSizes

__all__ = ["QUICK", "QUICK_PAPER", "TableJob", "Tables"]


class Tables(Protocol):
    """Tables of one air at one size, by either method."""

    @property
    def done(self) -> bool: ...
    @property
    def share(self) -> float: ...
    def restart(self) -> None: ...
    def step(self, samples: int) -> Any: ...
    def bind(self) -> None: ...
    def shapes(self) -> dict[str, tuple[int, ...]]: ...
    def arrays(self) -> dict[str, Any]: ...
    def fill(self, arrays: dict[str, Any]) -> None: ...
    def release(self) -> None: ...


QUICK = TableSizes(
    depth=(64, 32),
    depth_segments=8,
    moments=(16, 12),
    degree=2,
    orders=3,
    first=Directions(7, 4, 8, 5),
    later=Directions(4, 3, 4, 4),
)
"""A first look at a new air: about 0.2 million points of it."""

QUICK_PAPER = PaperSizes((64, 32), (8, 24, 12, 4), (24, 8), 2, "rgba32f")
"""A first look by the printed method."""

_SLICE = 60_000
"""Points of air in one slice of work: 1 to 3 ms on two cores without a GPU."""
_VERSION = "1"
"""Part of the cache's key: raise it when shaders give other values for the same sizes."""


class TableJob:
    """Tables of one air after another.

    gpu: owner. block: the uniform block ``air_model``; it always holds the air whose tables are shown. Wanted airs
    replace each other: only the last one counts.
    """

    def __init__(
        self, gpu: GpuScope, sizes: TableSizes | PaperSizes, block: Any, cache: TableCache | None = None
    ) -> None:
        self._gpu, self._ctx = gpu, gpu.gpu.ctx
        self._block = block
        self._sizes = sizes
        self._cache = TableCache() if cache is None else cache
        # Two of each size: one is shown while the other is worked on.
        quick = QUICK_PAPER if isinstance(sizes, PaperSizes) else replace(QUICK, degree=sizes.degree)
        self._quick = [self._make(quick), self._make(quick)]
        self._full: list[Tables | None] = [self._make(sizes), None]
        self._tables: Tables | None = None
        self._working: Tables | None = None
        self._wanted: tuple[AirModel, AirBlock] | None = None
        self._shown: AirModel | None = None
        self._shown_block: AirBlock | None = None
        self._refining = False
        self.generation = 0
        """Counts the tables that have been shown."""

    @property
    def shown(self) -> AirModel:
        """The air that the tables are of."""
        assert self._shown is not None
        return self._shown

    @property
    def done(self) -> bool:
        """Whether the tables of the air that was asked for last are shown at full size."""
        return self._working is None

    @property
    def share(self) -> float:
        """How much of the work is done, 0..1."""
        return 1.0 if self._working is None else self._working.share if self._refining else 0.0

    def want(self, model: AirModel, block: AirBlock) -> None:
        """From now on work towards this air. The first one ever is shown at once, at the small size."""
        if self._shown is not None and self._wanted is not None and self._wanted[0].key() == model.key():
            # The same air under another sun: only its night light differs.
            self._wanted = (model, block)
            if self._shown.key() == model.key():
                self._show_block(model, block)
            return
        self._wanted = (model, block)
        if self._from_cache(model, block):
            return
        self._start(next(t for t in self._quick if t is not self._tables), refining=False)
        if self._shown is None:
            self._block.write(block)
            while not self._refining:
                self._step(1 << 30)

    def bind(self) -> None:
        """Bind the shown tables where shaders look for them."""
        assert self._tables is not None
        self._tables.bind()

    def work(self, left_s: Callable[[], float]) -> None:
        """Slices of work until the time is up; at least one. Waits for the GPU after each: else time means nothing."""
        while self._working is not None:
            assert self._wanted is not None
            self._block.write(self._wanted[1])
            self._block.bind()
            self._step(_SLICE)
            self._ctx.finish()
            if left_s() <= 0.0:
                break
        if self._shown_block is not None:
            self._block.write(self._shown_block)
            self._block.bind()

    def _make(self, sizes: TableSizes | PaperSizes) -> Tables:
        return PaperTables(self._gpu, sizes) if isinstance(sizes, PaperSizes) else AirTables(self._gpu, sizes)

    def release(self) -> None:
        """Free all tables."""
        for tables in (*self._quick, *self._full):
            if tables is not None:
                tables.release()

    def _start(self, tables: Tables, refining: bool) -> None:
        tables.restart()
        self._working, self._refining = tables, refining

    def _step(self, samples: int) -> None:
        working, wanted = self._working, self._wanted
        assert working is not None and wanted is not None
        working.step(samples)
        if not working.done:
            return
        self._show(working, *wanted)
        if self._refining:
            self._working = None
            self._cache.save(self._key(wanted[0]), working.arrays())
        else:
            self._start(self._free_full(), refining=True)

    def _free_full(self) -> Tables:
        for i, tables in enumerate(self._full):
            if tables is None:
                made = self._full[i] = self._make(self._sizes)
                return made
            if tables is not self._tables:
                return tables
        raise AssertionError("one of two tables is free")

    def _show(self, tables: Tables, model: AirModel, block: AirBlock) -> None:
        self._tables = tables
        self.generation += 1
        self._show_block(model, block)

    def _show_block(self, model: AirModel, block: AirBlock) -> None:
        self._shown, self._shown_block = model, block
        self._block.write(block)

    def _key(self, model: AirModel) -> str:
        return TableCache.key(_VERSION, model.key(), repr(self._sizes))

    def _from_cache(self, model: AirModel, block: AirBlock) -> bool:
        tables = self._free_full()
        found = self._cache.load(self._key(model), tables.shapes())
        if found is None:
            return False
        tables.fill(found)
        self._working = None
        self._show(tables, model, block)
        return True
