"""The icosphere as Lindner prints it (PlanetRenderer): backend "icosphere", method "paper".

One indexed patch with morph vectors, instanced over the leaves of a recursion that splits by tables of distances, drops
back faces and what lies outside the frustum, and stops testing below what is contained. All of it runs for each camera
anew. The recursion, the tables and the morph are the source's; places and heights are computed our way, from integers
and relative to an anchor, so nothing jitters and each level's vertices lie among those of the next. What the source
loses is left: along the edges of the icosahedron's triangles the two sides twist apart while they morph, and culling
drops some triangles that can be seen. docs/terrain-lod.md says what is printed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from ....engine.blocks.bindings import PATCH_BUFFER, TRIANGLE_BLOCK, VERTEX_BUFFER
from ....engine.frame import Frame, View, ViewInfo, ViewParts, Views
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import VERTEX_DTYPE
from ....engine.gpu.cells import COMMAND_DTYPE
from ....engine.graph import BufferSpec, GraphBuilder, PassIO
from ....engine.settings import Settings
from ....engine.space.camera import CameraStamp
from ....engine.surface.icosphere_anchor import AnchorKey, TriangleAnchor
from ....engine.surface.triangle_paper import PaperTables, frustum_planes, select, tables
from ..tiles.queries import heights_on_tiles
from ..tiles.shape import TileShape
from ..tiles.slots import NAME_DTYPE
from ..tiles.triangle import TriangleShape
from .base import Backend, GroundRevision

__all__ = ["PaperIcosphereBackend"]

Ints = NDArray[np.int64]
LEVELS = 25
_ROWS = 32  # of the tables in the shader


class _TableKey(NamedTuple):
    """What the tables of distances are made for."""

    ground: GroundRevision
    tangents: tuple[float, float, float, float]
    size_px: tuple[int, int]
    edge_px: float


class _LeavesKey(NamedTuple):
    """What the leaves are chosen for."""

    table: _TableKey
    camera: CameraStamp
    anchor: AnchorKey
    min_spacing_m: float


class _View(ViewParts):
    """One view's leaves."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.arrays: dict[str, Any] = {}
        self.key: _LeavesKey | None = None
        self.table_key: _TableKey | None = None
        self.table: PaperTables | None = None
        self.keys: Ints = np.zeros(0, np.int64)
        self.capacity = 1024
        self.made: _LeavesKey | None = None
        self.patches = self.gpu.buffer(reserve=self.capacity * NAME_DTYPE.itemsize, dynamic=True)
        self.anchor = self.gpu.buffer(reserve=len(TriangleAnchor((1, 0, 0), 1.0).block), dynamic=True)
        self.anchor_key: AnchorKey | None = None
        self.ground_m = 0.0  # height of the sphere that distances are measured to
        self.vertices: Any = None
        self.visible: Any = None
        self.arguments: Any = None
        self.bind_octaves: Callable[[], None] = lambda: None


class _Drawn:
    """What the query of drawn heights wants of a mesh."""

    def __init__(self, view: _View, shape: TriangleShape) -> None:
        self.keys, self._view = view.keys, view
        self.shape: TileShape = shape

    def read_vertices(self) -> NDArray[np.void]:
        size = len(self.keys) * self.shape.vertices * VERTEX_DTYPE.itemsize
        return np.frombuffer(self._view.vertices.read(size), VERTEX_DTYPE).reshape(len(self.keys), -1)


