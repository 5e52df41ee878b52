"""ProxySystem: snaps the camera proxy and its anchor, and writes the uniform blocks of the view.

This is where double precision ends: the camera's offset from the anchor is formed here in f64, and nothing larger
than it ever reaches the GPU. It runs before all other systems.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Atmosphere, Clouds, Cover, Ocean, Planet
from ...engine.blocks.bindings import FRAME_BLOCK, LATTICE_BLOCK, PLANET_BLOCK
from ...engine.frame import Frame, Proxy, View, ViewParts, Views
from ...engine.frame.block import FrameBlock, PlanetBlock, frame_of_anchor
from ...engine.frame.published import HEIGHT_FIELD, SEA_TOP_M
from ...engine.gpu import GpuScope
from ...engine.gpu.uniforms import UniformBlock
from ...engine.space import least_elevation_rad, length, near_plane_m, out_of_view, projection_terms, sphere_unseen
from ...engine.surface.field import HeightField
from ...engine.surface.proxy import GroundHeight, ProxyCell, snap_proxy
from ...engine.surface.skyline import Skyline
from ...engine.system import Setup, System
from .waiting import Motion, may_wait

Floats = NDArray[np.float64]

LATTICE_BYTES = 320

# Anchor heights are multiples of 1/16 m, so that their f32 copy in the frame block is exact (below 1000 km).
_HEIGHT_STEP_M = 1.0 / 16.0
_LEAST_PX = 0.25
"""A planet, air and all, that is narrower than this part of a pixel is not drawn: most pixels miss it anyway."""

_TREES_TALL = 3.0
"""Of Cover.height_m, with room for all that is taller and for slopes."""
_TREES_REACH_M = 3000.0
_TREES_RISE_RAD = 0.35
"""How far trees on a slope beside the camera may rise over its ground."""


class _Kept(ViewParts):
    """Of one view: how its camera moves, the ground around it, and the lattice around its anchor."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.motion, self.skyline = Motion(), Skyline()
        self.lattice = self.gpu.buffer(reserve=LATTICE_BYTES, dynamic=True)
        self.generation = -1
        """The proxy that the lattice is of."""


