"""Questions of the marches that answer arrays of rays, as shaders read them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import ANSWER_BUFFER, QUESTION_BUFFER
from ...engine.blocks.layout import StructLayout, Vec3
from ...engine.gpu import Compute, GpuScope

__all__ = ["NoiseOrigins", "Questions", "ShellQuestion", "WeatherQuestion"]


@dataclass
class ShellQuestion:
    """A ray through homogeneous shells, from where it enters the shell of what there is (shell_probe.MarchRays)."""

    height_m: Annotated[float, "of the start"]
    along_m: Annotated[float, "past the ray's nearest point to the planet's centre: (R + h) mu"]
    perigee_m: Annotated[float, "height of that point"]
    rise_m: Annotated[float, "coordinate along the sun's direction"]
    nu: Annotated[float, "cosine between ray and sun"]
    length_m: float
    sun_radius_rad: Annotated[float, "0: a point"]
    multiple: Annotated[float, "1: all orders of scattering, 0: the first"]


@dataclass
class NoiseOrigins:
    """Where the volumes of noise lie around a place, as the `origin` of each in CloudViewBlock."""

    broad: Vec3
    wide: Vec3
    fine: Vec3
    finest: Vec3
    north: Vec3
    south: Vec3
    bend: Annotated[Vec3, "in radii"]

    @staticmethod
    def fill(records: NDArray[Any], places: NDArray[np.float64]) -> None:
        """places: (N, 7, 4) of layers.noise_places."""
        for k, item in enumerate(fields(NoiseOrigins)):
            records[item.name] = places[:, k, :3]


@dataclass
class WeatherQuestion:
    """A ray from a camera of its own through the weather."""

    up: Annotated[Vec3, "unit: the camera's zenith"]
    height_m: Annotated[float, "above the reference sphere"]
    ray: Annotated[Vec3, "unit"]
    mu: Annotated[float, "its cosine to the zenith"]
    sun: Annotated[Vec3, "unit"]
    sun_radius_rad: float
    end_m: Annotated[float, "how far the ray goes"]
    pixel_rad: Annotated[float, "angle that it stands for"]
    sine2: Annotated[float, "squared sine of its angle to the zenith"]
    skipped_m: Annotated[float, "empty space before its start"]
    origins: NoiseOrigins


class Questions:
    """Buffers of one kind of question and of the answers: radiance and transmittance of each."""

    def __init__(self, gpu: GpuScope, kind: type[ShellQuestion | WeatherQuestion], name: str, most: int) -> None:
        """name: of the file that shaders include, generated/NAME.glsl. most: in one dispatch."""
        self._gpu, self._most, layout = gpu, most, StructLayout(kind, "std430")
        self.dtype = layout.dtype
        gpu.shaders.add_virtual(f"generated/{name}.glsl", layout.glsl)

    def ask(self, program: Compute, records: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(radiance (N, 3), transmittance (N, 3)) for N > 0 records of `dtype`."""
        parts = [records[i : i + self._most] for i in range(0, len(records), self._most)]
        found = np.concatenate([self._dispatch(program, part) for part in parts])
        return found[:, 0, :3], found[:, 1, :3]

    def _dispatch(self, program: Compute, records: NDArray[Any]) -> NDArray[np.float64]:
        count = len(records)
        questions, answers = self._gpu.buffer(records.tobytes()), self._gpu.buffer(reserve=32 * count)
        try:
            questions.bind_to_storage_buffer(QUESTION_BUFFER)
            answers.bind_to_storage_buffer(ANSWER_BUFFER)
            program.set("u_count", count)
            program.run_over(count)
            self._gpu.ctx.memory_barrier()
            return np.frombuffer(answers.read(), np.float32).reshape(count, 2, 4).astype(np.float64)
        finally:
            self._gpu.free(questions)
            self._gpu.free(answers)
