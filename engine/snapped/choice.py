"""What a snapped mesh is made for, and which cells that gave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..frame import Proxy
from ..space.camera import CameraStamp
from ..surface.selection import CellSet

__all__ = ["CellChoice", "DrawnCells", "MeshKey", "PatchDetail", "PatchesShown", "Shown"]


class MeshKey(NamedTuple):
    """What cells are chosen for, beside their scale. proxy: its generation; surface: what else, such as revisions."""

    proxy: int
    surface: tuple[object, ...]


class DrawnCells(NamedTuple):
    """Which cells are drawn. mesh: its name."""

    mesh: str
    selection: int


class Shown(NamedTuple):
    """What the list of visible cells depends on. keep_dh_m: as for CellMesh.cull."""

    cells: DrawnCells
    camera: CameraStamp
    keep_dh_m: tuple[float, float]


class PatchDetail(NamedTuple):
    """How fine a printed grid is cut. edge_px: length of edges; corners: points a side; power: of the warp."""

    edge_px: float
    pixel_rad: float
    corners: int
    power: int


class PatchesShown(NamedTuple):
    """What the list of visible patches depends on."""

    selection: int
    camera: CameraStamp


@dataclass(kw_only=True)
class CellChoice:
    """A selection and what its vertices depend on. proxy: for which."""

    cells: CellSet
    proxy: Proxy
    eye_m: tuple[float, ...]
    """The proxy, from its anchor."""
    edge_rad: float
    """The wanted length of an edge, as an angle."""
    chord_m: float
    """As for CellMesh.make_part."""
