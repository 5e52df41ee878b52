"""The projected grid as a backend: its cells (grid_mesh.py) drawn, with the fade after a snap."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ....engine.blocks.bindings import TERRAIN_GRID_BLOCK
from ....engine.frame import Frame, View, ViewInfo, Views
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

    def __init__(self, gpu: GpuScope, settings: Settings, views: Views) -> None:
        super().__init__(gpu, settings, views)
        # Its text, for shaders; each view has a block of its own.
        gpu.uniform_block(TerrainGridBlock, TERRAIN_GRID_BLOCK, "terrain_grid")
        self._making = GridMaking(gpu, settings)
        self._programs: dict[tuple[str, bool], Any] = {}

    def view(self, view: View) -> GridMesh:
        """One view's cells."""
        return view.state(self, lambda: GridMesh(self.gpu, self._making))

    def _of(self, frame: Frame) -> GridMesh:
        view = self.view(frame.view)
        view.ground = self.ground
        return view

    def update(self, frame: Frame) -> None:
        view = self._of(frame)
        view.bind_octaves = partial(self.bind_octaves, frame.view)
        view.stamp = self.ground_stamp(frame.view)
        _, grew = view.follow(frame)
        frame.view.structure += grew
        if view.stale:
            frame.view.snap.asked = True
        view.keep_dh_m = heights_seen(frame, frame.view.proxy.anchor_height_m)
        view.look(frame)
        view.ubo.write(view.block(self.ground.params.radius_m))
        view.ubo.bind()

    def rests(self, frame: Frame) -> bool:
        view = self._of(frame)
        view.stamp = self.ground_stamp(frame.view)
        return not view.stale and view.rests(frame)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self.view(view.view).declare(builder, "terrain")

    def draw_reads(self, view: View) -> tuple[str, ...]:
        return self.view(view).draw_reads()

    def bind_draw(self, io: PassIO, view: View, fragment: str) -> Callable[[], None]:
        own = self.view(view)
        mesh, fade = own.mesh, own.fade
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
        grid: GridMesh | None = view.found(self)
        return grid is None or not (grid.stale or (grid.fade is not None and grid.fade.running))

    def statistics(self) -> dict[str, int]:
        grid: GridMesh | None = self.views[0].found(self)
        return {} if grid is None else grid.drawn.statistics()

    def drawn_mesh(self, view: View) -> CellMesh | None:
        grid: GridMesh | None = view.found(self)
        return None if grid is None else grid.mesh

    def mesh_stamp(self, view: View) -> object:
        return self.view(view).mesh.selection

    def read_mesh(self, view: View) -> tuple[NDArray[np.float32], NDArray[np.int64]] | None:
        mesh = self.view(view).mesh
        vertices = mesh.read_vertices()["position_m"].reshape(-1, 3)
        return vertices, triangles_of_cells(mesh.read_cells(), mesh.quads)

    def height_drawn(self, directions: NDArray[np.float64], view: View) -> NDArray[np.float64]:
        mesh = self.drawn_mesh(view)
        if mesh is None or mesh.count == 0:
            return super().height_drawn(directions, view)
        return heights_on_cells(mesh, directions, view.proxy)
