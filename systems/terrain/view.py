"""TerrainView: what the ground keeps for each view."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...engine.blocks.bindings import MATERIAL_BLOCK
from ...engine.frame import ViewParts
from ...engine.gpu import GpuScope
from .backends.base import GroundRevision
from .material import TerrainMaterialBlock

__all__ = ["MaterialKey", "OctavesKey", "TerrainView"]


class OctavesKey(NamedTuple):
    """What a table of the height function is made for. proxy: its generation."""

    proxy: int
    ground: GroundRevision
    color_map_strength: float


class MaterialKey(NamedTuple):
    """What a block of materials is made for: revisions, and the proxy's generation. listed: the materials'."""

    ground: GroundRevision
    component: int
    listed: int
    proxy: int


class TerrainView(ViewParts):
    """One view's table of the height function and block of materials, around the view's anchor."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.octaves: Any = None
        self.key: OctavesKey | None = None  # what the table was made for
        self.next_octaves: Any = None  # around the anchor of a snap that is being prepared
        self.next_key: OctavesKey | None = None
        self.wide = False  # whether pixels on coasts do with heights in float
        self.far = self.farther = False  # whether all of the ground's are, and so wide that all beside coasts are asked
        self.material = self.gpu.uniform_block(TerrainMaterialBlock, MATERIAL_BLOCK)
        self.material_key: MaterialKey | None = None  # what the block was made for
        self.updated = -1  # for which proxy
