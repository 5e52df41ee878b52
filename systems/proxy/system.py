"""ProxySystem: snaps the camera proxy and its anchor, and writes the uniform blocks of the view.

This is where double precision ends: the camera's offset from the anchor is formed here in f64, and nothing larger
than it ever reaches the GPU. It runs before all other systems.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Atmosphere, Clouds, DebugView, Ocean, Planet, Terrain
from ...engine.frame_block import FRAME_BINDING, PLANET_BINDING, FrameBlock, PlanetBlock
from ...engine.planet_seen import planet_seen
from ...engine.space import near_plane_m, out_of_view, projection_terms
from ...engine.surface.field import HeightField
from ...engine.surface.lattice_anchor import LatticeAnchor
from ...engine.surface.proxy import ProxyCell, snap_proxy
from ...engine.system import Frame, Setup, System

LATTICE_BINDING = 2  # common/lattice.glsl
LATTICE_BYTES = 320

# Anchor heights are multiples of 1/16 m, so that their f32 copy in the frame block is exact (below 1000 km).
_HEIGHT_STEP_M = 1.0 / 16.0
_LEAST_PX = 0.25
"""A planet, air and all, that is narrower than this part of a pixel is not drawn: most pixels miss it anyway."""


@dataclass
class ProxyView:
    """What other systems read of a view's proxy: world resource ``proxy.<view index>``.

    lattice.direction and anchor_height_m place the anchor; generation grows with every snap.
    """

    cell: ProxyCell
    lattice: LatticeAnchor
    anchor_height_m: float
    anchor_m: NDArray[np.float64]
    ground_m: float
    generation: int


class ProxySystem(System):
    """Owns the frame, planet and lattice blocks. Needs a Planet."""

    name = "proxy"
    essential = True
    needs = (Planet,)

    def __init__(self) -> None:
        self._views: dict[int, ProxyView] = {}
        self._frame_block = FrameBlock()
        self._planet_block = PlanetBlock()

    def setup(self, setup: Setup) -> None:
        self._frame_ubo = setup.gpu.uniform_block(FrameBlock, FRAME_BINDING, "frame")
        self._planet_ubo = setup.gpu.uniform_block(PlanetBlock, PLANET_BINDING, "planet")
        self._lattice = setup.gpu.buffer(reserve=LATTICE_BYTES, dynamic=True)
        self._views.clear()
        self._field: HeightField | None = None
        self._uploaded: tuple[int, int] | None = None
        self._planet_written: PlanetBlock | None = None

    def release(self) -> None:
        self._views.clear()

    def update(self, frame: Frame) -> None:
        planet = frame.world.get(frame.planet, Planet)
        field: HeightField | None = frame.world.resources.get("height_field")
        sea = frame.world.try_get(frame.planet, Ocean)
        radius = planet.radius_m
        bare = 0.0 if sea is None else sea.sea_level_m  # without ground the sea is all there is

        def ground(directions: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.full(len(directions), bare) if field is None else field.height(directions)

        level = -np.inf if sea is None else sea.sea_level_m
        if float(np.linalg.norm(frame.camera.position_m)) - radius < level:
            level = -np.inf  # a diver is near the bed, not near the surface

        def surface(directions: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.maximum(ground(directions), level)

        planet_seen(frame.world, frame.view_index).value = self._planet_seen(frame, radius, field)
        view = self._views.get(frame.view_index)
        if view is not None and field is self._field and self._frozen(frame):
            self._write_blocks(frame, view, radius, field, sea)
            return
        fraction = float(frame.settings.get("proxy.fraction", 0.25))
        cell = snap_proxy(
            frame.camera.position_m,
            radius,
            surface,
            # On other ground a held cell would depend on what was there before.
            previous=None if view is None or frame.cut or field is not self._field else view.cell,
            fraction=fraction,
            may_update_early=self._planet_out_of_view(frame, radius, field),
        )
        if view is None or cell is not view.cell:
            view = self._new_anchor(view, cell, radius, ground, sea, frame)
            self._views[frame.view_index] = view
            frame.world.set_resource(f"proxy.{frame.view_index}", view)
        self._field = field
        self._write_blocks(frame, view, radius, field, sea)

    @staticmethod
    def _frozen(frame: Frame) -> bool:
        """Whether the grid is to stay where it is, as DebugView.freeze; other backends hold their tiles themselves."""
        terrain = frame.world.try_get(frame.planet, Terrain)
        grid = terrain is None or terrain.backend == "grid"
        return grid and any(shown.freeze for _, (shown,) in frame.world.query(DebugView))

    @staticmethod
    def _planet_seen(frame: Frame, radius: float, field: HeightField | None) -> bool:
        """Whether the planet, its air and its clouds may be in the picture, and are large enough to be."""
        air, clouds = frame.world.try_get(frame.planet, Atmosphere), frame.world.try_get(frame.planet, Clouds)
        sea_top_m = frame.world.try_resource("sea_top_m")
        tops = [0.0, 0.0 if field is None else field.highest_m, 0.0 if sea_top_m is None else float(sea_top_m)]
        tops += [] if air is None else [float(air.thickness_m)]
        tops += [] if clouds is None else [float(layer.top_m) for layer in (clouds, *clouds.layers)]
        camera, reach = frame.camera, radius + max(tops)
        pixel = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        if 2.0 * reach < _LEAST_PX * pixel * float(np.linalg.norm(camera.position_m)):
            return False
        return not out_of_view(camera, -camera.position_m, reach)

    @staticmethod
    def _planet_out_of_view(frame: Frame, radius: float, field: HeightField | None) -> bool:
        """True when no part of the planet can be in the picture, so that a snap cannot be seen."""
        reach = radius + max(0.0 if field is None else field.highest_m, 0.0)
        return out_of_view(frame.camera, -frame.camera.position_m, reach)

    def _new_anchor(
        self, old: ProxyView | None, cell: ProxyCell, radius: float, ground: Any, sea: Ocean | None, frame: Frame
    ) -> ProxyView:
        lattice = cell.anchor()
        bed = float(ground(lattice.direction[None])[0])
        top = bed if sea is None else max(bed, sea.sea_level_m)
        altitude = float(np.linalg.norm(frame.camera.position_m)) - radius
        # Near the nearest surface: the sea's for a camera above it, the camera's own depth below it, else the ground.
        height = round(float(np.clip(altitude, bed, top)) / _HEIGHT_STEP_M) * _HEIGHT_STEP_M
        anchor = lattice.direction * (radius + height)
        return ProxyView(cell, lattice, height, anchor, bed, 1 if old is None else old.generation + 1)

    def _write_blocks(
        self, frame: Frame, view: ProxyView, radius: float, field: HeightField | None, sea: Ocean | None
    ) -> None:
        camera = frame.camera
        block = self._frame_block
        terms = projection_terms(camera)
        distance = float(np.linalg.norm(camera.position_m))
        zenith = camera.position_m / distance
        offset = camera.position_m - view.anchor_m
        width, height = frame.size
        x_px, y_px = frame.jitter_px
        if x_px or y_px:
            sx, sy, ox, oy = terms
            terms = (sx, sy, ox + 2.0 * x_px / width * sx, oy + 2.0 * y_px / height * sy)
        # Water may cut the near plane: each pixel is then seen from the side of it that its lens is on.
        near = near_plane_m(abs(distance - radius - view.ground_m))
        sun = frame.sun
        block.camera_right = (*camera.right, 0.0)
        block.camera_up = (*camera.up, 0.0)
        block.camera_forward = (*camera.forward, 0.0)
        block.projection = terms
        block.camera_offset = (*offset, near)
        block.camera_zenith = (*zenith, distance - radius)
        block.anchor_up = (*view.lattice.direction, view.anchor_height_m)
        block.sun_direction = (*sun.direction, sun.angular_radius_rad)
        block.sun_irradiance = (*sun.irradiance, 0.0)
        block.viewport = (width, height, 1.0 / width, 1.0 / height)
        block.clock = (frame.time_s % 4096.0, 0.0, 0.0, 2.0 * terms[1] / height)
        self._frame_ubo.write(block)
        self._frame_ubo.bind()

        bare = 0.0 if sea is None else sea.sea_level_m
        lowest = bare if field is None else field.lowest_m
        highest = bare if field is None else field.highest_m
        drawn_lowest = lowest if sea is None else max(lowest, sea.sea_level_m)
        top_m = frame.world.try_resource("sea_top_m")
        if distance - radius < (drawn_lowest if top_m is None else max(drawn_lowest, top_m)):
            drawn_lowest = lowest  # under water the bed is what hides
        planet = PlanetBlock(
            radii=(radius, highest, lowest, drawn_lowest),
            sea=(0.0, 0.0, 0.0, 0.0) if sea is None else (sea.sea_level_m, 1.0, 0.0, 0.0),
        )
        if planet != self._planet_written:
            self._planet_ubo.write(planet)
            self._planet_written = planet
        self._planet_ubo.bind()
        if self._uploaded != (frame.view_index, view.generation):
            self._lattice.write(view.lattice.block.tobytes())
            self._uploaded = (frame.view_index, view.generation)
        self._lattice.bind_to_uniform_block(LATTICE_BINDING)


__all__ = ["ProxySystem", "ProxyView"]
