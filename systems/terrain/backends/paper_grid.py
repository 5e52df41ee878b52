"""The projected grid as Michelic (2018) and Michelic et al. (2019) print it: backend "grid", method "paper".

One warped grid of 50^2, 100^2 or 200^2 points around a held proxy, cut by the size of its squares on screen; patches
whose corners are outside a slightly widened frustum are dropped. The grid, the tessellation and the heights are the
paper's; the way that they are computed is ours: offsets from an anchor, vertices made once per snap, an indirect draw
of what is seen. Tessellation is done in compute shaders, with the pattern that GL's own would give for powers of two:
so it happens once per snap and not once per frame, and runs on all cores where there is no GPU. docs/terrain-lod.md
says what is printed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....components import Ocean, Planet
from ....engine.blocks.bindings import (
    CONTINENTS_UNIT,
    GROUND_TILE_UNIT,
    TERRAIN_GRID_BLOCK,
    TERRAIN_TABLE_BLOCK,
    VERTEX_BUFFER,
)
from ....engine.blocks.layout import Vec3
from ....engine.frame import Frame, Proxy, View, ViewInfo, Views
from ....engine.gpu import GpuScope
from ....engine.graph import GraphBuilder, PassIO
from ....engine.settings import Settings
from ....engine.snapped import MeshKey, PatchDetail, PatchMesh, PatchPrograms
from ....engine.surface.coverage import coverage
from ....engine.surface.grid_place import placed
from ....engine.surface.projected_grid import FINEST, GridBlock, ProjectedGrid
from ....engine.surface.selection import spacing_angle
from ..paper_ground import TABLE_DTYPE, TEXELS, PaperField
from .base import Backend, Ground, GroundRevision
from .grid_queries import heights_on_patches

__all__ = ["PaperGridBackend"]

VERTEX_BYTES = 24
TILE_M = 512.0
"""Width of a tile of the normal map; smaller planets have smaller ones."""
_TILE_TEXELS = 512
_TILE_SLOPE = 0.18  # rms, of the bumps in the normal map
_MOST_VERTICES = 1 << 21  # a telephoto lens near the ground would ask for a hundred times as many


@dataclass
class PaperGridBlock(GridBlock):
    """GLSL: ``generated/paper_grid.glsl``, ``paper_grid``."""

    tile_place: Annotated[Vec3, "of the anchor, in tiles of the normal map"]
    tiles_per_m: float


class FieldKey(NamedTuple):
    """What the printed ground is made for. layers: of noise."""

    ground: GroundRevision
    layers: int


class _Surface(NamedTuple):
    """What the grid's vertices depend on beside proxy and detail. moves: of the grid."""

    field: FieldKey
    moves: int


class _View(PatchMesh):
    """One view's grid."""

    def __init__(self, of: GpuScope, programs: PatchPrograms) -> None:
        super().__init__(of, "terrain", programs, VERTEX_BYTES, 32)
        self.ubo = self.gpu.uniform_block(PaperGridBlock, TERRAIN_GRID_BLOCK)
        self.arrays: dict[str, Any] = {}
        self.grid: ProjectedGrid | None = None
        self.moves = 0
        """How often the grid has moved."""
        self.table: Any = None
        self.table_key: MeshKey | None = None
        self.field_key: FieldKey
        self.angle_rad = 0.01

    def surface(self, frame: Frame) -> _Surface:
        return _Surface(self.field_key, self.moves)

    def detail(self, frame: Frame) -> PatchDetail:
        edge_px, corners, power = (frame.settings[f"terrain.{n}"] for n in ("edge_px", "paper_grid", "paper_warp"))
        return PatchDetail(float(edge_px), frame.pixel_rad, int(corners), int(power))


