"""AirQuestions: the renderer's functions of the air, evaluated on the GPU for arrays of cameras, rays and suns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.gpu import GpuScope
from ...engine.gpu.bindings import AIR_BLOCK, AIR_VIEW_BLOCK
from .block import AirBlock, air_block
from .job import Tables
from .model import AirModel
from .paper import PaperSizes, PaperTables
from .tables import AirTables, TableSizes
from .views import AirViewBlock, ViewSizes, spans

__all__ = ["AirQuestions", "Rays"]

Floats = NDArray[np.float64]
_LIGHT, _TO_SPACE, _SURFACE = 0, 1, 2
_BATCH = 8192
"""Questions in one dispatch: a fraction of a second without a GPU."""


@dataclass(frozen=True)
class Rays:
    """Cameras, directions and suns as the shaders take them, (N,) f64 each: altitude above the floor, the sun's cosine
    and sine to the zenith, the ray's cosine and sine, cosine of its azimuth from the sun, cosine to the sun."""

    altitude_m: Floats
    sun_mu: Floats
    sun_sine: Floats
    mu: Floats
    sine: Floats
    azimuth: Floats
    nu: Floats

    @staticmethod
    def of(radius_m: float, positions_m: Floats, directions: Floats, suns: Floats) -> Rays:
        """positions_m: (N, 3) planet-centred; directions, suns: (N, 3) unit."""
        distance = np.linalg.norm(positions_m, axis=1)
        up = positions_m / np.maximum(distance, 1e-300)[:, None]
        mu, sun_mu = (np.clip((up * v).sum(1), -1.0, 1.0) for v in (directions, suns))
        level, side = directions - up * mu[:, None], suns - up * sun_mu[:, None]
        sine, sun_sine = np.linalg.norm(level, axis=1), np.linalg.norm(side, axis=1)
        product = sine * sun_sine
        azimuth = np.where(product > 1e-12, (level * side).sum(1) / np.maximum(product, 1e-300), 1.0)
        nu = np.clip((directions * suns).sum(1), -1.0, 1.0)
        return Rays(distance - radius_m, sun_mu, sun_sine, mu, sine, np.clip(azimuth, -1.0, 1.0), nu)


