"""The ground's cells on the projected grid: rings around the proxy whose spacing doubles with distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....components import Ocean, Planet
from ....engine.blocks.bindings import TERRAIN_GRID_BLOCK
from ....engine.blocks.layout import Vec3
from ....engine.frame import Frame, Proxy
from ....engine.frame.snapping import Scale, SnapAhead
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellPrograms
from ....engine.settings import Settings
from ....engine.snapped import CellChoice, FadePrograms, SnappedMesh
from ....engine.surface.coverage import proxy_coverage
from ....engine.surface.selection import MOST_CELLS, chord_limit_m, select_rings, spacing_angle
from .base import Ground, GroundRevision

__all__ = ["GridChoice", "GridMaking", "GridMesh", "GridSpacing", "TerrainGridBlock"]

_DECIMATED_SHARE = 0.8  # of edge_px: larger ones save vertices, but the ground jumps more at a snap
_FINEST_M = 0.02


@dataclass(frozen=True)
class GridSpacing:
    """How far apart vertices shall be around a proxy (terrain/grid_spacing.glsl)."""

    per_distance: float
    """metres per metre from the proxy"""
    smallest_m: float
    proxy_height_m: float
    """above the ground"""


@dataclass
class TerrainGridBlock:
    """The grid that is drawn. GLSL: ``generated/terrain_grid.glsl``, ``terrain_grid``."""

    spacing: GridSpacing
    faded: GridSpacing
    """of the selection that fades out"""
    faded_share: Annotated[float, "0..1"]
    """of that selection in what is drawn"""
    moved_m: Vec3
    """the anchor's foot, from that of the selection that fades out"""


@dataclass(kw_only=True)
class GridChoice(CellChoice):
    """A selection and what its vertices depend on."""

    spacing: GridSpacing
    stamp: int
    """Of the ground that was there, see Backend.ground_stamp."""

    def foot_m(self, radius_m: float) -> NDArray[np.float64]:
        """The anchor's on the reference sphere, from the planet's centre."""
        return self.proxy.anchor_m * (radius_m / (radius_m + self.proxy.anchor_height_m))


class GridSurface(NamedTuple):
    """What the ground's cells depend on beside proxy and scale."""

    ground: GroundRevision
    min_spacing_m: float
    stamp: int


class GridMaking:
    """What makes the ground's vertices, shared by all views."""

    def __init__(self, gpu: GpuScope, settings: Settings) -> None:
        self.programs = CellPrograms(gpu, int(settings["terrain.quads"]), "terrain/vertices.comp")
        self.most = int(settings["terrain.decimation"])
        self.prepares = int(settings["proxy.ahead_frames"]) > 0
        fade_s = float(settings["terrain.fade_s"])
        files = "terrain/fade/cells.comp", "terrain/fade/vertices.comp"
        self.fading = FadePrograms(gpu, *files, self.programs, fade_s) if fade_s > 0.0 else None


class GridMesh(SnappedMesh[GridChoice]):
    """One view's ground."""

    phases: ClassVar[tuple[str, ...]] = ("ground", "fade")

    def __init__(self, of: GpuScope, making: GridMaking) -> None:
        super().__init__(of, "terrain", making.programs, making.prepares, making.fading)
        self._making = making
        self.ubo = self.gpu.uniform_block(TerrainGridBlock, TERRAIN_GRID_BLOCK)
        self.ground: Ground
        self.bind_octaves: Callable[[], None] = lambda: None
        self.stamp = 0

    @property
    def stale(self) -> bool:
        """Whether vertices were made before finer ground came."""
        return self.choice is not None and self.choice.stamp != self.stamp

    def surface(self, frame: Frame) -> GridSurface:
        # Finer ground comes with a snap that is prepared, where one can be: then it fades in.
        known = None if self.key is None else self.key.surface
        waits = self.stale and not frame.at_once and frame.view.snap.possible
        held = known.stamp if isinstance(known, GridSurface) and (waits or not self.stale) else self.stamp
        return GridSurface(self.ground.revision, float(frame.settings["terrain.min_spacing_m"]), held)

    def choose(self, frame: Frame, proxy: Proxy, scale: Scale) -> GridChoice:
        field = self.ground.field
        radius_m = frame.world.get(frame.planet, Planet).radius_m
        angle_rad = spacing_angle(*scale, proxy.cell.altitude_m, proxy.cell.radius_m)
        # Above the ground, even for a camera (or an anchor) under water.
        above_ground = max(proxy.cell.altitude_m - proxy.ground_m, 0.01)
        # Facets may not rise above an eye that is nearer to the ground than they are wide.
        smallest = min(float(frame.settings["terrain.min_spacing_m"]), max(above_ground, _FINEST_M))
        sea = frame.world.try_get(frame.planet, Ocean)
        lowest = field.lowest_m if sea is None else max(field.lowest_m, sea.sea_level_m)
        if proxy.cell.altitude_m < lowest:
            lowest = field.lowest_m  # under water the bed is what hides
        cells = select_rings(
            proxy.lattice,
            above_ground,
            proxy.ground_m,
            radius_m,
            angle_rad,
            self.mesh.quads,
            coverage_rad=proxy_coverage(
                proxy.cell.covered_altitude_m, proxy.cell.covered_sideways_rad, radius_m, field.highest_m, lowest
            ).half_angle_rad,
            min_spacing_m=smallest,
            max_cells=MOST_CELLS,
            height_at=field.height,
        )
        return GridChoice(
            cells=cells,
            proxy=proxy,
            eye_m=tuple(proxy.lattice.direction * (proxy.ground_m + above_ground - proxy.anchor_height_m)),
            edge_rad=_DECIMATED_SHARE * angle_rad,
            chord_m=chord_limit_m(scale.pixel_rad, proxy.cell.radius_m),
            spacing=GridSpacing(angle_rad, smallest, above_ground),
            stamp=self.stamp,
        )

    def bind(self, choice: GridChoice, first: int, snap: SnapAhead | None) -> None:
        if snap is None:
            self.bind_octaves()
        else:
            assert snap.bind_heights is not None, "terrain's own"
            snap.bind_heights()
        vertices, spacing = self._making.programs.vertices, choice.spacing
        vertices.set("u_spacing_per_distance", spacing.per_distance)
        vertices.set("u_smallest_spacing_m", spacing.smallest_m)
        vertices.set("u_proxy_height_m", spacing.proxy_height_m)

    def most_skipped(self, choice: GridChoice) -> int:
        return self._making.most

    def block(self, radius_m: float) -> TerrainGridBlock:
        """Of what is drawn."""
        assert self.choice is not None
        spacing, fade, old = self.choice.spacing, self.fade, self.faded
        if fade is None or old is None or not fade.running:
            return TerrainGridBlock(spacing, spacing, 0.0, (0.0, 0.0, 0.0))
        moved_m = self.choice.foot_m(radius_m) - old.foot_m(radius_m)
        return TerrainGridBlock(spacing, old.spacing, 1.0 - fade.part, moved_m)