class PaperGridBackend(Backend):
    """Backend "grid", method "paper"."""

    name: ClassVar[str] = "grid"
    contracts: ClassVar[Mapping[str, str]] = {"surface_height": "terrain/paper/surface_height.glsl"}
    shade_file: ClassVar[str] = "terrain/paper/shade.comp"
    labels_file: ClassVar[str] = "terrain/paper/labels.comp"
    shades_all: ClassVar[bool] = False
    coast_file: ClassVar[str] = "terrain/paper/coast.comp"
    faces_out: ClassVar[bool] = False
    own_ground: ClassVar[bool] = True

    def __init__(self, gpu: GpuScope, settings: Settings, views: Views) -> None:
        super().__init__(gpu, settings, views)
        self._field: PaperField | None = None
        self._field_key: FieldKey
        # Its text, for shaders; each view has a block of its own.
        gpu.uniform_block(PaperGridBlock, TERRAIN_GRID_BLOCK, "paper_grid")
        self._continents = gpu.texture((TEXELS, TEXELS), "rg32f", levels=TEXELS.bit_length())
        levels = _TILE_TEXELS.bit_length()
        self._normal_map = gpu.texture(
            (_TILE_TEXELS, _TILE_TEXELS), "rg16f", _bumps(), levels=levels, filter="trilinear", wrap="repeat"
        )
        self._normal_map.build_mipmaps()
        self._patches = PatchPrograms(
            gpu,
            "terrain/paper/vertices.comp",
            "terrain/paper/cull.comp",
            "terrain/paper/arguments.comp",
            "terrain/paper/triangles.comp",
        )

    def view(self, view: View) -> _View:
        """One view's grid."""
        return view.state(self, lambda: _View(self.gpu, self._patches))

    def drawn_field(self, ground: Ground) -> PaperField:
        layers = int(self.settings["terrain.paper_layers"])
        key = FieldKey(ground.revision, layers)
        if self._field is None or key != self._field_key:
            self._field, self._field_key = PaperField(ground.params, layers), key
            self._continents.write(self._field.continents.tobytes())
            self._continents.build_mipmaps()
        return self._field

    def _of(self, frame: Frame) -> tuple[_View, PaperField]:
        field, view = self.drawn_field(self.ground), self.view(frame.view)
        view.field_key = self._field_key
        self._place(view, frame, field)
        return view, field

    def _place(self, view: _View, frame: Frame, field: PaperField) -> None:
        """The grid that the view's camera has: it moves by its own cells as the camera does."""
        if frame.frozen and view.grid is not None:
            return
        proxy, detail = frame.view.proxy, view.detail(frame)
        radius_m = frame.world.get(frame.planet, Planet).radius_m
        sea = frame.world.try_get(frame.planet, Ocean)
        lowest = field.lowest_m if sea is None else max(field.lowest_m, sea.sea_level_m)
        if proxy.cell.altitude_m < lowest:
            lowest = field.lowest_m
        away_m = float(np.linalg.norm(frame.camera.position_m))
        seen = coverage(away_m - radius_m, radius_m, field.highest_m, lowest)
        held = None if frame.cut else view.grid
        camera = frame.camera.position_m / away_m
        grid = placed(held, proxy.lattice.direction, camera, seen, detail.corners, detail.power, radius_m)
        if grid is not view.grid:
            view.grid = grid
            view.moves += 1

    def rests(self, frame: Frame) -> bool:
        return super().rests(frame) or self._of(frame)[0].rests(frame)

    def update(self, frame: Frame) -> None:
        view, field = self._of(frame)
        proxy = frame.view.proxy
        if view.follow(frame):
            self._project(view, frame, proxy)
        if view.key != view.table_key:
            view.table_key = view.key
            if view.table is None:
                view.table = view.gpu.buffer(reserve=TABLE_DTYPE.itemsize, dynamic=True)
            view.table.write(field.table(proxy.lattice.direction, proxy.anchor_height_m).tobytes())
        view.ubo.bind()
        view.look(frame)

    def _project(self, view: _View, frame: Frame, proxy: Proxy) -> None:
        grid, detail = view.grid, view.detail(frame)
        assert grid is not None
        above_ground = max(proxy.cell.altitude_m - proxy.ground_m, 0.01)
        angle = spacing_angle(detail.edge_px, detail.pixel_rad, proxy.cell.altitude_m, grid.radius_m)
        cut = grid.tessellate(above_ground, proxy.ground_m, angle, _MOST_VERTICES, proxy.lattice.direction)
        view.angle_rad = angle * cut.coarser
        self._write_block(view, proxy)
        frame.view.structure += view.take(cut)

    def _write_block(self, view: _View, proxy: Proxy) -> None:
        grid = view.grid
        assert grid is not None
        half = grid.steps() // 2
        middle = np.array([half, half + FINEST, half])
        feet = grid.foot_offsets_m(middle, np.array([half, half, half + FINEST]))
        width_m = float(np.linalg.norm(feet[1] - feet[0]))
        tile_m = TILE_M * min(1.0, grid.radius_m / 6.371e6 * 4.0)
        place = proxy.lattice.direction * (grid.radius_m / tile_m)
        tile = place - np.floor(place)
        above = max(proxy.cell.altitude_m - proxy.ground_m, 0.01)
        view.ubo.write(
            PaperGridBlock(
                first_axis=tuple(grid.axes[0].tolist()),
                z_s=grid.z_s,
                second_axis=tuple(grid.axes[1].tolist()),
                third_axis=tuple(grid.axes[2].tolist()),
                middle_m=tuple(grid.middle_m(proxy.lattice.direction).tolist()),
                per_half=1.0 / half,
                spacing_rad=view.angle_rad,
                smallest_spacing_m=width_m / FINEST,
                proxy_height_m=above,
                half_steps=half,
                power=grid.power,
                tile_place=tuple(tile.tolist()),
                tiles_per_m=1.0 / tile_m,
            )
        )

    def bind_heights(self, view: View) -> bool:
        self.view(view).table.bind_to_uniform_block(TERRAIN_TABLE_BLOCK)
        self._continents.use(CONTINENTS_UNIT)
        return True

    def bind_shading(self) -> None:
        self._normal_map.use(GROUND_TILE_UNIT)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self.view(view.view).declare(builder, "terrain", lambda: self.bind_heights(view.view))

    def draw_reads(self, view: View) -> tuple[str, ...]:
        return ("terrain.vertices", "terrain.arguments", "terrain.triangles")

    def bind_draw(self, io: PassIO, view: View, fragment: str) -> Callable[[], None]:
        program = self.draw_program(fragment, "terrain/paper/gbuffer.vert")
        own = self.view(view)
        old = own.arrays.pop(fragment, None)
        if old is not None:
            own.gpu.free(old)
        made = own.arrays[fragment] = own.gpu.vertex_array(program, index=own.buffers["triangles"], index_size=4)

        def draw() -> None:
            own.buffers["vertices"].bind_to_storage_buffer(VERTEX_BUFFER)
            made.render_indirect(own.buffers["arguments"], count=1)

        return draw

    def mesh_stamp(self, view: View) -> object:
        return self.view(view).selection

    def read_mesh(self, view: View) -> tuple[NDArray[np.float32], NDArray[np.int64]] | None:
        own = self.view(view)
        if own.cut is None or "vertices" not in own.buffers:
            return None
        data = np.frombuffer(own.buffers["vertices"].read(own.cut.vertices * VERTEX_BYTES), "<f4").reshape(-1, 6)
        return data[:, :3], own.cut.faces()

    def height_drawn(self, directions: NDArray[np.float64], view: View) -> NDArray[np.float64]:
        own, mesh = self.view(view), self.read_mesh(view)
        if mesh is None or own.grid is None or own.cut is None:
            return super().height_drawn(directions, view)
        return heights_on_patches(own.grid, own.cut, mesh[0].astype(np.float64) + view.proxy.anchor_m, directions)

    def statistics(self) -> dict[str, int]:
        view: _View | None = self.views[0].found(self)
        if view is None or view.cut is None or "counts" not in view.buffers:
            return {}
        seen = np.frombuffer(view.buffers["counts"].read(28), "u4").astype(int)
        size = 1 << np.arange(7)
        return {
            "cells_selected": len(view.cut),
            "cells": int(seen.sum()),
            "vertices": int(seen @ (size + 1) ** 2),
            "triangles": int(seen @ (2 * size**2)),
        }


def _bumps() -> NDArray[np.float16]:
    """Slopes (N, N, 2) of a tile that repeats: bumps from two texels to a quarter of the tile, equally steep each."""
    rng = np.random.default_rng(2018)
    waves = np.fft.fftfreq(_TILE_TEXELS, 1.0 / _TILE_TEXELS)
    kx, ky = np.meshgrid(waves, waves)
    size = np.hypot(kx, ky)
    band = (size >= 4.0) & (size <= _TILE_TEXELS / 3.0)
    # Energy of slopes even in octaves: heights fall with the square of the wave number in two dimensions.
    height = np.where(band, rng.normal(size=size.shape) + 1j * rng.normal(size=size.shape), 0.0)
    height = height / np.maximum(size, 1.0) ** 2
    slopes = np.stack([np.fft.ifft2(1j * k * height).real for k in (kx, ky)], axis=-1)
    return (slopes * (_TILE_SLOPE / slopes.std())).astype(np.float16)
