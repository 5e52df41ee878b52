"""Spray of waterfalls: which falls are near enough to show some, and the pass that draws it over the picture."""

from __future__ import annotations

import math
from collections.abc import Callable

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import DEPTH_UNIT, SPRAY_BUFFER, SPRAY_LIGHT_BUFFER
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.gpu import Compute, GpuScope, Program, VertexArray
from ...engine.graph import GraphBuilder, PassIO
from ...engine.wavelengths import Nanometres
from ...engine.world import World
from .rivers.fall_list import FallList, Falls
from .rivers.falls import HIGHEST_M
from .rivers.table import RiverTable

__all__ = ["Spray", "bow_angles", "spray_rows"]

Floats = NDArray[np.float64]

MOST = 8
"""Falls whose spray one picture shows: those that look highest."""
_SHOWN_PX, _WHOLE_PX = 3.0, 8.0
"""Heights on screen from which on there is some of their spray, and all."""
_DEPTH, _HIGHEST_M = 2.5, 40.0
"""Optical depth through the middle of a high fall's densest cloud, and from which height on that is reached."""
_ACROSS, _ACROSS_HEIGHT = 0.6, 0.25
"""Of that cloud's deviation across the water: by half widths and by heights, as terrain/spray.glsl has it."""
_LOOK_AGAIN_M = 50.0
_RISE_M_S, _PUFF, _FINER = 1.6, 0.45, 3.1
"""How fast puffs rise; how wide they are, in heights of the fall; and how many times finer the second octave is."""
_CELLS = 2.0**20
"""So many cells of noise come by before the first does again: weeks for a high fall, days for a low one."""
_ROW = 17
"""Numbers of a fall."""
_LIGHT_BYTES = 80
"""Of its SprayLight."""


def bow_angles(nm: Nanometres) -> tuple[float, float, float]:
    """Of the primary rainbow from the point opposite to the sun, rad, at three wavelengths.

    Descartes' ray of least deviation through a sphere, once reflected. Water's refractive index by Cauchy's formula
    through its values at 20 C in four of Fraunhofer's lines: 1.3311 (656 nm), 1.3330 (589), 1.3371 (486), 1.3404 (434).
    """
    found = []
    for wavelength in nm:
        index = 1.3242 + 3050.0 / wavelength**2
        into = math.acos(math.sqrt((index * index - 1.0) / 3.0))
        found.append(4.0 * math.asin(math.sin(into) / index) - 2.0 * into)
    return found[0], found[1], found[2]


def spray_rows(
    falls: Falls, camera_m: Floats, pixel_rad: float, strength: float, time_s: float = 0.0
) -> NDArray[np.float32]:
    """(K, 17), K at most MOST: what terrain/spray.vert reads of the falls whose spray a camera (3,) may see. strength:
    Terrain.spray. time_s: how far puffs have risen, as whole cells of their noise and the rest, so that both are
    right at any time."""
    away = falls.foot_m - camera_m
    distance_m = np.linalg.norm(away, axis=1)
    seen_px = falls.height_m / (np.maximum(distance_m, 1.0) * pixel_rad)
    near = np.flatnonzero((seen_px > _SHOWN_PX) & (strength > 0.0))
    near = near[np.argsort(-seen_px[near], kind="stable")]
    # Those that look as high as the first that is left out have hardly any: none comes or goes at once.
    shown_px = max(_SHOWN_PX, float(seen_px[near[MOST]])) if len(near) > MOST else _SHOWN_PX
    near = near[:MOST]
    near = near[np.argsort(-distance_m[near], kind="stable")]  # the nearest lies over the others
    rows = np.zeros((len(near), _ROW), np.float32)
    height, half_width = falls.height_m[near], falls.half_width_m[near]
    share = np.clip((seen_px[near] - shown_px) / (shown_px * (_WHOLE_PX / _SHOWN_PX - 1.0)), 0.0, 1.0)
    depth = _DEPTH * strength * share * np.minimum(height / _HIGHEST_M, 1.0)
    across_m = _ACROSS * half_width + _ACROSS_HEIGHT * height
    rows[:, :3], rows[:, 3] = away[near], depth / (math.sqrt(2.0 * math.pi) * across_m)
    rows[:, 4:7], rows[:, 7] = falls.foot_m[near] / np.linalg.norm(falls.foot_m[near], axis=1)[:, None], height
    rows[:, 8:11], rows[:, 11] = falls.way[near], half_width
    rows[:, 12] = falls.number[near] % 64
    for octave, finer in enumerate((1.0, _FINER)):
        risen = np.mod(_RISE_M_S * finer * time_s / (_PUFF * height), _CELLS)
        rows[:, 13 + 2 * octave], rows[:, 14 + 2 * octave] = np.floor(risen), risen - np.floor(risen)
    return rows


