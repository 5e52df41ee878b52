"""TableJob: keeps an air's tables ready. A change shows soon with small tables, then refines to the full size."""

from __future__ import annotations

from time import perf_counter as clock
from typing import Any, ClassVar, Protocol

from ...engine.gpu import Compute, GpuScope, ShaderError, UniformBlock
from ...engine.table_cache import TableCache
from .block import AirBlock
from .model import AirModel

__all__ = ["MakesTables", "TableJob", "Tables"]


class Tables(Protocol):
    """Tables of one air at one size, by either method."""

    @property
    def sources(self) -> str: ...
    @property
    def done(self) -> bool: ...
    @property
    def share(self) -> float: ...
    @property
    def spent(self) -> int: ...
    def restart(self) -> None: ...
    def step(self, samples: int) -> object: ...
    def bind(self) -> None: ...
    def shapes(self) -> dict[str, tuple[int, ...]]: ...
    def arrays(self) -> dict[str, Any]: ...
    def fill(self, arrays: dict[str, Any]) -> None: ...
    def release(self) -> None: ...


class MakesTables(Protocol):
    """Sizes of one method's tables, which know that method: TableSizes, PaperSizes."""

    starts_in_air: ClassVar[bool]
    """Whether rays from space have to be moved to where they enter the air, in f64, before the tables are asked."""
    single_in_all: ClassVar[bool]
    """Whether tables of any number of orders tell single scattering."""

    def quick(self) -> MakesTables: ...
    def make(self, gpu: GpuScope, orders: int = 0) -> Tables: ...
    def probe(self, gpu: GpuScope) -> Compute: ...


_FIRST_SLICE, LEAST_SLICE, _MOST_SLICE = 60_000, 4_000, 1 << 22
"""Samples in one slice of work: the first takes 1 to 3 ms on two cores without a GPU, in thick
air up to three times as long; then the time it took decides."""
_VERSION = "3"
"""Part of the cache's key: raise it when Python code (closing.py, too) gives other values for the same air, sizes and
shaders."""


