"""The pass composite.resolve: anti-aliasing between exposure and tone map. docs/antialiasing.md."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Ocean, Planet
from ...engine.blocks.bindings import EXPOSURE_BEFORE_BUFFER, EXPOSURE_BUFFER
from ...engine.frame import Frame, View, ViewInfo, Views
from ...engine.gpu import Fullscreen, GpuScope
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from .temporal import Mode, TemporalState

__all__ = ["Resolver"]

_SOFT_PX = 0.5
"""Standard deviation of the spot that a pixel without history is seen through."""
_CROSS = np.array([(0.0, -1.0), (-1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
"""CROSS of resolve_moving.frag."""
_CHECKER_BLUR = {"u_checkered_ground": ("terrain", 0.3), "u_checkered_sea": ("ocean", 0.5)}
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
def _weights(x: float, y: float) -> NDArray[np.float32]:
    """Of _CROSS for a jitter in pixels."""
    spot = np.exp(-0.5 * ((_CROSS + np.array([x, y])) ** 2).sum(axis=1) / _SOFT_PX**2)
    return (spot / spot.sum()).astype(np.float32)


class _Resolved(TemporalState):
    """One view's."""

    bound = False
    """Whether its graph has the pass."""

    def __init__(self) -> None:
        super().__init__()
        self.moved: dict[str, Any] = {}
        """Uniforms of composite/resolve_moving.frag for this frame."""


