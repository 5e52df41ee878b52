"""TerrainView: what the ground keeps for each view."""

from __future__ import annotations

from typing import Any

from ...engine.blocks.bindings import MATERIAL_BLOCK
from ...engine.frame import ViewParts
from ...engine.gpu import GpuScope
from .material import TerrainMaterialBlock

__all__ = ["TerrainView"]


class TerrainView(ViewParts):
    """One view's table of the height function and block of materials, around the view's anchor."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.octaves: Any = None
        self.key: tuple[Any, ...] = ()  # what the table was made for
        self.next_octaves: Any = None  # around the anchor of a snap that is being prepared
        self.next_key: tuple[Any, ...] = ()
        self.wide = False  # whether pixels on coasts do with heights in float
        self.far = self.farther = False  # whether all of the ground's are, and so wide that all beside coasts are asked
        self.material = self.gpu.uniform_block(TerrainMaterialBlock, MATERIAL_BLOCK)
        self.material_key: tuple[int, ...] = ()  # what the block was made for
        self.updated = -1  # for which proxy
