"""The pass that draws maps of the clouds' shadow, and where they lie in this frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...engine.gpu import GpuScope
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.system import Frame, ViewInfo
from .columns import intervals_of, span_rows, spans_of
from .shadow import ShadowMaps
from .view_block import MOST_INTERVALS, MOST_MAPS, CloudViewBlock

__all__ = ["SHADED", "SHADOW", "SUN", "SUN_UNIT", "ShadowPass"]

SHADOW, SUN, SHADED = "clouds.shadow", "clouds.sun", "clouds.shaded"
SUN_UNIT = 5
_SUN_JUMP_COSINE = float(np.cos(np.radians(2.0)))
"""As in past.py: a sun that turned by more within a frame was put elsewhere."""
_HEIGHT = 0.3
"""Share of the first layer's thickness at which the maps lie."""


class ShadowPass:
    """Of all views of one planet. steps: samples through a layer; texels: a side of each map.

    Pass ``clouds.shadow`` makes ``clouds.shadow`` (what of the sunlight comes through all clouds), ``clouds.sun`` (what
    is left of it at heights in them) and ``clouds.shaded`` (which maps have any shadow at all).
    """

    def __init__(self, gpu: GpuScope, texels: int, steps: int) -> None:
        self._program = gpu.compute("clouds/shadow.comp")
        self._texels, self._steps = texels, steps
        self._views: dict[int, ShadowMaps] = {}
        self.due: list[int] = []
        self.drawn: list[bool] = []
        """Which maps show what they should, but for a little drift."""
        self.maps: ShadowMaps = ShadowMaps(texels)
        """Those of the view that is being drawn."""

    def clear(self) -> None:
        """Forget all views."""
        self._views.clear()

    def take_layers(self, block: CloudViewBlock, layers: Sequence[Any]) -> None:
        """The clouds have changed. layers: those with cloud, lowest first."""
        spans = spans_of(layers, self._steps)
        intervals = intervals_of(spans)
        self._count = len(intervals)
        block.spans = span_rows(spans)
        # So many samples lie in each interval that a layer has `steps` of them.
        most = max((span.intervals for span in spans), default=1)
        self._program.set("u_steps", -(-self._steps // most))
        heights = np.zeros((MOST_INTERVALS, 2), np.float32)
        heights[: self._count] = intervals
        self._program.set("u_intervals", heights)

    def place(
        self, frame: Frame, block: CloudViewBlock, first: tuple[float, float], wind_m_s: float, stamp: Any,
        radius_m: float, present: bool,
    ) -> None:  # fmt: skip
        """Where the maps lie, and which are due. first: base and thickness of the first layer, in metres."""
        base_m, thickness_m = first
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        maps = self.maps = self._views.setdefault(frame.view_index, ShadowMaps(self._texels))
        if frame.cut:
            maps.forget()
        maps.place(radius_m, thickness_m)
        foot = frame.camera.position_m / np.linalg.norm(frame.camera.position_m)
        due = maps.due(foot, frame.sun.direction, frame.time_s, wind_m_s, stamp, radius_m)
        # One a frame. Of what has nothing to show yet the widest, which stands for the others until they are drawn,
        # then the finest; and another light's shadow goes at once.
        missing = [number for number in due if maps.maps[number].stamp != stamp]
        chosen = missing[-1:] if missing[-1:] == [len(maps.maps) - 1] else missing[:1]
        jumped = [
            number for number in due
            if number not in missing and float(maps.maps[number].sun @ frame.sun.direction) < _SUN_JUMP_COSINE
        ]  # fmt: skip
        whole = frame.settling or frame.one_shot
        self.due = (due if whole else sorted({*chosen, *jumped}) or due[:1]) if present else []
        for number in self.due:
            maps.move(number, foot, frame.sun.direction, frame.time_s, stamp, radius_m)
        self.drawn = [held.stamp == stamp for held in maps.maps]
        rows = np.zeros((3, MOST_MAPS, 4))
        anchor_foot = proxy.lattice.direction * radius_m
        for number, held in enumerate(maps.maps):
            rows[0, number] = *(anchor_foot - held.middle), 1.0 / held.half_m
            rows[1, number, :3], rows[2, number, :3] = held.u / held.longer, held.v
            rows[1, number, 3] = self.drawn[number]
        height_m = base_m + _HEIGHT * thickness_m
        block.shadow = (height_m, len(maps.maps) if present else 0, self._count, self._texels)
        block.shadow_from, block.shadow_u, block.shadow_v = rows
        grown = 1.0 + height_m / radius_m
        self._middles = [(*(held.middle * grown - proxy.anchor_m), held.half_m) for held in maps.maps]
        self._ups = [(*(held.middle / radius_m), held.longer) for held in maps.maps]

    def declare(
        self,
        builder: GraphBuilder,
        view: ViewInfo,
        system: str,
        bind_noise: Callable[[], None],
        seen: Callable[[], bool],
    ) -> None:
        side = self._texels
        builder.add_pass(
            "clouds.shadow",
            kind="compute",
            bind=lambda io: self._bind(io, view.index, bind_noise),
            system=system,
            creates=(
                TextureSpec(
                    SHADOW, "rgba16f", (side, side), "persistent", layers=MOST_MAPS, filter="linear",
                    help="sunlight that comes through all clouds: the beam, light from all over, the sky's share",
                ),
                TextureSpec(
                    SUN, "rg16f", (side, side, MOST_MAPS * (MOST_INTERVALS + 1)), "persistent", filter="linear",
                    help="share of the beam and optical depth towards the sun, at heights in the clouds",
                ),
                BufferSpec(SHADED, 4 * MOST_MAPS, "persistent", "which maps of the shadow have any"),
            ),
            when=lambda: bool(self.due),
            only_while=seen,
            help="the clouds' shadow around the camera",
        )  # fmt: skip

    def _bind(self, io: PassIO, view: int, bind_noise: Callable[[], None]) -> Callable[[], None]:
        shadow, sun, shaded = io.texture(SHADOW), io.texture(SUN), io.buffer(SHADED)
        if view in self._views:
            self._views[view].forget()

        def run() -> None:
            bind_noise()
            shadow.bind_to_image(0, read=False, write=True)
            sun.bind_to_image(1, read=False, write=True)
            shaded.bind_to_storage_buffer(0)
            for number in self.due:
                shaded.write(b"\0\0\0\0", offset=4 * number)
                self._program.set("u_level", number)
                self._program.set("u_middle", self._middles[number])
                self._program.set("u_up", self._ups[number])
                self._program.run_over(*shadow.size[:2])

        return run