class TableJob:
    """Tables of one air after another.

    gpu: owner. block: the uniform block ``air_model``; it always holds the air whose tables are shown. Wanted airs
    replace each other: small tables are finished before those of the next air begin, or a value that changes in every
    frame would show nothing; full ones are given up. All work is done by `work`, inside a frame.
    """

    def __init__(self, gpu: GpuScope, sizes: MakesTables, block: UniformBlock, cache: TableCache | None = None) -> None:
        self._gpu, self._ctx = gpu, gpu.ctx
        self._block = block
        self._sizes = sizes
        self.cache = TableCache("atmosphere") if cache is None else cache
        # Two of each size: one is shown while the other is worked on.
        quick = sizes.quick()
        self._quick = [quick.make(gpu), quick.make(gpu)]
        self._full = [sizes.make(gpu)]
        self._tables: Tables | None = None
        self.working: Tables | None = None
        self.wanted: tuple[str, AirModel, AirBlock] | None = None
        self._shown: tuple[str, AirModel, AirBlock] | None = None
        self._target: tuple[str, AirModel, AirBlock] | None = None  # the air that is worked on
        self.refining = self._blocked = False
        self._slice = _FIRST_SLICE
        self.generation = 0
        """Counts the tables that have been shown."""

    @property
    def started(self) -> bool:
        """Whether an air has been asked for."""
        return self.wanted is not None

    @property
    def shown(self) -> AirModel:
        """The air that the tables are of; before there are any, the one they will be of."""
        found = self._shown or self.wanted
        assert found is not None
        return found[1]

    @property
    def sources(self) -> str:
        """What the tables are computed by; differs after a shader has been reloaded."""
        return self._full[0].sources

    @property
    def done(self) -> bool:
        """Whether the tables of the air that was asked for last are shown at full size."""
        return self.working is None and not self._mended

    @property
    def _mended(self) -> bool:
        """Whether a broken shader kept tables from being made, and does no more."""
        return self._blocked and not self._gpu.shaders.errors

    @property
    def share(self) -> float:
        """How much of the work is done, 0..1."""
        return 1.0 if self.working is None else self.working.share if self.refining else 0.0

    def want(self, model: AirModel, block: AirBlock) -> None:
        """From now on work towards this air. Tables that are on disk are shown at once."""
        key = self._key(model)
        if self.wanted is not None and self.wanted[0] == key:
            # The same air under another sun: only its night light differs.
            self.wanted = (key, model, block)
            if self._target is not None and self._target[0] == key:
                self._target = self.wanted
            if self._shown is not None and self._shown[0] == key:
                self._show_block(self.wanted)
            return
        self.wanted = (key, model, block)
        if self._shown is not None and self._shown[0] == key and self._tables in self._full:
            # Back before anything else was seen.
            self.working = None
            self._show_block(self.wanted)
        elif not self._from_cache() and (self.working is None or self.refining):
            self._start_quick()

    def bind(self) -> None:
        """Bind the shown tables and their air where shaders look for them."""
        assert self._tables is not None
        self._block.bind()
        self._tables.bind()

    def work(self, budget_s: float) -> None:
        """Slices of work until the time is up: at least one, and the first ever go on until there is something to show.

        Waits for the GPU after each, or time would mean nothing.
        """
        if self._mended:
            self._refine()
        began = now = clock()
        while self.working is not None:
            assert self._target is not None
            self._block.write(self._target[2])
            self._block.bind()
            working, spent = self.working, self.working.spent
            self._step(self._slice)
            self._ctx.finish()
            before, now = now, clock()
            if working.spent > spent:  # what only closes an order says nothing about how long a slice takes
                # Half the budget a slice: what the first leaves decides whether there is a second.
                fitting = 0.5 * budget_s / max(now - before, 1e-6)
                self._slice = int(min(max(self._slice * min(max(fitting, 0.125), 2.0), LEAST_SLICE), _MOST_SLICE))
            if now - began + 0.5 * (now - before) > budget_s and self._shown is not None:
                break
        if self._shown is not None:
            self._block.write(self._shown[2])

    def release(self) -> None:
        """Free all tables."""
        for tables in (*self._quick, *self._full):
            tables.release()

    def _start(self, tables: Tables, refining: bool) -> None:
        tables.restart()
        self._blocked = False
        self.working, self.refining, self._target = tables, refining, self.wanted

    def _start_quick(self) -> None:
        self._start(next(t for t in self._quick if t is not self._tables), refining=False)

    def _step(self, samples: int) -> None:
        working, target = self.working, self._target
        assert working is not None and target is not None and self.wanted is not None
        working.step(samples)
        if not working.done:
            return
        self._show(working, target)
        if self.refining:
            self.working = None
            self.cache.save(target[0], working.arrays())
        elif target[0] != self.wanted[0]:
            self._start_quick()
        else:
            self._refine()

    def _refine(self) -> None:
        """Go on at full size. While a shader is broken no more tables can be made: the small ones stay until it is
        mended."""
        try:
            tables = self._free_full()
        except ShaderError:
            self.working, self._blocked = None, True
            return
        self._blocked = False
        self._start(tables, refining=True)

    def _free_full(self) -> Tables:
        for tables in self._full:
            if tables is not self._tables:
                return tables
        self._full.append(self._sizes.make(self._gpu))
        return self._full[-1]

    def _show(self, tables: Tables, air: tuple[str, AirModel, AirBlock]) -> None:
        self._tables = tables
        self.generation += 1
        self._show_block(air)

    def _show_block(self, wanted: tuple[str, AirModel, AirBlock]) -> None:
        self._shown = wanted
        self._block.write(wanted[2])

    def _key(self, model: AirModel) -> str:
        return TableCache.key(_VERSION, model.key(), repr(self._sizes), self.sources)

    def _from_cache(self) -> bool:
        assert self.wanted is not None
        try:
            tables = self._free_full()
        except ShaderError:
            return False
        found = self.cache.load(self.wanted[0], tables.shapes())
        if found is None:
            return False
        tables.fill(found)
        self.working = None
        self._show(tables, self.wanted)
        return True
