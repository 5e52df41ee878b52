"""The pass composite.resolve: anti-aliasing between exposure and tone map. docs/antialiasing.md."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from ...components import Ocean, Planet
from ...engine.frame import Frame, ViewInfo
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from .temporal import Mode, Motion, Step, TemporalState

__all__ = ["Resolver"]

_SOFT_PX = 0.5
"""Standard deviation of the spot that a pixel without a past is seen through."""
_CROSS = np.array([(0.0, -1.0), (-1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
"""CROSS of resolve_moving.frag."""
_CHECKER_BLUR = {"terrain": 0.3, "ocean": 0.5}
"""Share of the pixels around in those of a checkerboard, where this frame counts most. 1/2 leaves nothing of it, as
rows of far waves need; less is sharper."""
_FILES = {
    "edge": "composite/resolve_edge.frag",
    "mean": "composite/resolve_mean.frag",
    "moving": "composite/resolve_moving.frag",
}
_MOTION = "props.motion"
_READS = ("scene.radiance", "composite.exposure", "gbuffer.depth", "gbuffer.surface")


@lru_cache(maxsize=128)
def _weights(x: float, y: float) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Of _CROSS for a jitter in pixels."""
    spot = np.exp(-0.5 * ((_CROSS + np.array([x, y])) ** 2).sum(axis=1) / _SOFT_PX**2)
    return (spot / spot.sum()).astype(np.float32)


