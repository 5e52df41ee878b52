"""What a snapped mesh is made for, and which cells that gave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..frame import Proxy
from ..surface.selection import CellSet

__all__ = ["CellChoice", "MeshKey", "Shown"]


class MeshKey(NamedTuple):
    """What cells are chosen for, beside their scale. proxy: its generation; surface: what else, such as revisions."""

    proxy: int
    surface: tuple[object, ...]


class Shown(NamedTuple):
    """What the list of visible cells depends on. cells: which mesh is drawn, and its selection; camera: its stamp;
    keep_dh_m: as for CellMesh.cull."""

    cells: tuple[str, int]
    camera: tuple[object, ...]
    keep_dh_m: tuple[float, float]


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
