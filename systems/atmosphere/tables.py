"""Tables of the air that hold for every camera: optical depth to space, and light scattered more than once.

The work is cut into slices, so that a frame can do as much of it as it has time for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ...engine.blocks.bindings import AIR_DEPTH_UNIT, AIR_MOMENTS_UNIT, AIR_NODES_BLOCK
from ...engine.gpu import Compute, GpuScope
from .closing import closing_weights, moved

__all__ = ["AirTables", "Directions", "TableSizes"]

_MOST_NODES = 32
_IRRADIANCE_LAYERS = 4
_STILL = 0.03
"""An order that moves the sum of all by less is the last: what it leaves is a fraction of what it moved."""
_MOST_DIRECTIONS = 16
"""Directions in one dispatch, of rays of up to 32 slices in 3 parts with 26 turns each, where loops are not unrolled.
Mesa's software rasteriser ends a shader's loops, silently, after 65536 turns in all."""


@dataclass(frozen=True)
class Directions:
    """Directions that light is gathered from: Gauss nodes above and below the horizon, azimuths of half a circle, and
    slices of each ray."""

    above: int = 10
    below: int = 6
    azimuths: int = 8
    slices: int = 8

    @property
    def count(self) -> int:
        """How many directions there are."""
        return (self.above + self.below) * self.azimuths


@dataclass(frozen=True)
class TableSizes:
    """Sizes of the tables. depth: (path, altitude) texels; moments: (sun, altitude) texels; degree: of the spherical
    harmonics; orders: of scattering from which the rest is estimated, in thick air up to twice as many; first, later:
    directions for the first order, which has the sun's aureole in it, and for those after it."""

    depth: tuple[int, int] = (128, 64)
    depth_segments: int = 12
    moments: tuple[int, int] = (48, 32)
    degree: int = 2
    orders: int = 6
    first: Directions = Directions(16, 10, 24, 8)
    later: Directions = Directions()

    starts_in_air: ClassVar[bool] = False
    single_in_all: ClassVar[bool] = True

    def quick(self) -> TableSizes:
        """Of a first look."""
        return replace(QUICK, degree=self.degree)

    def make(self, gpu: GpuScope, orders: int = 0) -> AirTables:
        """Tables of these sizes. orders: of scattering; 0: all."""
        return AirTables(gpu, self, orders)

    def probe(self, gpu: GpuScope) -> Compute:
        """The program that asks them."""
        return gpu.compute("atmosphere/probe.comp", {"AIR_DEGREE": self.degree})

    @property
    def layers(self) -> int:
        """Layers of the table of moments: irradiance first."""
        return _IRRADIANCE_LAYERS + (self.degree + 1) * (self.degree + 2) // 2

    def samples(self) -> int:
        """Points of the air that are looked at for all of it, in air that is not thick."""
        texels = self.moments[0] * self.moments[1]
        rays = self.first.count * self.first.slices + (self.orders - 1) * self.later.count * self.later.slices
        return 2 * texels * rays + self.depth[1] * self.depth_row_samples

    @property
    def depth_row_samples(self) -> int:
        """Of one altitude in the table of depths: three Gauss points a segment, on either side of the lowest point."""
        return 6 * self.depth[0] * self.depth_segments


QUICK = TableSizes(
    depth=(64, 32),
    depth_segments=8,
    moments=(16, 12),
    degree=2,
    orders=3,
    first=Directions(7, 4, 8, 5),
    later=Directions(4, 3, 4, 4),
)
"""A first look at a new air: about 0.2 million points of it, in thick air up to six times as many."""


