"""The pass that draws maps of the clouds' shadow, and where they lie in this frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import CloudLayer
from ...engine.blocks.bindings import CLOUD_SHADED_BUFFER
from ...engine.blocks.layout import zeros
from ...engine.frame import Frame, View, ViewInfo
from ...engine.gpu import GpuScope
from ...engine.gpu import gl as G
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from .columns import intervals_of, span_rows, spans_of
from .shadow import ShadowMap, ShadowMaps
from .view_block import CLOUD_VIEW, MOST_INTERVALS, MOST_MAPS, CloudShadowMap, CloudViewBlock

__all__ = ["SHADED", "SHADOW", "SUN", "ShadowPass", "ViewShadow"]

Floats = NDArray[np.float64]

SHADOW, SUN, SHADED = "clouds.shadow", "clouds.sun", "clouds.shaded"
_NEXT_SUN = "clouds.next_sun"
"""Of the map that is being made; the rest of that is the layer after the others of SHADOW."""
_SUN_JUMP_COSINE = float(np.cos(np.radians(2.0)))
"""As in history.py: a sun that turned by more within a frame was put elsewhere."""
GROUP = 8  # rows of a work group in shadow.comp
_MOST_SPLIT = 8
"""As in shadow.comp."""
_NO_MAP = zeros(CloudShadowMap)
_HEIGHT = 0.3
"""Share of the first layer's thickness at which the maps lie."""


class ViewShadow:
    """One view's maps, and what its frame does to them. Before `ShadowPass.place` nothing."""

    def __init__(self, texels: int) -> None:
        self.maps = ShadowMaps(texels)
        self.last = -1
        """The map that was made last: the others that are due come before it does again."""
        self.due: list[int] = []
        """Maps that this frame draws whole."""
        self.drawn: list[bool] = []
        """Which maps show what they should, but for a little drift."""
        self.finished: int | None = None
        """The map whose last strip is there: it is shown from this frame on."""
        self.rows: tuple[int, int] = (0, 0)
        """Of the strip that this frame draws."""
        self.wholes: list[tuple[int, Mapping[str, Any]]] = []
        self.strip: Mapping[str, Any] | None = None
        """Uniforms of the maps drawn whole, and of the one that is drawn in strips."""

    @property
    def busy(self) -> bool:
        """Whether this frame changes any map, or prepares one."""
        return bool(self.due) or self.finished is not None or self.maps.making is not None

    @property
    def complete(self) -> bool:
        """Whether all maps that anybody asks for are there."""
        return all(self.drawn[self.maps.finest :])


