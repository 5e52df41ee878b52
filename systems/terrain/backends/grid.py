"""The projected grid as a backend: its cells (grid_mesh.py) drawn, with the fade after a snap."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ....engine.blocks.bindings import TERRAIN_GRID_BLOCK
from ....engine.frame import Frame, Proxy, View, ViewInfo, Views
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.graph import GraphBuilder, PassIO
from ....engine.settings import Settings
from .base import Backend, heights_seen
from .grid_mesh import GridMaking, GridMesh, TerrainGridBlock
from .grid_queries import heights_on_cells, triangles_of_cells

__all__ = ["GridBackend"]


class GridBackend(Backend):
    """Backend "grid"."""

    name: ClassVar[str] = "grid"
    contracts: ClassVar[Mapping[str, str]] = {
        **Backend.contracts,
        "vertex_spacing": "terrain/grid_vertex_spacing.glsl",
    }

    def __init__(self, gpu: GpuScope, settings: Settings, method: str, views: Views) -> None:
        super().__init__(gpu, settings, method, views)
        # Its text, for shaders; each view has a block of its own.
        gpu.uniform_block(TerrainGridBlock, TERRAIN_GRID_BLOCK, "terrain_grid")
        self._making = GridMaking(gpu, settings)
        self._programs: dict[tuple[str, bool], Any] = {}

    def view(self, index: int) -> GridMesh:
        """One view's cells."""
        return self.views[index].state(self, lambda: GridMesh(self.gpu, self._making))

    def _of(self, frame: Frame) -> GridMesh:
        view = self.view(frame.view_index)
        view.ground = self.ground
        return view

    def update(self, frame: Frame) -> None:
        view = self._of(frame)
        view.bind_octaves = partial(self.bind_octaves, frame.view_index)
        _, grew = view.follow(frame)
        self.structure += grew
        view.keep_dh_m = heights_seen(frame, frame.view.proxy.anchor_height_m)
        view.look(frame)
        view.ubo.write(view.block(self.ground.params.radius_m))
        view.ubo.bind()

    def rests(self, frame: Frame) -> bool:
        return self._of(frame).rests(frame)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self.view(view.index).declare(builder, "terrain")

    def draw_reads(self, view_index: int) -> tuple[str, ...]:
        return self.view(view_index).draw_reads()

    def bind_draw(self, io: PassIO, view_index: int, fragment: str) -> Callable[[], None]:
        view = self.view(view_index)
        mesh, fade = view.mesh, view.fade
        patches = mesh.vertex_array(self._program(fragment, False))
        if fade is None:
            return lambda: mesh.draw(patches)
        moving = self._program(fragment, True)
        overlaid = fade.mesh.vertex_array(moving)

        def draw() -> None:
            if fade.running:
                fade.bind_draw()
                moving.set("u_fade", fade.part)
                fade.mesh.draw(overlaid)
            else:
                mesh.draw(patches)

        return draw

    def _program(self, fragment: str, fades: bool) -> Any:
        key = (fragment, fades)
        if key not in self._programs:
            defines = {**self._making.programs.defines, **({"TERRAIN_FADE": 1} if fades else {})}
            self._programs[key] = self.gpu.program(vertex="terrain/gbuffer.vert", fragment=fragment, defines=defines)
        return self._programs[key]

    def settled(self, view: View) -> bool:
        grid = self.views.found(view.index, self, GridMesh)
        return grid is None or grid.fade is None or not grid.fade.running

    def statistics(self) -> dict[str, int]:
        grid = self.views.found(0, self, GridMesh)
        return {} if grid is None else grid.drawn.statistics()

    def drawn_mesh(self, view_index: int = 0) -> CellMesh | None:
        grid = self.views.found(view_index, self, GridMesh)
        return None if grid is None else grid.mesh

    def mesh_stamp(self, view_index: int) -> object:
        return self.view(view_index).mesh.selection

    def read_mesh(self, view_index: int) -> tuple[NDArray[np.float32], NDArray[np.int64]] | None:
        mesh = self.view(view_index).mesh
        vertices = mesh.read_vertices()["position_m"].reshape(-1, 3)
        return vertices, triangles_of_cells(mesh.read_cells(), mesh.quads)

    def height_drawn(self, directions: NDArray[np.float64], proxy: Proxy, view_index: int = 0) -> NDArray[np.float64]:
        mesh = self.drawn_mesh(view_index)
        if mesh is None or mesh.count == 0:
            return super().height_drawn(directions, proxy)
        return heights_on_cells(mesh, directions, proxy)
