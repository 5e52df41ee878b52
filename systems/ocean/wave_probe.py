"""WaveQuestions: the shaders' functions of the waves, evaluated on the GPU at arrays of places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.blocks.bindings import ANSWER_BUFFER, FRAME_BLOCK, PLANET_BLOCK, QUESTION_BUFFER, WAVE_BLOCK
from ...engine.blocks.layout import StructLayout, Vec3
from ...engine.frame.block import FrameBlock, PlanetBlock, frame_of_anchor
from ...engine.gpu import GpuScope
from ...engine.made_shaders import made_shader
from ...engine.waves import WaveSet, wave_method
from .wave_block import WAVE_LAYOUT, SeaMesh, WavePacker
from .wave_record import MOST_RECORD_BYTES, RecordPacker, fade_lengths, printed_records

__all__ = ["WaveAnswers", "WaveQuestions"]

Floats = NDArray[np.float64]
_BATCH = 1 << 16
_DEEP_M = 1e6


@dataclass
class WaveQuestion:
    """GLSL: ``generated/wave_questions.glsl``."""

    foot_m: Annotated[Vec3, "from the anchor, planet axes"]
    depth_m: float
    direction: Annotated[Vec3, "unit, planet axes, for the printed formulas"]
    spacing_m: Annotated[float, "distance of the samples that show the displacement"]


@dataclass
class WaveAnswer:
    displacement_m: Annotated[Vec3, "planet axes"]
    jacobian: Annotated[float, "0 for the printed formulas"]
    normal: Vec3


_QUESTION, _ANSWER = (StructLayout(c, "std430") for c in (WaveQuestion, WaveAnswer))
made_shader("generated/wave_questions.glsl", lambda: _QUESTION.glsl + _ANSWER.glsl)


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
        self._block, self._anchored = WavePacker(), RecordPacker()
        self._program = gpu.compute("ocean/wave_probe.comp")
        self._records = gpu.buffer(reserve=MOST_RECORD_BYTES, dynamic=True)

    def ask(
        self,
        anchor: ArrayLike,
        directions: ArrayLike,
        time_s: float,
        depth_m: ArrayLike | None = None,
        spacing_m: ArrayLike = 1e-3,
        method: str = "ours",
        records: bool = False,
    ) -> WaveAnswers:
        """What shaders find around an anchor (3,), unit, at unit directions (N, 3).

        depth_m: (N,), None: deep. spacing_m: distance of the samples that show the displacement; the normal has all
        waves. method: of Ocean; printed formulas are evaluated in f32 throughout. records: ours from the 28 bytes that
        the printed sea has of a wave at an anchor.
        """
        printed = wave_method(method).printed
        v, a = np.atleast_2d(np.asarray(directions, np.float64)), np.asarray(anchor, np.float64)
        count = len(v)
        packed = np.zeros(count, _QUESTION.dtype)
        packed["foot_m"], packed["depth_m"] = (v - a) * self._radius_m, _DEEP_M if depth_m is None else depth_m
        packed["direction"], packed["spacing_m"] = v, spacing_m
        self._block.place(self._waves, a, self._radius_m, SeaMesh())
        self._buffer.write(self._block.at(self._waves, time_s).tobytes())
        sea_level_m = self._waves.radius_m - self._radius_m
        self._frame.write(frame_of_anchor(a, sea_level_m))
        self._planet.write(PlanetBlock(self._radius_m, 0.0, 0.0, 0.0, sea_level_m, has_sea=True))
        for block in (self._frame, self._planet):
            block.bind()
        self._buffer.bind_to_uniform_block(WAVE_BLOCK)
        found = printed_records(self._waves)
        if records:
            self._anchored.place(self._waves, a, self._radius_m, SeaMesh())
            self._anchored.at(self._waves, time_s)
            found = self._anchored.records
        if len(found):
            self._records.write(found.tobytes())
        self._records.bind_to_storage_buffer(2)
        self._program.set("u_fade", fade_lengths(self._waves))
        self._program.set("u_sea_radius_m", self._waves.radius_m)
        self._program.set("u_time_s", time_s)
        self._program.set("u_waves", len(self._waves))
        self._program.set("u_printed", printed)
        self._program.set("u_records", records)
        parts = [self._batch(packed[i : i + _BATCH]) for i in range(0, count, _BATCH)]
        answers = np.concatenate([*parts, np.zeros(0, _ANSWER.dtype)])
        displacement_m, normal, jacobian = (
            answers[name].astype(np.float64) for name in ("displacement_m", "normal", "jacobian")
        )
        return WaveAnswers(displacement_m, normal, jacobian)

    def _batch(self, packed: NDArray[np.void]) -> NDArray[np.void]:
        count = len(packed)
        questions, answers = self._gpu.buffer(packed.tobytes()), self._gpu.buffer(reserve=_ANSWER.size * count)
        try:
            questions.bind_to_storage_buffer(QUESTION_BUFFER)
            answers.bind_to_storage_buffer(ANSWER_BUFFER)
            self._program.set("u_count", count)
            self._program.run_over(count)
            self._gpu.barrier()
            return np.frombuffer(answers.read(), _ANSWER.dtype)
        finally:
            self._gpu.free(questions)
            self._gpu.free(answers)