class Resolver:
    """Declares and runs the pass; without anti-aliasing there is none, and nothing to keep."""

    def __init__(self, gpu: GpuScope, views: Views) -> None:
        self._gpu, self._views = gpu, views
        self._kind = "none"
        self._programs: dict[tuple[str, ...], Fullscreen] = {}
        self._plain = gpu.state()

    @property
    def active(self) -> bool:
        """Whether there is a pass."""
        return self._kind != "none"

    @property
    def temporal(self) -> bool:
        """Whether frames build on one another."""
        return self._kind == "temporal"

    def _of(self, view: View) -> _Resolved:
        return view.state(self, _Resolved)

    def shift(self, view: View) -> tuple[float, float]:
        """From a pixel's centre to where the texture of this frame's samples shows the same, in texture coordinates."""
        x, y = self._of(view).step.jitter_px if self.temporal else (0.0, 0.0)
        width, height = view.frame.size
        return -x * (1.0 / width), -y * (1.0 / height)

    def use(self, kind: str) -> bool:
        """Choose "none", "edge" or "temporal"; True if the passes change with it."""
        changed, self._kind = kind != self._kind, kind
        if changed:
            self._views.forget(self)
        return changed

    def settled(self, view: View) -> bool:
        """Whether the last picture is that of a still camera with all its samples."""
        own = self._of(view)
        return not self.temporal or not own.bound or own.complete

    def share(self, view: View) -> float:
        """How much of a still picture is done, 0..1."""
        own = self._of(view)
        return own.share if self.temporal and own.bound else 1.0

    def refining(self, view: View) -> str:
        """How far the samples of a still picture are; "" while it moves, and when they are all there."""
        own = self._of(view)
        gathers = self.temporal and own.step.mode == Mode.MEAN and 0.0 < own.share < 1.0
        return f"samples {100.0 * own.share:.0f} %" if gathers else ""

    def begin(self, frame: Frame) -> None:
        """Choose the frame's step and its jitter."""
        frame.jitter_px, frame.checkerboard = (0.0, 0.0), None
        if not self.temporal:
            return
        planet = frame.world.try_get(frame.planet, Planet)
        samples = int(frame.settings.get("composite.samples", 33))
        step = self._of(frame.view).begin(frame, samples, 0.0 if planet is None else planet.radius_m)
        frame.jitter_px, frame.checkerboard = step.jitter_px, step.checkerboard

    def update(self, frame: Frame) -> None:
        """What the shader is to know of the camera's motion. After the stars have been turned."""
        if not self.temporal:
            return
        own = self._of(frame.view)
        motion = own.motion(frame.star_axes)
        if own.step.mode == Mode.MOVING and motion is not None:
            sea = frame.world.try_get(frame.planet, Ocean)
            gravity = 0.0 if sea is None else sea.gravity_m_s2
            # Deep water: the square of the phase a second is g times the wave number.
            water = 2.0 * math.pi * gravity * own.elapsed_s**2
            blur = {
                uniform: share if name in frame.checkered else 0.0 for uniform, (name, share) in _CHECKER_BLUR.items()
            }
            (x, y), (width, height) = own.step.jitter_px, frame.size
            own.moved = {
                # GLSL reads matrices column by column: the transpose of the row order of numpy.
                "u_to_previous": np.ascontiguousarray(motion.turn.T, np.float32),
                "u_sky_to_previous": np.ascontiguousarray(motion.sky_turn.T, np.float32),
                "u_camera_shift_m": tuple(map(float, motion.shift_m)),
                "u_previous_per_scale": motion.before[:2],
                "u_previous_offset": motion.before[2:],
                "u_jitter": (2.0 * x * (1.0 / width), 2.0 * y * (1.0 / height)),
                "u_weights": _weights(x, y),
                "u_water": min(water, 1e9),
                **blur,
            }

    def _program(self, name: str, **defines: int) -> Fullscreen:
        key = (name, *defines)
        if key not in self._programs:
            self._programs[key] = self._gpu.fullscreen(_FILES[name], defines=defines)
        return self._programs[key]

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> str:
        """Add the pass, if there is one; the name of the picture that is to be tone-mapped."""
        own = self._of(view.view)
        own.bound = False
        if not self.active:
            return "scene.radiance"
        lifetime = "history" if self.temporal else "transient"
        spec = TextureSpec(
            "composite.resolved", "rgba32f", lifetime=lifetime, filter="nearest",
            help="exposed light pressed into 0..1, anti-aliased; what is there, and for how many frames, in alpha",
        )  # fmt: skip
        builder.add_pass(
            "composite.resolve",
            bind=lambda io: self._bind(io, own),
            system="composite",
            reads=_READS,
            reads_optional=(_MOTION,) if self.temporal else (),
            history=("composite.resolved", "composite.exposure") if self.temporal else (),
            creates=(spec,),
            help="anti-aliasing: samples of earlier frames, or outlines of this one",
        )
        return "composite.resolved"

    def _bind(self, io: PassIO, own: _Resolved) -> Callable[[], None]:
        own.bound = True
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
                exposure.bind_to_storage_buffer(EXPOSURE_BUFFER)
                edge.render()

            return alone
        motion = io.texture(_MOTION) if io.has(_MOTION) else None
        mean, moving = self._program("mean"), self._program("moving", **({} if motion is None else {"MOTION": 1}))
        programs = (edge, mean, moving)
        before, exposure_before = io.history("composite.resolved"), io.history("composite.exposure")
        valid = io.history_valid

        def run() -> None:
            step = own.step
            builds_on = step.mode == Mode.MOVING or (step.mode == Mode.MEAN and step.weight < 1.0)
            if builds_on and not valid.value:
                own.lost()
                step = own.step
            if step.mode == Mode.MEAN:
                mean.set("u_weight", step.weight)
            elif step.mode == Mode.MOVING:
                for name, value in own.moved.items():
                    moving.set(name, value)
            target.use()
            self._plain.apply()
            for unit, texture in enumerate(textures):
                texture.use(unit)
            before.use(3)
            if motion is not None:
                motion.use(4)
            exposure.bind_to_storage_buffer(EXPOSURE_BUFFER)
            exposure_before.bind_to_storage_buffer(EXPOSURE_BEFORE_BUFFER)
            programs[step.mode].render()
            own.drawn()

        return run