class AirTables:
    """The tables of one air at one size, in slices.

    gpu: who owns the textures. The uniform block ``air_model`` has to be bound while `step` runs.
    textures: name -> texture; they are right once `done`. orders_wanted: 0 for all, n for light scattered at most n
    times.
    """

    def __init__(self, gpu: GpuScope, sizes: TableSizes, orders_wanted: int = 0) -> None:
        self.sizes = sizes
        self._gpu = gpu
        self._ctx = gpu.ctx
        self._wanted = orders_wanted
        defines = {"AIR_DEGREE": sizes.degree}
        self._depth_program = gpu.compute("atmosphere/depth.comp", {"DEPTH_SEGMENTS": sizes.depth_segments})
        self._gather = [gpu.compute("atmosphere/gather.comp", {**defines, "GATHER_FIRST": f}) for f in (0, 1)]
        self._orders = gpu.compute("atmosphere/orders.comp", defines)
        self._add = gpu.compute("atmosphere/add_order.comp", defines)
        self.depth = gpu.texture(sizes.depth, "rgba32f")
        self._layered = [gpu.texture(sizes.moments, "rgba32f", layers=sizes.layers, filter="linear") for _ in range(4)]
        self.moments = self._layered[0]
        self._place = gpu.texture(sizes.moments, "rgba32f")  # an order's mean, later its weights
        self._sums: list[Any] = []  # of each order, until they are added up or the work begins anew
        self._nodes = {d: gpu.buffer(_node_buffer(d)) for d in (sizes.first, sizes.later)}
        self._work: Iterator[int] | None = None
        self._spent = 0
        self.done = False
        self.restart()

    @property
    def sources(self) -> str:
        """Names what computes the tables: equal for equal shaders (their includes and defines too) and directions."""
        programs = (self._depth_program, *self._gather, self._orders, self._add)
        return "|".join(program.linked.key for program in programs)

    def restart(self) -> None:
        """Begin again, for another air of the same sizes."""
        self._forget_sums()
        self._work, self._spent, self.done = self._steps(), 0, False
        self._total = max(self.sizes.samples(), 1)

    @property
    def sums(self) -> int:
        """How many orders' sums are held until they are added up."""
        return len(self._sums)

    @property
    def share(self) -> float:
        """How much of the work is done, 0..1."""
        return 1.0 if self.done else min(self._spent / self._total, 0.99)

    @property
    def spent(self) -> int:
        """Points of the air that have been looked at; in thick air each stands for up to three."""
        return self._spent

    def step(self, samples: int) -> None:
        """One slice of about that many samples (at least one dispatch)."""
        if self.done:
            return
        if self._work is None:
            self.restart()  # the last step raised
        assert self._work is not None
        self._slice = max(samples, 1)
        # Kept only if it comes back: a generator that has raised would pass for one that is done.
        work, self._work = self._work, None
        try:
            self._spent += next(work)
            self._work = work
        except StopIteration:
            self.done = True
        finally:
            if self._work is None:
                self._forget_sums()

    def bind(self) -> None:
        """Bind what the look-ups read, at their units."""
        self.depth.use(AIR_DEPTH_UNIT)
        self.moments.use(AIR_MOMENTS_UNIT)

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of `arrays`."""
        (columns, rows), (suns, heights) = self.sizes.depth, self.sizes.moments
        return {"depth": (rows, columns, 4), "moments": (self.sizes.layers, heights, suns, 4)}

    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """What the tables hold, f32, read back."""
        shapes = self.shapes()
        return {
            name: np.frombuffer(texture.read(), np.float32).reshape(shapes[name])
            for name, texture in (("depth", self.depth), ("moments", self.moments))
        }

    def fill(self, arrays: dict[str, np.ndarray[Any, Any]]) -> None:
        """Take over what `arrays` gave, instead of computing it."""
        self.depth.write(np.ascontiguousarray(arrays["depth"], np.float32).tobytes())
        self.moments.write(np.ascontiguousarray(arrays["moments"], np.float32).tobytes())
        self._forget_sums()
        self._work, self.done = None, True

    def release(self) -> None:
        """Free textures, buffers and programs."""
        self._forget_sums()
        for owned in (self.depth, self._place, *self._layered, *self._nodes.values()):
            self._gpu.free(owned)
        for program in (self._depth_program, *self._gather, self._orders, self._add):
            self._gpu.free(program)

    def _steps(self) -> Iterator[int]:
        width, height = self.sizes.moments
        columns, rows_in_all = self.sizes.depth
        row = 0
        while row < rows_in_all:
            rows = max(1, min(self._slice // self.sizes.depth_row_samples, rows_in_all - row))
            self.depth.bind_to_image(0, read=False, write=True)
            self._depth_program.set("u_rows", (row, row + rows))
            self._depth_program.run_over(columns, rows)
            self._gpu.barrier()
            row += rows
            yield rows * self.sizes.depth_row_samples
        total_table, total, *tables = self._layered
        zero = bytes(16 * width * height * self.sizes.layers)
        for texture in self._layered:
            texture.write(zero)
        means: list[np.ndarray[Any, Any]] = []
        going = self._goes_on(means)
        while going:
            order = len(means) + 1
            last, fresh = tables[order % 2], tables[1 - order % 2]
            directions = self.sizes.first if order == 1 else self.sizes.later
            if order > self.sizes.orders:
                self._total += 2 * width * height * directions.count * directions.slices
            program = self._gather[1 if order == 1 else 0]
            for name in ("above", "azimuths", "slices"):
                program.set(f"u_{name}", getattr(directions, name))
            sums = self._gpu.texture(self.sizes.moments, "rgba32f", layers=self.sizes.layers)
            self._sums.append(sums)
            sums.write(zero)
            for row, rows, first, end in _chunks(directions, width, height, lambda: self._slice):
                self.depth.use(AIR_DEPTH_UNIT)
                last.use(AIR_MOMENTS_UNIT)
                self._nodes[directions].bind_to_uniform_block(AIR_NODES_BLOCK)
                sums.bind_to_image(0)
                program.set("u_first_row", row)
                program.set("u_directions", (first, end))
                program.run(-(-width // 8), rows)
                self._gpu.barrier()
                yield 2 * width * rows * (end - first) * directions.slices
            self._as_table(sums, fresh)
            mean = np.frombuffer(self._place.read(), np.float32).reshape(height, width, 4)
            means.append(mean[..., :3].astype(np.float64))
            if self._wanted:
                self._add_up(total, np.ones((1, height, width, 3)))
            going = self._goes_on(means)
            yield 0
        if not self._wanted:
            self._add_up(total, closing_weights(np.array(means)))
        self._as_table(total, total_table)
        yield 0

    def _add_up(self, total: Any, weights: np.ndarray[Any, Any]) -> None:
        """Add the orders that are kept, by their weights (orders, altitude, sun, 3), and give them back."""
        for sums, weight in zip(self._sums, weights, strict=True):
            self._place.write(np.pad(weight, ((0, 0), (0, 0), (0, 1))).astype(np.float32).tobytes())
            sums.bind_to_image(0, read=True, write=False)
            total.bind_to_image(1)
            self._place.bind_to_image(2, read=True, write=False)
            self._add.run_over(*self.sizes.moments)
            self._gpu.barrier()
        self._forget_sums()

    def _as_table(self, sums: Any, table: Any) -> None:
        """Sums as look-ups read them, and their mean."""
        sums.bind_to_image(0, read=True, write=False)
        table.bind_to_image(1, read=False, write=True)
        self._place.bind_to_image(2, read=False, write=True)
        self._orders.run_over(*self.sizes.moments)
        self._gpu.barrier()

    def _goes_on(self, means: list[np.ndarray[Any, Any]]) -> bool:
        """Whether another order is needed."""
        if self._wanted:
            return len(means) < self._wanted - 1
        least = self.sizes.orders
        return len(means) < least or (len(means) < 2 * least and moved(np.array(means)) > _STILL)

    def _forget_sums(self) -> None:
        for sums in self._sums:
            self._gpu.free(sums)
        self._sums.clear()


def _chunks(d: Directions, width: int, height: int, samples: Any) -> Iterator[tuple[int, int, int, int]]:
    """(first row, rows, first direction, end of directions) that cover all, each about `samples()` points of air."""
    first = 0
    while first < d.count:
        per_direction = 2 * width * height * d.slices
        count = max(1, min(samples() // per_direction, _MOST_DIRECTIONS, d.count - first))
        if samples() >= per_direction:
            yield 0, height, first, first + count
        else:
            row = 0
            while row < height:
                rows = max(1, min(samples() // (2 * width * d.slices), height - row))
                yield row, rows, first, first + 1
                row += rows
            count = 1
        first += count


def _node_buffer(d: Directions) -> np.ndarray[Any, np.dtype[np.float32]]:
    """(32, 4) f32: Node of atmosphere/gather.comp."""
    packed = np.zeros((_MOST_NODES, 4), np.float32)
    for column, count in ((0, d.above), (2, d.below)):
        if not 1 <= count <= _MOST_NODES:
            raise ValueError(f"1 to {_MOST_NODES} directions above and below the horizon, found {count}")
        nodes, weights = np.polynomial.legendre.leggauss(count)
        packed[:count, column] = 0.5 * nodes + 0.5
        packed[:count, column + 1] = 0.5 * weights
    return packed