class ShadowPass:
    """Of all views of one planet. steps: samples through a layer; texels: a side of each map; frames: over how many a
    map is drawn, on average over all of them, with the sun overhead.

    Pass ``clouds.shadow`` makes ``clouds.shadow`` (what of the sunlight comes through all clouds), ``clouds.sun`` (what
    is left of it at heights in them) and ``clouds.shaded`` (which maps have any shadow at all). A map takes as long as
    all else of a frame, or longer; so it is drawn in strips, into textures of its own, for the place and the sun for
    which it was begun, while the old one is shown. Whole at once it is where there is nothing to show yet, where the
    sun has jumped, in pictures by themselves, and where strips would be out of date before the last one is drawn.
    """

    def __init__(self, gpu: GpuScope, texels: int, steps: int, frames: int) -> None:
        self._gpu = gpu
        self._program = gpu.compute("clouds/shadow.comp")
        self.texels, self._steps, self._frames = texels, steps, frames
        self._thick_m: list[float] = []
        """Of the intervals of height, and into how many steps each is divided at least."""
        self._each = 1

    def of(self, view: View) -> ViewShadow:
        """That view's."""
        return view.state(self, lambda: ViewShadow(self.texels))

    def take_layers(self, block: CloudViewBlock, layers: Sequence[CloudLayer]) -> None:
        """The clouds have changed. layers: those with cloud, lowest first."""
        spans = spans_of(layers, self._steps)
        intervals = intervals_of(spans)
        self._thick_m = (intervals[:, 1] - intervals[:, 0]).tolist()
        self._count = len(intervals)
        block.spans = span_rows(spans)
        # So many samples lie in each interval that a layer has `steps` of them.
        most = max((span.intervals for span in spans), default=1)
        self._each = -(-self._steps // most)
        self._program.set("u_steps", self._each)
        heights = np.zeros((MOST_INTERVALS, 2), np.float32)
        heights[: self._count] = intervals
        self._program.set("u_intervals", heights)

    def place(
        self, frame: Frame, block: CloudViewBlock, first: tuple[float, float], wind_m_s: float, stamp: object,
        radius_m: float, present: bool, steady: bool,
    ) -> None:  # fmt: skip
        """Where the maps lie, and which are due. first: base and thickness of the first layer, in metres. steady: the
        weather is what the time asks for, and no stand-in."""
        base_m, thickness_m = first
        proxy = frame.view.proxy
        own = self.of(frame.view)
        maps = own.maps
        if frame.cut:
            maps.forget()
        maps.place(radius_m, thickness_m)
        foot, sun = frame.camera.direction, frame.sun.direction
        maps.follow(foot, sun, frame.time_s, steady)
        top_m = block.highest_m
        camera = frame.camera
        pixel_rad = frame.pixel_rad
        maps.need(pixel_rad * max(float(np.linalg.norm(camera.position_m)) - radius_m - top_m, 0.0))
        alone = frame.settling or frame.one_shot
        if present and not alone:
            maps.outrun(self.frames_of_maps(maps, float(foot @ sun)), radius_m)
        own.finished, own.rows = None, (0, 0)
        if maps.making is not None and maps.making.rows >= self.texels:
            own.finished = own.last = maps.finish()
        due = maps.due(foot, sun, frame.time_s, wind_m_s, stamp, radius_m) if present else []
        here = (foot, sun, frame.time_s, stamp, radius_m)
        if alone or not present:
            own.due, maps.making = due, None
        else:
            own.due = self._at_once(maps, due, sun, stamp)
            self._prepare(own, due, wind_m_s, here)
        for number in own.due:
            maps.move(number, *here, alone=alone)
        own.drawn = [held.stamp == stamp for held in maps.maps]
        anchor_foot = proxy.lattice.direction * radius_m
        placed = [
            CloudShadowMap(anchor_foot - held.middle, 1.0 / held.half_m, held.u / held.longer, float(drawn), held.v)
            for held, drawn in zip(maps.maps, own.drawn, strict=True)
        ]
        block.shadow_maps = placed + [_NO_MAP] * (MOST_MAPS - len(placed))
        # Each look at a map takes time, also at one that counts for nothing.
        block.finest_map = next((number for number, drawn in enumerate(own.drawn) if drawn), 0)
        height_m = base_m + _HEIGHT * thickness_m
        block.shadow_height_m, block.shadow_map_count = height_m, len(maps.maps) if present else 0
        block.shadow_intervals, block.shadow_texels = self._count, self.texels
        grown = 1.0 + height_m / radius_m

        def geometry(held: ShadowMap) -> dict[str, Any]:
            return {
                "u_middle_m": tuple((held.middle * grown - proxy.anchor_m).tolist()),
                "u_half_m": held.half_m,
                "u_up": tuple((held.middle / radius_m).tolist()),
                "u_longer": held.longer,
                "u_along": tuple((held.u / held.longer).tolist()),
                "u_across": tuple(held.v.tolist()),
                "u_sun": tuple(held.sun.tolist()),
            }

        own.wholes = [(number, geometry(maps.maps[number])) for number in own.due]
        own.strip = None if maps.making is None else geometry(maps.making.map)

    @staticmethod
    def _at_once(maps: ShadowMaps, due: list[int], sun: Floats, stamp: object) -> list[int]:
        """Of what has nothing to show yet the widest, which stands for the others until they are drawn. Another light's
        shadow goes at once, and all maps have to take its place."""
        missing = [number for number in due if maps.maps[number].stamp != stamp]
        shown = [maps.maps[number] for number in due if number not in missing]
        making = [] if maps.making is None else [maps.making.map]
        if any(float(held.sun @ sun) < _SUN_JUMP_COSINE for held in (*shown, *making)):
            found = due
        else:
            found = missing[-1:] if missing[-1:] == [len(maps.maps) - 1] else []
        if maps.making is not None and (found or maps.making.map.stamp != stamp):
            maps.making = None
        return found

    def _prepare(
        self, own: ViewShadow, due: list[int], wind_m_s: float, here: tuple[Floats, Floats, float, object, float]
    ) -> None:
        """One strip a frame, or where there is no time for strips, one map; none in frames that draw others whole."""
        if own.due:
            return
        maps = own.maps
        if maps.making is None and due:
            stamp, radius_m = here[3:]
            # First what has nothing to show yet, then one after another.
            number = min(due, key=lambda n: (maps.maps[n].stamp == stamp, n <= own.last, n))
            frames = maps.frames_for(
                number, self.frames_of_maps(maps, float(here[0] @ here[1]))[number], wind_m_s, radius_m
            )
            if frames == 1:
                own.due, own.last = [number], number
                return
            maps.begin(number, frames, *here)
        making = maps.making
        if making is not None:
            groups = -(-self.texels // GROUP)
            to = -(-groups * (making.strips + 1) // making.frames) * GROUP
            own.rows = (making.rows, min(to, self.texels))

    def frames_of_maps(self, maps: ShadowMaps, rise: float) -> list[int]:
        """Frames for each map, of all that those which are drawn have together: in fine ones the sun's rays are
        followed in several times as many steps, and frames should cost alike whichever map is drawn. rise: the sine of
        the sun's elevation."""
        if self._frames == 1:
            return [1] * len(maps.maps)

        def steps(half_m: float, rise: float) -> int:
            """Of a ray, as in shadow.comp at the map's middle."""
            stride_m = 4.0 * half_m / self.texels * self._each * max(rise, 1e-3)
            return sum(min(max(int(thick_m / stride_m), 1), _MOST_SPLIT) for thick_m in self._thick_m)

        each = [steps(held.half_m, rise) for held in maps.maps]
        drawn = each[maps.finest :]
        # What a low sun makes all of them dearer by is halved between longer frames and more of them.
        dearer = math.sqrt(sum(drawn) / sum(steps(held.half_m, 1.0) for held in maps.maps[maps.finest :]))
        most = -(-self.texels // GROUP)
        shares = (round(self._frames * dearer * one * len(drawn) / sum(drawn)) for one in each)
        return [min(max(share, 1), most) for share in shares]

    def declare(
        self,
        builder: GraphBuilder,
        view: ViewInfo,
        system: str,
        bind_noise: Callable[[], None],
        seen: Callable[[], bool],
    ) -> None:
        side, own = self.texels, self.of(view.view)
        builder.add_pass(
            "clouds.shadow",
            kind="compute",
            bind=lambda io: self._bind(io, own, bind_noise),
            system=system,
            reads=(CLOUD_VIEW,),
            creates=(
                TextureSpec(
                    SHADOW, "rgba16f", (side, side), "persistent", layers=MOST_MAPS + 1, filter="linear",
                    help="sunlight that comes through all clouds: the beam, light from all over, the sky's share",
                ),
                TextureSpec(
                    SUN, "rg16f", (side, side, MOST_MAPS * (MOST_INTERVALS + 1)), "persistent", filter="linear",
                    help="share of the beam and optical depth towards the sun, at heights in the clouds",
                ),
                TextureSpec(_NEXT_SUN, "rg16f", (side, side, MOST_INTERVALS + 1), "persistent", filter="linear"),
                BufferSpec(SHADED, 4 * (MOST_MAPS + 1), "persistent", "which maps of the shadow have any"),
            ),
            when=lambda: own.busy,
            only_while=seen,
            help="the clouds' shadow around the camera",
        )  # fmt: skip

    def _bind(self, io: PassIO, own: ViewShadow, bind_noise: Callable[[], None]) -> Callable[[], None]:
        shadow, sun, shaded = io.texture(SHADOW), io.texture(SUN), io.buffer(SHADED)
        next_sun = io.texture(_NEXT_SUN)
        # A graph that is compiled anew keeps its persistent textures, unless they have another size.
        maps = own.maps
        if maps.texture is not shadow:
            maps.forget()
        maps.texture = shadow
        side, slices = self.texels, MOST_INTERVALS + 1
        gpu = self._gpu.gpu

        def draw(into: Any, layer: int, first: int, rows: tuple[int, int], where: Mapping[str, Any]) -> None:
            shadow.bind_to_image(0, read=False, write=True)
            into.bind_to_image(1, read=False, write=True)
            if rows[0] == 0:
                shaded.write(b"\0\0\0\0", offset=4 * layer)
            for name, value in {**where, "u_layer": layer, "u_first": first, "u_rows": rows}.items():
                self._program.set(name, value)
            self._program.run_over(side, rows[1] - rows[0])

        def finish(number: int) -> None:
            gpu.barrier()  # strips are written as images
            gpu.gl.copy_layers(G.TEXTURE_2D_ARRAY, shadow.glo, MOST_MAPS, shadow.glo, number, (side, side, 1))
            gpu.gl.copy_layers(G.TEXTURE_3D, next_sun.glo, 0, sun.glo, number * slices, (side, side, slices))
            gpu.ctx.copy_buffer(shaded, shaded, 4, read_offset=4 * MOST_MAPS, write_offset=4 * number)

        def run() -> None:
            if own.finished is not None:
                finish(own.finished)
            if not own.due and own.strip is None:
                return
            bind_noise()
            shaded.bind_to_storage_buffer(CLOUD_SHADED_BUFFER)
            for number, where in own.wholes:
                draw(sun, number, number * slices, (0, side), where)
            making = maps.making
            if making is not None and own.strip is not None and own.rows[1] > own.rows[0]:
                draw(next_sun, MOST_MAPS, 0, own.rows, own.strip)
                making.rows = own.rows[1]
                making.strips += 1

        return run
