"""AirQuestions: the renderer's functions of the air, evaluated on the GPU for arrays of cameras, rays and suns."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import AIR_BLOCK, AIR_VIEW_BLOCK, ANSWER_BUFFER, QUESTION_BUFFER
from ...engine.blocks.layout import StructLayout, Vec3
from ...engine.gpu import GpuScope
from .block import AirBlock, air_block
from .job import MakesTables, Tables
from .model import AirModel
from .views import AirRows, AirViewBlock, ViewSizes, focus_of, rows_at

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


@dataclass
class AirQuestion:
    """A ray from a camera; or light on a surface there. GLSL: ``#include "generated/air_question.glsl"``."""

    altitude_m: Annotated[float, "of the camera; up to focus as in AirView"]
    sun_mu: float
    sun_sine: float
    floor_rays: AirRows
    open_rays: AirRows
    focus: float
    mu: Annotated[float, "of the ray: up to nu as in AirRay in view.glsl"]
    sine: float
    azimuth: float
    nu: float
    distance_m: Annotated[float, "negative: the whole ray"]
    n_up: Annotated[float, "of a surface: its normal's components, upwards"]
    n_side: Annotated[float, "and towards the sun's azimuth"]
    sun_cosine: float


@dataclass
class AirAnswer:
    """Light is of a unit sun. What first and second are depends on what is asked: light of gas and of haze, or direct
    light and that of the sky."""

    transmittance: Vec3
    first: Vec3
    second: Vec3
    mie_phase: Annotated[float, "for the second"]


_QUESTION, _ANSWER = StructLayout(AirQuestion, "std430"), StructLayout(AirAnswer, "std430")
_WIDE = np.dtype([(name, np.float64, _ANSWER.dtype[name].shape) for name in _ANSWER.dtype.names or ()])


class AirQuestions:
    """One air's tables and the program that asks them.

    gpu: owner of all GL objects. Light comes back for a unit sun.
    """

    def __init__(self, gpu: GpuScope, model: AirModel, tables: MakesTables, views: ViewSizes) -> None:
        self._gpu, self._model, self._views = gpu, model, views
        self._sizes = tables
        self._block = gpu.uniform_block(AirBlock, AIR_BLOCK, "air_model")
        self._block.write(air_block(model, _DARK))
        gpu.uniform_block(AirViewBlock, AIR_VIEW_BLOCK, "air_view")
        gpu.shaders.add_virtual("generated/air_question.glsl", _QUESTION.glsl + _ANSWER.glsl)
        self._program = tables.probe(gpu)
        self._tables: dict[int, Tables] = {}

    def light(
        self, rays: Rays, distance_m: Floats | None, orders: int | None, part: str | None
    ) -> tuple[Floats, Floats]:
        """(radiance (N, 3), transmittance (N, 3)) of the air up to distances (N,), or of whole rays."""
        single = orders == 1 or part is not None
        answers = self._ask(_LIGHT, rays, distance_m, None, 0 if orders is None or single else orders, single, part)
        gas, haze = answers["first"], answers["second"]
        if part is not None:
            return (gas if part == "rayleigh" else haze), answers["transmittance"]
        return gas + haze * answers["mie_phase"][:, None], answers["transmittance"]

    def to_space(self, rays: Rays) -> Floats:
        """Transmittance (N, 3) of rays to space; 0 where they end on the floor."""
        return self._ask(_TO_SPACE, rays, None, None, 0, True, None)["transmittance"]

    def irradiance(self, rays: Rays, normals_up: Floats, normals_side: Floats, sun: Floats) -> tuple[Floats, Floats]:
        """(direct, sky), (N, 3) each, on surfaces: normals' components (N,) along the zenith and towards the sun's
        azimuth, and cosines (N,) between normal and sun."""
        answers = self._ask(_SURFACE, rays, None, (normals_up, normals_side, sun), 0, False, None)
        return answers["first"], answers["second"]

    def _entered(self, rays: Rays, distance_m: Floats | None) -> tuple[Rays, Floats | None]:
        """Rays from space, moved to where they enter the air, in f64. Rays that miss the air stay."""
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
            tables = self._tables[orders] = self._sizes.make(self._gpu, orders)
            while not tables.done:
                tables.step(1 << 22)
        return tables

    def _ask(
        self,
        mode: int,
        rays: Rays,
        distance_m: Floats | None,
        surface: tuple[Floats, Floats, Floats] | None,
        orders: int,
        single: bool,
        part: str | None,
    ) -> NDArray[np.void]:
        count = len(rays.mu)
        if self._sizes.starts_in_air:
            rays, distance_m = self._entered(rays, distance_m)
        h = np.maximum(rays.altitude_m, 0.0)
        packed = np.zeros(count, _QUESTION.dtype)
        for item in fields(rays):
            packed[item.name] = getattr(rays, item.name)
        packed["altitude_m"], packed["focus"] = h, focus_of(self._model)
        for name, rows in zip(("floor_rays", "open_rays"), rows_at(self._model, h), strict=True):
            for item in fields(rows):
                packed[name][item.name] = getattr(rows, item.name)
        packed["distance_m"] = -1.0 if distance_m is None else distance_m
        packed["n_up"], packed["n_side"], packed["sun_cosine"] = surface or (0.0, 0.0, 0.0)
        self._block.bind()
        # Single scattering needs the depths alone; those of any number of orders will do.
        if self._sizes.single_in_all:
            tables = next(iter(self._tables.values())) if single and self._tables else self._tables_of(orders)
        else:
            tables = self._tables_of(1 if single and mode == _LIGHT else orders)
        sizes = self._views
        self._program.set("u_size", (sizes.columns, sizes.rows, sizes.slices))
        return np.concatenate([self._batch(packed[i : i + _BATCH], mode, tables, single, part)
                               for i in range(0, max(count, 1), _BATCH)])  # fmt: skip

    def _batch(
        self, packed: NDArray[np.void], mode: int, tables: Tables, single: bool, part: str | None
    ) -> NDArray[np.void]:
        count = len(packed)
        if not count:
            return np.zeros(0, _WIDE)
        questions, answers = self._gpu.buffer(packed.tobytes()), self._gpu.buffer(reserve=_ANSWER.size * count)
        try:
            questions.bind_to_storage_buffer(QUESTION_BUFFER)
            answers.bind_to_storage_buffer(ANSWER_BUFFER)
            tables.bind()
            for name, value in (("asked", mode), ("count", count), ("all_orders", not single), ("phase", part is None)):
                self._program.set(f"u_{name}", value)
            self._program.run_over(count)
            self._gpu.barrier()
            return np.frombuffer(answers.read(), _ANSWER.dtype).astype(_WIDE)
        finally:
            self._gpu.free(questions)
            self._gpu.free(answers)


class _Dark:
    night_light = 0.0


_DARK: Any = _Dark()
