"""Meshes of cells that follow a view's proxy in snaps: ground and sea.

`SnappedMesh` is one; `MeshAhead` prepares its next snap, `SnapFade` leads from the last one to it. `PatchMesh` is
one as the sources print it.
"""

from .ahead import MeshAhead
from .choice import CellChoice, MeshKey, PatchDetail, PatchesShown, Shown
from .fade import FadePrograms, SnapFade
from .mesh import SnappedMesh
from .patches import PatchMesh, PatchPrograms

__all__ = [
    "CellChoice",
    "FadePrograms",
    "MeshAhead",
    "MeshKey",
    "PatchDetail",
    "PatchMesh",
    "PatchPrograms",
    "PatchesShown",
    "Shown",
    "SnapFade",
    "SnappedMesh",
]