class PaperIcosphereBackend(Backend):
    """Backend "icosphere", method "paper"."""

    name: ClassVar[str] = "icosphere"

    def __init__(self, gpu: GpuScope, settings: Settings, views: Views) -> None:
        super().__init__(gpu, settings, views)
        self.shape = TriangleShape(int(settings["terrain.tile_quads"]))
        self._vertices = gpu.compute("terrain/paper/icosphere.comp", defines=self.shape.defines)
        self._indices = gpu.buffer(self.shape.indices.astype("<u4"))
        self._spacing_m = np.zeros(_ROWS)

    def view(self, view: View) -> _View:
        """One view's leaves."""
        return view.state(self, lambda: _View(self.gpu))

    def base_m(self) -> float:
        """Radius of the sphere that the printed recursion is of: all heights of the source are above it."""
        return self.ground.params.radius_m + self.ground.params.lowest_m

    def rests(self, frame: Frame) -> bool:
        return True  # what is chosen depends on the camera of the frame alone

    def update(self, frame: Frame) -> None:
        view, camera, ground = self.view(frame.view), frame.camera, self.ground
        params = ground.params
        view.bind_octaves = partial(self.bind_octaves, frame.view)
        proxy = frame.view.proxy
        anchor_key = AnchorKey(proxy.generation, params.radius_m)
        if anchor_key != view.anchor_key:
            view.anchor_key = anchor_key
            view.anchor.write(TriangleAnchor(proxy.lattice.direction, params.radius_m).block)
        made = view.made
        if frame.frozen and made is not None and (made.table.ground, made.anchor) == (ground.revision, anchor_key):
            return
        tangents = (camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        table_key = _TableKey(ground.revision, tangents, frame.size, float(frame.settings["terrain.edge_px"]))
        smallest_m = float(frame.settings["terrain.min_spacing_m"])
        if table_key != view.table_key or view.table is None:
            view.table_key = table_key
            self._spacing_m = params.radius_m * self.shape.scheme.spacing_rad(np.arange(_ROWS), self.shape.segments)
            fov_rad = np.arctan(camera.tan_right) - np.arctan(camera.tan_left)
            edge_px, segments = table_key.edge_px, self.shape.segments
            relief_m = params.highest_m - params.lowest_m
            view.table = tables(self.base_m(), relief_m, fov_rad, frame.size[0], edge_px, segments, LEVELS)
        # As printed the sphere of height 0: a mountain below one's feet would be as coarse as from so high above.
        view.ground_m = float(proxy.ground_m)
        key = _LeavesKey(table_key, camera.stamp, anchor_key, smallest_m)
        if key == view.key:
            return
        view.key = key
        finest = int(np.clip(np.searchsorted(-self._spacing_m, -smallest_m), 0, LEVELS))
        planes = frustum_planes(camera.forward, camera.up, tangents)
        above_m = view.ground_m - params.lowest_m
        found = select(self.shape.scheme, view.table, self.base_m(), camera.position_m, planes, finest, above_m)
        view.keys = found.keys
        if len(found.keys) > view.capacity:
            view.capacity = 2 * len(found.keys)
            view.gpu.free(view.patches)
            view.patches = view.gpu.buffer(reserve=view.capacity * NAME_DTYPE.itemsize, dynamic=True)
            frame.view.structure += 1
        if len(found.keys):
            view.patches.write(self.shape.names(found.keys).tobytes())

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        own = self.view(view.view)
        size = own.capacity * self.shape.vertices * VERTEX_DTYPE.itemsize
        builder.add_pass(
            "terrain.vertices",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_vertices(io, own),
            creates=(
                BufferSpec("terrain.vertices", size, "persistent", "of all patches"),
                BufferSpec("terrain.visible", 4 * own.capacity, "persistent", "the patches, one after another"),
                BufferSpec("terrain.arguments", COMMAND_DTYPE.itemsize, "persistent", "the indirect draw"),
            ),
            when=lambda: own.made != own.key,
            help="places, morphs and heights of all patches that the CPU left, for this camera",
        )

    def _bind_vertices(self, io: PassIO, view: _View) -> Callable[[], None]:
        view.vertices, view.visible, view.arguments = (
            io.buffer(f"terrain.{name}") for name in ("vertices", "visible", "arguments")
        )
        view.made = None

        def run() -> None:
            count = len(view.keys)
            view.visible.write(np.arange(count, dtype="<u4").tobytes())
            view.arguments.write(np.array([self.shape.indices.size, count, 0, 0, 0], "<u4").tobytes())
            if count:
                assert view.table is not None
                view.bind_octaves()
                view.anchor.bind_to_uniform_block(TRIANGLE_BLOCK)
                view.patches.bind_to_storage_buffer(PATCH_BUFFER)
                view.vertices.bind_to_storage_buffer(VERTEX_BUFFER)
                self._vertices.set("u_morph", np.pad(view.table.morph_m, ((0, _ROWS - LEVELS - 1), (0, 0))))
                self._vertices.set("u_spacing", self._spacing_m)
                self._vertices.set("u_ground", view.ground_m)
                self._vertices.run(count, 1, 1)
            view.made = view.key

        return run

    def draw_reads(self, view: View) -> tuple[str, ...]:
        return ("terrain.vertices", "terrain.visible", "terrain.arguments")

    def bind_draw(self, io: PassIO, view: View, fragment: str) -> Callable[[], None]:
        program = self.draw_program(fragment, "terrain/tiles/gbuffer.vert", self.shape.defines)
        own = self.view(view)
        old = own.arrays.pop(fragment, None)
        if old is not None:
            own.gpu.free(old)
        made = own.arrays[fragment] = own.gpu.vertex_array(
            program, content=[(own.visible, "1u/i", "in_slot")], index=self._indices, index_size=4
        )

        def draw() -> None:
            own.vertices.bind_to_storage_buffer(VERTEX_BUFFER)
            made.render_indirect(own.arguments, moderngl.TRIANGLES, 1)

        return draw

    def statistics(self) -> dict[str, int]:
        view: _View | None = self.views[0].found(self)
        count = 0 if view is None else len(view.keys)
        return {
            "cells_selected": count,
            "cells": count,
            "vertices": count * self.shape.vertices,
            "triangles": count * self.shape.indices.size // 3,
        }

    def height_drawn(self, directions: NDArray[np.float64], view: View) -> NDArray[np.float64]:
        own: _View | None = view.found(self)
        if own is None or own.vertices is None or not len(own.keys):
            return super().height_drawn(directions, view)
        return heights_on_tiles(_Drawn(own, self.shape), directions, view.proxy)
