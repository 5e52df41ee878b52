"""The projected grid as a backend: its cells (grid_mesh.py) drawn, with the fade after a snap."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ....engine.frame import Frame, Proxy, ViewInfo, Views
from ....engine.gpu import GpuScope
from ....engine.gpu.bindings import TERRAIN_GRID_BLOCK
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.graph import GraphBuilder, PassIO
from .base import Backend, Ground, heights_seen
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

    def __init__(self, gpu: GpuScope, settings: Mapping[str, Any], method: str, views: Views) -> None:
        super().__init__(gpu, settings, method, views)
        self._ubo = gpu.uniform_block(TerrainGridBlock, TERRAIN_GRID_BLOCK, "terrain_grid")
        self._making = GridMaking(gpu, settings)
        self._programs: dict[tuple[str, bool], Any] = {}

    def view(self, index: int) -> GridMesh:
        """One view's cells."""
        return self.views[index].state(self, lambda: GridMesh(self.gpu, self._making))

    def update(self, frame: Frame) -> None:
        view = self.view(frame.view_index)
        view.ground = ground = self.ground
        view.bind_octaves = partial(self.bind_octaves, frame.view_index)
        _, grew = view.follow(frame, _surface(frame, ground))
        self.structure += grew
        view.keep_dh_m = heights_seen(frame, frame.view.proxy.anchor_height_m)
        view.look(frame)
        self._ubo.write(TerrainGridBlock(*view.block_values(ground.params.radius_m)))
        self._ubo.bind()

    def rests(self, frame: Frame) -> bool:
        return self.view(frame.view_index).rests(frame, _surface(frame, self.ground))

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

    def settled(self) -> bool:
        return not any(view.fade is not None and view.fade.running for view in self.views.states(self, GridMesh))

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


def _surface(frame: Frame, ground: Ground) -> tuple[object, ...]:
    """What the cells depend on beside proxy and scale."""
    return (ground.revision, float(frame.settings["terrain.min_spacing_m"]))
