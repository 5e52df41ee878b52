"""Programs that draw and light plants, and the colours that they are given."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...engine.display import reflectance
from ...engine.gpu import GpuScope
from ...engine.warm_up import WarmUp
from ...engine.wavelengths import Nanometres
from .own_colours import own_defines, packed
from .season import AUTUMN

__all__ = ["PlantPrograms"]

Floats = NDArray[np.float64]
_DETAILS = (("TREE_LEAVES", "TREE_LIMBS"), ("TREE_LIMBS",), ())
"""The nearest show leaves and limbs, farther ones limbs."""


class PlantPrograms:
    """trees: by detail, the nearest first, then that of columns and rosettes, which planets with species of their own
    alone have; and `quads` for each."""

    def __init__(self, gpu: GpuScope, cover: Cover, shade_defines: dict[str, Any], nm: Nanometres) -> None:
        own, self._nm = own_defines(cover.species), nm
        self.has_own = bool(own)
        self.trees = [
            gpu.program(
                vertex="cover/gbuffer.vert", fragment="cover/gbuffer.frag", defines={**dict.fromkeys(shown, 1), **own}
            )
            for shown in (*_DETAILS, *([("COVER_FORMS",)] if own else []))
        ]
        self.quads = [gpu.vertex_array(program) for program in self.trees]
        self.shade = gpu.compute("cover/shade.comp", defines={**shade_defines, **own})
        self.autumn = reflectance(AUTUMN, nm)
        self.albedos: Floats = np.zeros((3, 3))
        """of broadleaves, conifers and bark"""
        self.warm_up = WarmUp((lambda program=program: program) for program in (*self.trees, self.shade))

    def use_colours(self, cover: Cover) -> None:
        """Those of the component."""
        self.albedos = reflectance(
            np.array([cover.broadleaf_albedo, cover.conifer_albedo, cover.bark_albedo]), self._nm
        )
        for program in self.trees:
            program.set("u_albedos", self.albedos.astype(np.float32))
            program.set("u_autumn", self.autumn.astype(np.float32))
            if self.has_own:
                program.set("u_own", packed(cover.species, self._nm))