class AirQuestions:
    """One air's tables and the program that asks them.

    gpu: owner of all GL objects. Light comes back for a unit sun.
    """

    def __init__(self, gpu: GpuScope, model: AirModel, tables: TableSizes | PaperSizes, views: ViewSizes) -> None:
        self._gpu, self._model, self._views = gpu, model, views
        self._sizes = tables
        self._block = gpu.uniform_block(AirBlock, AIR_BLOCK, "air_model")
        self._block.write(air_block(model, _DARK))
        gpu.uniform_block(AirViewBlock, AIR_VIEW_BLOCK, "air_view")
        if isinstance(tables, PaperSizes):
            self._program = gpu.compute("atmosphere/paper/probe.comp")
        else:
            self._program = gpu.compute("atmosphere/probe.comp", {"AIR_DEGREE": tables.degree})
        self._tables: dict[int, Tables] = {}

    def light(
        self, rays: Rays, distance_m: Floats | None, orders: int | None, part: str | None
    ) -> tuple[Floats, Floats]:
        """(radiance (N, 3), transmittance (N, 3)) of the air up to distances (N,), or of whole rays."""
        single = orders == 1 or part is not None
        answers = self._ask(_LIGHT, rays, distance_m, None, 0 if orders is None or single else orders, single, part)
        gas, haze = answers[:, 1, :3], answers[:, 2, :3]
        if part is not None:
            return (gas if part == "rayleigh" else haze), answers[:, 0, :3]
        return gas + haze * answers[:, 2, 3:], answers[:, 0, :3]

    def to_space(self, rays: Rays) -> Floats:
        """Transmittance (N, 3) of rays to space; 0 where they end on the floor."""
        return self._ask(_TO_SPACE, rays, None, None, 0, True, None)[:, 0, :3]

    def irradiance(self, rays: Rays, normals_up: Floats, normals_side: Floats, sun: Floats) -> tuple[Floats, Floats]:
        """(direct, sky), (N, 3) each, on surfaces: normals' components (N,) along the zenith and towards the sun's
        azimuth, and cosines (N,) between normal and sun."""
        more = np.stack([normals_up, normals_side, sun], 1)
        answers = self._ask(_SURFACE, rays, None, more, 0, False, None)
        return answers[:, 1, :3], answers[:, 2, :3]

    def _entered(self, rays: Rays, distance_m: Floats | None) -> tuple[Rays, Floats | None]:
        """Rays from space, moved to where they enter the air, in f64: the printed functions take cosines, too coarse in
        f32 from afar. Rays that miss the air stay."""
        top, r = self._model.top_radius_m, self._model.radius_m + rays.altitude_m
        inside2 = (top - r * rays.sine) * (top + r * rays.sine)
        enters = (rays.altitude_m > self._model.thickness_m) & (rays.mu < 0.0) & (inside2 > 0.0)
        root = np.sqrt(np.maximum(inside2, 0.0))
        start = np.where(enters, -r * rays.mu - root, 0.0)
        moved = replace(
            rays,
            altitude_m=np.where(enters, self._model.thickness_m, rays.altitude_m),
            mu=np.where(enters, -root / top, rays.mu),
            sun_mu=np.where(enters, np.clip((r * rays.sun_mu + start * rays.nu) / top, -1.0, 1.0), rays.sun_mu),
        )
        return moved, None if distance_m is None else np.maximum(distance_m - start, 0.0)

    def _tables_of(self, orders: int) -> Tables:
        tables = self._tables.get(orders)
        if tables is None:
            if isinstance(self._sizes, PaperSizes):
                tables = PaperTables(self._gpu, replace(self._sizes, orders=orders or self._sizes.orders))
            else:
                tables = AirTables(self._gpu, self._sizes, orders)
            self._tables[orders] = tables
            while not tables.done:
                tables.step(1 << 22)
        return tables

    def _ask(
        self,
        mode: int,
        rays: Rays,
        distance_m: Floats | None,
        more: Floats | None,
        orders: int,
        single: bool,
        part: str | None,
    ) -> Floats:
        count = len(rays.mu)
        if isinstance(self._sizes, PaperSizes):
            rays, distance_m = self._entered(rays, distance_m)
        h = np.maximum(rays.altitude_m, 0.0)
        packed = np.zeros((count, 20), np.float32)
        packed[:, 0], packed[:, 1], packed[:, 2] = h, rays.sun_mu, rays.sun_sine
        packed[:, 4:8], packed[:, 8:12] = spans(self._model, h)
        packed[:, 12], packed[:, 13], packed[:, 14], packed[:, 15] = rays.mu, rays.sine, rays.azimuth, rays.nu
        packed[:, 16] = -1.0 if distance_m is None else distance_m
        if more is not None:
            packed[:, 16:19] = more
        self._block.bind()
        # Single scattering needs the depths alone; those of any number of orders will do.
        if isinstance(self._sizes, PaperSizes):
            # In the printed tables all orders are one sum: each number of orders has its own.
            tables = self._tables_of(1 if single and mode == _LIGHT else orders)
        else:
            tables = next(iter(self._tables.values())) if single and self._tables else self._tables_of(orders)
        sizes = self._views
        self._program.set("u_size", (sizes.columns, sizes.rows, sizes.slices, 0))
        return np.concatenate([self._batch(packed[i : i + _BATCH], mode, tables, single, part)
                               for i in range(0, max(count, 1), _BATCH)])  # fmt: skip

    def _batch(self, packed: NDArray[np.float32], mode: int, tables: Tables, single: bool, part: str | None) -> Floats:
        count = len(packed)
        if not count:
            return np.zeros((0, 3, 4))
        questions, answers = self._gpu.buffer(packed), self._gpu.buffer(reserve=48 * count)
        try:
            questions.bind_to_storage_buffer(0)
            answers.bind_to_storage_buffer(1)
            tables.bind()
            self._program.set("u_mode", (mode, count, 0 if single else 1, 0 if part is not None else 1))
            self._program.run_over(count)
            self._gpu.gpu.ctx.memory_barrier()
            return np.frombuffer(answers.read(), np.float32).reshape(count, 3, 4).astype(np.float64)
        finally:
            self._gpu.free(questions)
            self._gpu.free(answers)


class _Dark:
    night_light = 0.0


_DARK: Any = _Dark()
