"""WaveQuestions: the shaders' functions of the waves, evaluated on the GPU at arrays of places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.blocks.bindings import ANSWER_BUFFER, FRAME_BLOCK, PLANET_BLOCK, QUESTION_BUFFER, WAVE_BLOCK
from ...engine.frame.block import FrameBlock, PlanetBlock, frame_of_anchor
from ...engine.gpu import GpuScope
from ...engine.waves import WaveSet
from .wave_block import WAVE_LAYOUT, SeaMesh, WavePacker

__all__ = ["WaveAnswers", "WaveQuestions"]

Floats = NDArray[np.float64]
_BATCH = 1 << 16
_DEEP_M = 1e6
_METHODS = {"ours": 0, "printed_2018": 2018, "printed_2019": 2019}


@dataclass(frozen=True)
class WaveAnswers:
    """displacement_m, normal: (N, 3) in planet axes; jacobian: (N,), 0 for the printed formulas."""

    displacement_m: Floats
    normal: Floats
    jacobian: Floats


class WaveQuestions:
    """One set of waves on a planet.

    gpu: owner of all GL objects. A context that a renderer draws with should not be used: blocks are bound here.
    """

    def __init__(self, gpu: GpuScope, waves: WaveSet, planet_radius_m: float) -> None:
        self._gpu, self._waves, self._radius_m = gpu, waves, planet_radius_m
        self._frame = gpu.uniform_block(FrameBlock, FRAME_BLOCK, "frame")
        self._planet = gpu.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")
        self._buffer = gpu.buffer(reserve=WAVE_LAYOUT.size, dynamic=True)
        self._block = WavePacker()
        self._program = gpu.compute("ocean/wave_probe.comp")
        rows = np.zeros((max(len(waves), 1), 8), np.float32)
        if len(waves):
            rows[:, :3], rows[:, 3] = waves.origins, waves.amplitude_m
            rows[:, 4], rows[:, 5], rows[:, 6] = waves.wave_number_per_m, waves.speed_rad_s, waves.steepness
        self._printed = gpu.buffer(rows)

    def ask(
        self,
        anchor: ArrayLike,
        directions: ArrayLike,
        time_s: float,
        depth_m: ArrayLike | None = None,
        spacing_m: ArrayLike = 1e-3,
        method: str = "ours",
    ) -> WaveAnswers:
        """What shaders find around an anchor (3,), unit, at unit directions (N, 3).

        depth_m: (N,), None: deep. spacing_m: distance of the samples that show the displacement; the normal has all
        waves. method: ours, or the formulas of printed_2018 and printed_2019, in f32 throughout.
        """
        if method not in _METHODS:
            raise ValueError(f"method: expected one of {', '.join(_METHODS)}, found {method!r}")
        v, a = np.atleast_2d(np.asarray(directions, np.float64)), np.asarray(anchor, np.float64)
        count = len(v)
        packed = np.zeros((count, 8), np.float32)
        packed[:, :3] = (v - a) * self._radius_m
        packed[:, 3] = _DEEP_M if depth_m is None else depth_m
        packed[:, 4:7], packed[:, 7] = v, spacing_m
        self._block.place(self._waves, a, self._radius_m, SeaMesh())
        self._buffer.write(self._block.at(self._waves, time_s).tobytes())
        sea_level_m = self._waves.radius_m - self._radius_m
        self._frame.write(frame_of_anchor(a, sea_level_m))
        self._planet.write(PlanetBlock(self._radius_m, 0.0, 0.0, 0.0, sea_level_m, has_sea=True))
        for block in (self._frame, self._planet):
            block.bind()
        self._buffer.bind_to_uniform_block(WAVE_BLOCK)
        self._printed.bind_to_storage_buffer(2)
        self._program.set("u_printed", (self._waves.radius_m, time_s))
        parts = [self._batch(packed[i : i + _BATCH], _METHODS[method]) for i in range(0, count, _BATCH)]
        found = np.concatenate(parts) if parts else np.zeros((0, 2, 4))
        return WaveAnswers(found[:, 0, :3], found[:, 1, :3], found[:, 0, 3])

    def _batch(self, packed: NDArray[np.float32], mode: int) -> Floats:
        count = len(packed)
        questions, answers = self._gpu.buffer(packed), self._gpu.buffer(reserve=32 * count)
        try:
            questions.bind_to_storage_buffer(QUESTION_BUFFER)
            answers.bind_to_storage_buffer(ANSWER_BUFFER)
            self._program.set("u_mode", (count, mode, len(self._waves), 0))
            self._program.run_over(count)
            self._gpu.barrier()
            return np.frombuffer(answers.read(), np.float32).reshape(count, 2, 4).astype(np.float64)
        finally:
            self._gpu.free(questions)
            self._gpu.free(answers)