class Resolver:
    """Declares and runs the pass; without anti-aliasing there is none, and nothing to keep."""

    def __init__(self, gpu: Any) -> None:
        self._gpu = gpu
        self._kind = "none"
        self._states: dict[int, TemporalState] = {}
        self._state = TemporalState()
        self._step = Step(Mode.EDGE)
        self._programs: dict[tuple[str, ...], Any] = {}
        self._moving: Any = None
        self._plain = gpu.gpu.state()
        self._bound = False
        self._texel = (1.0, 1.0)

    @property
    def active(self) -> bool:
        """Whether there is a pass."""
        return self._kind != "none"

    @property
    def temporal(self) -> bool:
        """Whether frames build on one another."""
        return self._kind == "temporal"

    @property
    def shift(self) -> tuple[float, float]:
        """From a pixel's centre to where the texture of this frame's samples shows the same, in texture coordinates."""
        x, y = self._step.jitter_px if self.temporal else (0.0, 0.0)
        return -x * self._texel[0], -y * self._texel[1]

    def use(self, kind: str) -> bool:
        """Choose "none", "edge" or "temporal"; True if the passes change with it."""
        changed, self._kind = kind != self._kind, kind
        if changed:
            self._states.clear()
        return changed

    def settled(self) -> bool:
        """Whether the last picture is that of a still camera with all its samples."""
        return not self.temporal or not self._bound or self._state.complete

    def share(self) -> float:
        """How much of a still picture is done, 0..1."""
        return self._state.share if self.temporal and self._bound else 1.0

    def refining(self) -> str:
        """How far the samples of a still picture are; "" while it moves, and when they are all there."""
        gathers = self.temporal and self._step.mode == Mode.MEAN and 0.0 < self._state.share < 1.0
        return f"samples {100.0 * self._state.share:.0f} %" if gathers else ""

    def begin(self, frame: Frame) -> None:
        """Choose the frame's step and its jitter."""
        frame.jitter_px, frame.checkerboard = (0.0, 0.0), None
        if not self.temporal:
            self._step = Step(Mode.EDGE)
            return
        self._state = self._states.setdefault(frame.view_index, TemporalState())
        planet = frame.world.try_get(frame.planet, Planet)
        samples = int(frame.settings.get("composite.samples", 33))
        self._step = self._state.begin(frame, samples, 0.0 if planet is None else planet.radius_m)
        frame.jitter_px, frame.checkerboard = self._step.jitter_px, self._step.checkerboard

    def update(self, frame: Frame) -> None:
        """Hand the camera's motion to the shader. After the stars have been turned."""
        width, height = frame.size
        self._texel = (1.0 / width, 1.0 / height)
        if not self.temporal:
            return
        motion = self._state.motion(frame.world.resources.get("star_axes"))
        if self._step.mode == Mode.MEAN:
            self._program("mean").set("u_weight", self._step.weight)
        elif self._step.mode == Mode.MOVING and motion is not None:
            self._set_motion(motion, self._step.jitter_px)
            sea = frame.world.try_get(frame.planet, Ocean)
            gravity = 0.0 if sea is None else sea.gravity_m_s2
            # Deep water: the square of the phase a second is g times the wave number.
            water = 2.0 * math.pi * gravity * self._state.elapsed_s**2
            self._program("moving").set("u_water", min(water, 1e9))
            blur = tuple(share if name in frame.checkered else 0.0 for name, share in _CHECKER_BLUR.items())
            self._program("moving").set("u_checkered", blur)

    def _set_motion(self, motion: Motion, jitter_px: tuple[float, float]) -> None:
        program = self._moving
        if program is None:
            return
        # GLSL reads matrices column by column: the transpose of the row order of numpy.
        program.set("u_turn", np.ascontiguousarray(motion.turn.T, np.float32))
        program.set("u_sky_turn", np.ascontiguousarray(motion.sky_turn.T, np.float32))
        program.set("u_shift", tuple(map(float, motion.shift_m)))
        program.set("u_projection", motion.before)
        x, y = jitter_px
        program.set("u_jitter", (2.0 * x * self._texel[0], 2.0 * y * self._texel[1]))
        program.set("u_weights", _weights(x, y))

    def _program(self, name: str, **defines: int) -> Any:
        key = (name, *defines)
        if key not in self._programs:
            self._programs[key] = self._gpu.fullscreen(_FILES[name], defines=defines)
        return self._programs[key]

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> str:
        """Add the pass, if there is one; the name of the picture that is to be tone-mapped."""
        self._bound = False
        if not self.active:
            return "scene.radiance"
        lifetime = "history" if self.temporal else "transient"
        spec = TextureSpec(
            "composite.resolved", "rgba32f", lifetime=lifetime, filter="nearest",
            help="exposed light pressed into 0..1, anti-aliased; what is there, and for how many frames, in alpha",
        )  # fmt: skip
        builder.add_pass(
            "composite.resolve",
            bind=self._bind,
            system="composite",
            reads=_READS,
            reads_optional=(_MOTION,) if self.temporal else (),
            history=("composite.resolved", "composite.exposure") if self.temporal else (),
            creates=(spec,),
            help="anti-aliasing: samples of earlier frames, or outlines of this one",
        )
        return "composite.resolved"

    def _bind(self, io: PassIO) -> Callable[[], None]:
        self._bound = True
        target = io.framebuffer(colors=("composite.resolved",))
        textures = [io.texture(n) for n in ("scene.radiance", "gbuffer.depth", "gbuffer.surface")]
        exposure = io.buffer("composite.exposure")
        edge = self._program("edge")
        if not self.temporal:

            def alone() -> None:
                target.use()
                self._plain.apply()
                for unit, texture in enumerate(textures):
                    texture.use(unit)
                exposure.bind_to_storage_buffer(5)
                edge.render()

            return alone
        motion = io.texture(_MOTION) if io.has(_MOTION) else None
        self._moving = self._program("moving", MOTION=1) if motion is not None else self._program("moving")
        programs = (edge, self._program("mean"), self._moving)
        before, exposure_before = io.history("composite.resolved"), io.history("composite.exposure")
        valid = io.history_valid

        def run() -> None:
            step = self._step
            builds_on = step.mode == Mode.MOVING or (step.mode == Mode.MEAN and step.weight < 1.0)
            if builds_on and not valid.value:
                self._state.lost()
                self._step = step = self._state.step
            target.use()
            self._plain.apply()
            for unit, texture in enumerate(textures):
                texture.use(unit)
            before.use(3)
            if motion is not None:
                motion.use(4)
            exposure.bind_to_storage_buffer(5)
            exposure_before.bind_to_storage_buffer(6)
            programs[step.mode].render()
            self._state.drawn()

        return run
