"""The colours of a lens's picture: exposed light of its faces, put together, then glare and tone map over the whole.

Faces are taken before glare: it would end where a face does.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..camera.intrinsics import Intrinsics
from ..components import Composite
from ..engine.wavelengths import Nanometres
from ..systems.composite.finish import finished, press, unpress
from ..systems.composite.photometry import expose
from .lens_faces import FacePixels
from .resample import light

__all__ = ["LensLight"]

_RESOLVED, _QUARTER = "composite.resolved", "composite.quarter"


class LensLight:
    """Of one picture. composite: with the renderer's overrides. nm: the wavelengths of its radiance."""

    def __init__(self, lens: Intrinsics, composite: Composite, nm: Nanometres) -> None:
        self._lens, self._composite, self._nm = lens, composite, nm
        self._smoothed = composite.antialiasing != "none"
        self._quarter_size = -(-lens.height // 4), -(-lens.width // 4)
        glares = composite.bloom > 0.0
        self.outputs: tuple[str, ...] = (
            "color",
            _RESOLVED if self._smoothed else "radiance",
            *((_QUARTER,) if glares else ()),
        )
        """What it needs of each face. "color", so that it is exposed."""
        self._pressed = np.zeros((lens.height * lens.width, 3), np.float32)
        self._quarter = np.zeros((math.prod(self._quarter_size), 3), np.float32) if glares else None

    def add(self, face: FacePixels, arrays: dict[str, NDArray[Any]], ev100: float) -> None:
        """A face. Light is averaged as it is shown, or a sun would be seen in all pixels around."""
        shown = arrays[_RESOLVED][..., :3] if self._smoothed else press(expose(arrays["radiance"], ev100, self._nm))
        self._pressed[face.pixels] = light(shown, face)
        if self._quarter is not None:
            part = _quartered(face, self._lens)
            self._quarter[part.pixels] = expose(light(arrays[_QUARTER][..., :3], part), ev100, self._nm)

    def picture(self, seen: NDArray[np.bool_]) -> NDArray[np.uint8]:
        """(H, W, 3) sRGB. seen: (H, W), where the lens has rays."""
        lens, quarter = self._lens, self._quarter
        shape = lens.height, lens.width, 3
        if quarter is not None:
            quarter = quarter.reshape(*self._quarter_size, 3)
        around = lens.model == "equirectangular" and lens.width / lens.fx > 2.0 * math.pi - 1e-6
        shown = finished(unpress(self._pressed.reshape(shape)), quarter, self._composite, around)
        shown[~seen] = 0
        return shown


@lru_cache(maxsize=24)
def _quartered(face: FacePixels, lens: Intrinsics) -> FacePixels:
    """A face at a quarter of its size, for a picture of a quarter of the lens's size."""
    rows, columns = np.divmod(face.pixels, lens.width)
    # The middle of each 4 x 4 pixels; the last ones may be fewer.
    chosen = (rows % 4 == 2) | ((rows == lens.height - 1) & (lens.height % 4 in (1, 2)))
    chosen &= (columns % 4 == 2) | ((columns == lens.width - 1) & (lens.width % 4 in (1, 2)))
    pixels = (rows[chosen] // 4) * -(-lens.width // 4) + columns[chosen] // 4
    part = {name: getattr(face, name)[chosen] / 4.0 for name in ("x", "y")}
    return replace(face, pixels=pixels, spread=face.spread[chosen], **part)
