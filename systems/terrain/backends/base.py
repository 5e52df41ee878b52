"""Backend: what selects cells and makes their vertices. Everything after that is the terrain system's and shared."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....components import Ocean, Planet
from ....engine.frame import Frame, View, Views
from ....engine.frame.published import SEA_TOP_M
from ....engine.gpu import GpuScope, Program
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.gpu.preprocess import Defines
from ....engine.graph import PassIO
from ....engine.methods import Method
from ....engine.settings import Settings
from ....engine.surface.field import HeightField
from ..height import TerrainField, TerrainParams

__all__ = ["Backend", "Ground", "GroundRevision", "heights_seen"]

_DEEP_M = 2.0  # a cell this far below the sea is hidden by it, whatever the curvature of both meshes


class GroundRevision(NamedTuple):
    """Differs whenever any height may differ. terrain: the component's id; shape: revision of what heights follow
    from; radius: revision of the planet's; rivers: how many tables of them this ground has had; wetter: their banks
    (Cover.riparian), which vertices know of."""

    terrain: int
    shape: int
    radius: int
    rivers: int | None = None
    wetter: float = 0.0


@dataclass(frozen=True, eq=False)
class Ground:
    """The ground that a backend draws."""

    params: TerrainParams
    field: TerrainField
    revision: GroundRevision
    complete_table: Callable[[NDArray[Any]], None] = lambda table: None
    """Writes into a table of octaves what doesn't follow from params."""


class Backend(Method):
    """One way to cut the ground into triangles, for any number of views of one planet.

    A backend declares the passes that end in the graph's buffers ``terrain.visible`` and ``terrain.arguments`` (and
    whatever it makes before), and draws them into a G-buffer that is bound. Its vertices are camera-independent, and
    their attributes are those of terrain/attributes.glsl with the code of their spacing (common/spacing_code.glsl).

    gpu: a scope of its own. settings: resolved quality values.
    """

    name: ClassVar[str]
    contracts: ClassVar[Mapping[str, str]] = {"surface_height": "terrain/surface_height.glsl"}
    shade_file: ClassVar[str] = "terrain/shade.comp"
    """Materials and light of its pixels."""
    labels_file: ClassVar[str] = "terrain/labels.comp"
    """Their materials without light."""
    shades_all: ClassVar[bool] = True
    """Whether that file knows water, things that stand on the ground, and pixels that are shaded every few."""
    coast_file: ClassVar[str] = ""
    """The line between land and water, pixel by pixel; "": from the terrain's own height function."""
    faces_out: ClassVar[bool] = True
    """Whether triangles seen from behind are hidden ones."""
    own_ground: ClassVar[bool] = False
    """Whether it draws a ground of its source's in place of the scene's."""
    ground: Ground
    """What it draws; the system says so before each `update`."""
    ground_stamp: Callable[[View], int]
    """Differs when vertices that a view has would show finer ground now; the system says so."""
    bind_octaves: Callable[[View], None]
    """Binds the height function's table around a view's anchor, to be called in passes."""

    def __init__(self, gpu: GpuScope, settings: Settings, views: Views) -> None:
        super().__init__(gpu)
        self.views = views
        self.settings = settings
        self._draw_programs: dict[str, Program] = {}
        self.ground_stamp = _never

    def draw_program(self, fragment: str, vertex: str, defines: Defines | None = None) -> Program:
        """The program of `vertex`, of which a backend has one, and a fragment shader, compiled once."""
        found = self._draw_programs.get(fragment)
        if found is None:
            found = self._draw_programs[fragment] = self.gpu.program(vertex=vertex, fragment=fragment, defines=defines)
        return found

    def drawn_field(self, ground: Ground) -> HeightField:
        """The ground that it draws, in float64: the scene's own, but for a method whose source has another."""
        return ground.field

    def bind_heights(self, view: View) -> bool:
        """Binds what its own contract ``surface_height`` reads; False if that is the system's table."""
        return False

    def bind_shading(self) -> None:
        """Binds what its shade_file reads beyond the G-buffer and the table of heights."""

    @abstractmethod
    def draw_reads(self, view: View) -> tuple[str, ...]:
        """Resources of the graph that the draw reads."""

    @abstractmethod
    def bind_draw(self, io: PassIO, view: View, fragment: str) -> Callable[[], None]:
        """Everything of the view, drawn with a fragment shader (inputs as terrain/gbuffer.frag)."""

    def rests(self, frame: Frame) -> bool:
        """Whether `update` may be left out of a frame that shows no ground."""
        return not frame.view.seen.planet() and self.settled(frame.view)

    def height_drawn(self, directions: NDArray[np.float64], view: View) -> NDArray[np.float64]:
        """Heights (N,) of the triangles drawn below unit directions (N, 3); NaN where there are none. Reads back."""
        return np.full(len(directions), np.nan)

    def drawn_mesh(self, view: View) -> CellMesh | None:
        """The CellMesh of the view, if this backend has one."""
        return None

    def mesh_stamp(self, view: View) -> object:
        """Differs whenever read_mesh() may."""
        return None

    def read_mesh(self, view: View) -> tuple[NDArray[np.float32], NDArray[np.int64]] | None:
        """Vertices (V, 3) from the view's anchor and triangles (N, 3) of all that is selected, seen or not; None if the
        backend doesn't tell. Reads back from the GPU."""
        return None


def _never(view: View) -> int:
    return 0


def heights_seen(frame: Frame, anchor_height_m: float) -> tuple[float, float]:
    """Heights from the anchor that can be seen: from above, the sea hides all of its bed and colours it itself."""
    sea = frame.world.try_get(frame.planet, Ocean)
    radius = frame.world.get(frame.planet, Planet).radius_m
    if sea is None:
        return (-3.0e38, 3.0e38)
    top_m = frame.world.try_resource(SEA_TOP_M)
    if frame.camera.altitude_m(radius) < (sea.sea_level_m if top_m is None else top_m):
        return (-3.0e38, 3.0e38)
    return (sea.sea_level_m - anchor_height_m - _DEEP_M, 3.0e38)