class ProxySystem(System):
    """Owns the frame, planet and lattice blocks. Needs a Planet."""

    name = "proxy"
    essential = True
    needs = (Planet,)

    def __init__(self) -> None:
        self._views = Views()
        self._generation = 0
        self._ahead_ubo: UniformBlock | None = None
        self._ahead_lattice: Any = None

    def setup(self, setup: Setup) -> None:
        self._gpu, self._views = setup.gpu, setup.views
        self._ahead_ubo = self._ahead_lattice = None
        self._frame_ubo = setup.gpu.uniform_block(FrameBlock, FRAME_BLOCK, "frame")
        self._planet_ubo = setup.gpu.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")
        self._field: HeightField | None = None

    def _of(self, view: View) -> _Kept:
        return view.state(self, lambda: _Kept(self._gpu))

    def release(self) -> None:
        for view in self._views:
            view.snap.drop()
            view.placed = None

    def update(self, frame: Frame) -> None:
        planet = frame.world.get(frame.planet, Planet)
        field: HeightField | None = frame.world.try_resource(HEIGHT_FIELD)
        sea = frame.world.try_get(frame.planet, Ocean)
        radius = planet.radius_m
        bare = 0.0 if sea is None else sea.sea_level_m  # without ground the sea is all there is

        def ground(directions: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.full(len(directions), bare) if field is None else field.height(directions)

        level = -np.inf if sea is None else sea.sea_level_m
        if frame.camera.distance_m - radius < level:
            level = -np.inf  # a diver is near the bed, not near the surface

        def surface(directions: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.maximum(ground(directions), level)

        seen, proxy = self._planet_seen(frame, radius, field), frame.view.placed
        # Where no part of the planet can be in the picture a snap cannot be seen.
        unseen = not seen or sphere_unseen(frame.camera, radius + self._top_m(frame, field), self._pixel(frame))
        frame.view.seen.tell(seen, self.ground_seen(frame, radius, field, unseen))
        if proxy is not None and field is self._field and frame.frozen:
            if frame.at_once:
                frame.view.snap.drop()
            # Else what is being prepared goes on: a flight that is held for a look is none the worse for it.
        else:
            proxy = self._place(frame, proxy, radius, surface, ground, sea, field, unseen)
            self._field = field
        self._write_blocks(frame, proxy, radius, field, sea)

    def _place(
        self,
        frame: Frame,
        proxy: Proxy | None,
        radius: float,
        surface: GroundHeight,
        ground: GroundHeight,
        sea: Ocean | None,
        field: HeightField | None,
        unseen: bool,
    ) -> Proxy:
        """The view's proxy in this frame: the held one, or a new one, at once or prepared ahead."""
        camera_m = frame.camera.position_m
        # On other ground a held cell would depend on what was there before.
        fresh = proxy is None or frame.cut or field is not self._field or proxy.cell.radius_m != radius
        ahead, motion = frame.view.snap, self._of(frame.view).motion
        frames = int(frame.settings.get("proxy.ahead_frames", 0))
        waits = frames > 0 and ahead.wanted and not (fresh or frame.at_once or unseen)
        ahead.possible, asked, ahead.asked = waits, ahead.asked, False
        if not waits:
            ahead.drop()
        if fresh:
            motion.forget()
        if ahead.ready:
            proxy = frame.view.placed = ahead.proxy
            ahead.drop()
        previous = None if proxy is None or fresh else proxy.cell
        level_m = -np.inf if sea is None else sea.sea_level_m
        limits = (0.0, 0.0) if field is None else (field.lowest_m, field.highest_m)

        def shown_by(cell: ProxyCell) -> bool:
            return may_wait(cell, camera_m, float(surface(frame.camera.direction[None])[0]), level_m, limits)

        moving, held = waits and previous is not None, False
        if previous is not None:
            motion.follow(camera_m, radius, previous.ground_height_m, frame.dt_s)
            if waits:
                held = previous.contains(camera_m)
                waits = held or shown_by(previous)
        if proxy is not None and waits and ahead.proxy is not None:
            return proxy
        fraction = float(frame.settings.get("proxy.fraction", 0.25))
        cell = previous if held else None
        if cell is None:
            cell = snap_proxy(camera_m, radius, surface, previous, fraction, may_update_early=unseen)
        if proxy is not None and cell is proxy.cell and not (waits and asked):
            ahead.drop()
            return proxy
        count, place_m = 0, camera_m
        if moving and previous is not None:
            count = motion.frames_of(previous, frames) if waits else 0
            foot, above_m = motion.foreseen(count, frames)
            there_m = foot * (radius + float(surface(foot[None])[0]) + above_m)
            later = snap_proxy(there_m, radius, surface, previous, fraction)
            if later is not previous:
                later = motion.covered(later, count, frames)
                if count or shown_by(later):
                    cell, place_m = later, there_m
        made = self._new_anchor(cell, radius, ground, sea, place_m)
        if proxy is not None and count:
            self._prepare(frame.view, made, count)
            return proxy
        ahead.drop()
        frame.view.placed = made
        return made

    def _prepare(self, view: View, proxy: Proxy, frames: int) -> None:
        """From now on makers prepare that proxy."""
        ahead = view.snap
        if self._ahead_ubo is None or self._ahead_lattice is None:
            self._ahead_ubo = self._gpu.uniform_block(FrameBlock, FRAME_BLOCK)
            self._ahead_lattice = self._gpu.buffer(reserve=LATTICE_BYTES, dynamic=True)
        ubo, lattice = self._ahead_ubo, self._ahead_lattice

        def bind() -> None:
            # Views take turns with these blocks. Vertices depend on nothing else of the frame.
            ubo.write(frame_of_anchor(proxy.lattice.direction, proxy.anchor_height_m))
            ubo.bind()
            lattice.write(proxy.lattice.block.tobytes())
            lattice.bind_to_uniform_block(LATTICE_BLOCK)

        ahead.bind_anchor, ahead.restore_anchor = bind, lambda: self.bind_anchor(view)
        ahead.begin(proxy, frames)

    def bind_anchor(self, view: View) -> None:
        """Bind the blocks of frame and lattice, as they are after `update`."""
        self._frame_ubo.bind()
        self._of(view).lattice.bind_to_uniform_block(LATTICE_BLOCK)

    def settled(self, view: View) -> bool:
        return view.snap.proxy is None

    @staticmethod
    def _planet_seen(frame: Frame, radius: float, field: HeightField | None) -> bool:
        """Whether the planet, its air and its clouds may be in the picture, and are large enough to be."""
        air, clouds = frame.world.try_get(frame.planet, Atmosphere), frame.world.try_get(frame.planet, Clouds)
        tops = [ProxySystem._top_m(frame, field)]
        tops += [] if air is None else [float(air.thickness_m)]
        tops += [] if clouds is None else [float(layer.top_m) for layer in (clouds, *clouds.layers)]
        camera, reach = frame.camera, radius + max(tops)
        pixel = frame.pixel_rad
        if 2.0 * reach < _LEAST_PX * pixel * camera.distance_m:
            return False
        return not out_of_view(camera, -camera.position_m, reach)

    @staticmethod
    def _pixel(frame: Frame) -> float:
        """A pixel as a tangent: rays are moved by less where a frame is jittered."""
        camera = frame.camera
        return max((camera.tan_right - camera.tan_left) / frame.size[0], frame.pixel_rad)

    @staticmethod
    def _top_m(frame: Frame, field: HeightField | None) -> float:
        """No ground or sea is higher."""
        sea_top_m = frame.world.try_resource(SEA_TOP_M)
        return max(0.0, 0.0 if field is None else field.highest_m, 0.0 if sea_top_m is None else float(sea_top_m))

    def ground_seen(self, frame: Frame, radius: float, field: HeightField | None, unseen: bool) -> bool:
        """Whether ground or sea may be in the picture; near mountains by the surrounding terrain's skyline. unseen:
        nothing of the planet is in it."""
        if unseen:
            return False
        sea_top_m = frame.world.try_resource(SEA_TOP_M)
        camera = frame.camera
        if field is None or (sea_top_m is not None and camera.distance_m - radius <= float(sea_top_m)):
            return True
        elevation = least_elevation_rad(camera, self._pixel(frame))
        cover = frame.world.try_get(frame.planet, Cover)
        if cover is not None:
            # Trees stand above the ground's skyline: around the camera, or on slopes beside it.
            above_m = camera.distance_m - radius - float(field.height(camera.direction[None])[0])
            if above_m < _TREES_TALL * cover.height_m:
                return True
            if above_m < _TREES_REACH_M:
                elevation -= _TREES_RISE_RAD
        return not self._of(frame.view).skyline.below(field, camera.position_m, radius, elevation)

    def _new_anchor(self, cell: ProxyCell, radius: float, ground: Any, sea: Ocean | None, camera_m: Floats) -> Proxy:
        lattice = cell.anchor()
        bed = float(ground(lattice.direction[None])[0])
        top = bed if sea is None else max(bed, sea.sea_level_m)
        altitude = length(camera_m) - radius
        # Near the nearest surface: the sea's for a camera above it, the camera's own depth below it, else the ground.
        height = round(float(np.clip(altitude, bed, top)) / _HEIGHT_STEP_M) * _HEIGHT_STEP_M
        anchor = lattice.direction * (radius + height)
        self._generation += 1  # never twice: a proxy that was prepared may come to nothing
        return Proxy(cell, lattice, height, anchor, bed, self._generation)

    def _write_blocks(
        self, frame: Frame, proxy: Proxy, radius: float, field: HeightField | None, sea: Ocean | None
    ) -> None:
        camera = frame.camera
        sx, sy, ox, oy = projection_terms(camera)
        distance, zenith = camera.distance_m, camera.direction
        offset = camera.position_m - proxy.anchor_m
        width, height = frame.size
        x_px, y_px = frame.jitter_px
        if x_px or y_px:
            ox, oy = ox + 2.0 * x_px / width * sx, oy + 2.0 * y_px / height * sy
        # Water may cut the near plane: each pixel is then seen from the side of it that its lens is on.
        near_m = near_plane_m(abs(distance - radius - proxy.ground_m))
        sun = frame.sun
        block = FrameBlock(
            camera_right=camera.right,
            near_m=near_m,
            camera_up=camera.up,
            pixel_rad=frame.pixel_rad,
            camera_forward=camera.forward,
            time_s=frame.time_s % 4096.0,
            projection_scale=(sx, sy),
            projection_offset=(ox, oy),
            camera_offset_m=offset,
            checkerboard=-1 if frame.checkerboard is None else frame.checkerboard,
            camera_zenith=zenith,
            camera_altitude_m=distance - radius,
            anchor_up=proxy.lattice.direction,
            anchor_height_m=proxy.anchor_height_m,
            sun_direction=sun.direction,
            sun_radius_rad=sun.angular_radius_rad,
            sun_irradiance=sun.irradiance,
            hdr_per_radiance=1.0,
            viewport_px=(width, height),
            texel_size=(1.0 / width, 1.0 / height),
            radiance_per_hdr=1.0,
        )
        self._frame_ubo.write(block)
        self._frame_ubo.bind()

        bare = 0.0 if sea is None else sea.sea_level_m
        lowest = bare if field is None else field.lowest_m
        highest = bare if field is None else field.highest_m
        drawn_lowest = lowest if sea is None else max(lowest, sea.sea_level_m)
        top_m = frame.world.try_resource(SEA_TOP_M)
        if distance - radius < (drawn_lowest if top_m is None else max(drawn_lowest, top_m)):
            drawn_lowest = lowest  # under water the bed is what hides
        self._planet_ubo.write(PlanetBlock(radius, highest, lowest, drawn_lowest, bare, has_sea=sea is not None))
        self._planet_ubo.bind()
        own = self._of(frame.view)
        if own.generation != proxy.generation:
            own.generation = proxy.generation
            self._gpu.upload(own.lattice, proxy.lattice.block.tobytes())
        own.lattice.bind_to_uniform_block(LATTICE_BLOCK)


__all__ = ["ProxySystem"]