class _SprayView(ViewParts):
    """One view's falls."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.rows = self.gpu.buffer(reserve=4 * _ROW * MOST, dynamic=True)
        self.lights = self.gpu.buffer(reserve=_LIGHT_BYTES * MOST)
        self.count = 0
        self.array: VertexArray | None = None
        self.near: Falls | None = None  # those that may be seen from around `looked_m`
        self.looked_m: Floats | None = None
        self.key: tuple[FallList, float, float] | None = None


class Spray:
    """Of one planet's falls, for all views."""

    def __init__(self, gpu: GpuScope, world: World, nm: Nanometres) -> None:
        self._gpu, self._world, self._bow = gpu, world, bow_angles(nm)
        self._programs: tuple[Compute, Program] | None = None
        self._over = gpu.state(blend="premultiplied", write_depth=False)
        self._falls: tuple[RiverTable, FallList] | None = None

    def update(
        self, frame: Frame, table: RiverTable | None, strength: float, above_m: float, frozen_sine: float
    ) -> None:
        """Whatever the camera looks at, the pass may draw it. above_m: of the camera over the highest ground.
        frozen_sine: of the latitude from which on water is ice, above 1: nowhere."""
        own: _SprayView = frame.view.state(self, lambda: _SprayView(self._gpu))
        least_rad = _SHOWN_PX * frame.pixel_rad
        if table is None or strength <= 0.0 or least_rad * above_m > HIGHEST_M:
            own.count = 0
            return
        if self._falls is None or self._falls[0] is not table:
            self._falls = table, FallList(table)
        falls, camera_m = self._falls[1], frame.camera.position_m
        key = falls, frame.pixel_rad, frozen_sine
        moved_m = math.inf if own.looked_m is None else float(np.linalg.norm(camera_m - own.looked_m))
        if own.near is None or own.key != key or moved_m > _LOOK_AGAIN_M:
            own.looked_m, own.key = camera_m.copy(), key
            own.near = falls.around(camera_m, _LOOK_AGAIN_M, least_rad, frozen_sine)
        rows = spray_rows(own.near, camera_m, frame.pixel_rad, strength, frame.time_s)
        own.count = len(rows)
        if own.count:
            own.rows.write(rows.tobytes())

    def declare(self, builder: GraphBuilder, info: ViewInfo, seen: Callable[[], bool]) -> None:
        """The pass: after all surfaces, before the water around a lens below it, and before clouds. seen: whether any
        of the planet is."""
        view = info.view
        builder.add_pass(
            "terrain.spray",
            system="terrain",
            bind=lambda io: self._bind(io, view),
            reads=("gbuffer.depth", *contract_reads(self._world)),
            writes=("scene.radiance",),
            stage="detail",
            when=lambda: view.state(self, lambda: _SprayView(self._gpu)).count > 0,
            only_while=seen,
            help="spray of waterfalls",
        )

    def _bind(self, io: PassIO, view: View) -> Callable[[], None]:
        if self._programs is None:
            drawn = self._gpu.program(
                vertex="terrain/spray.vert",
                fragment="terrain/spray.frag",
                defines={"PUFF": str(_PUFF), "FINER": str(_FINER)},
            )
            self._programs = self._gpu.compute("terrain/spray_light.comp", {"SPRAY_ROW": _ROW}), drawn
        light, program = self._programs
        own: _SprayView = view.state(self, lambda: _SprayView(self._gpu))
        if own.array is None:
            falls = (own.rows, "4f 4f 4f 1f 4f /i", "in_foot", "in_up", "in_way", "in_seed", "in_risen")
            names = ("in_beam", "in_diffuse", "in_dense", "in_loss", "in_air")
            own.array = own.gpu.vertex_array(program, [falls, (own.lights, "4f 4f 4f 4f 4f /i", *names)])
        array = own.array
        target, depth = io.framebuffer(colors=("scene.radiance",)), io.texture("gbuffer.depth")
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            own.rows.bind_to_storage_buffer(SPRAY_BUFFER)
            own.lights.bind_to_storage_buffer(SPRAY_LIGHT_BUFFER)
            light.set("u_count", own.count)
            light.run_over(own.count)
            self._gpu.barrier()
            target.use()
            self._over.apply()
            depth.use(DEPTH_UNIT)
            program.set("u_bow_rad", self._bow)
            array.render(moderngl.TRIANGLE_STRIP, 4, instances=own.count)

        return run
