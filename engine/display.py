"""What a display shows of light at three wavelengths, and which reflectance shows a wanted colour.

Light is (..., 3) at the wavelengths `nm` in units of sunlight, colours are linear sRGB for an eye to which sunlight is
white. In GLSL: common/color.glsl. docs/exposure.md says where the numbers come from.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .made_shaders import made_shader
from .wavelengths import DISPLAY_NM, GIVEN_NM, SUNLIGHT, Nanometres

__all__ = ["BETWEEN", "DISPLAY", "WAVELENGTHS_FILE", "display_color", "light_of_color", "reflectance", "shader"]

Floats = NDArray[np.float64]

WAVELENGTHS_FILE = "generated/wavelengths.glsl"
"""The shader file that `shader` makes: that of light as given, unless a renderer has its own."""

DISPLAY: Mapping[Nanometres, Floats] = {
    DISPLAY_NM: np.array([[1.729, -0.712, -0.017], [-0.07, 1.042, 0.028], [-0.037, 0.013, 1.024]]),
    GIVEN_NM: np.array([[0.0, 0.144, -0.552], [-0.027, 0.77, -0.011], [-0.006, 0.048, 1.077]]),
}
"""Rows: red, green and blue of what there is at three wavelengths."""
BETWEEN: Mapping[Nanometres, Floats] = {
    GIVEN_NM: np.array([[1.1, 0.775, -0.467], [0.109, 0.01, 0.149], [-0.077, -0.298, 0.256]]),
}
"""The same of what lies between two of them, where a matrix is not enough: geometric means of 680 and 550, 550 and 440,
440 and 680 nm. Together with DISPLAY rows add up to 1, so that sunlight comes out white."""

_NEXT = (1, 2, 0)


def display_color(light: ArrayLike, nm: Nanometres) -> Floats:
    """Linear sRGB (..., 3) of light; below 0 where a display cannot show it.

    Where there are means, root-polynomial colour correction (Finlayson, Mackiewicz and Hurlbert 2015): scaled light
    comes out scaled, which no other polynomial of the second degree does.
    """
    known = np.maximum(np.asarray(light, dtype=np.float64), 0.0)
    found = known @ DISPLAY[nm].T
    if nm in BETWEEN:
        found += np.sqrt(known * known[..., _NEXT]) @ BETWEEN[nm].T
    return found


def reflectance(color: ArrayLike, nm: Nanometres) -> Floats:
    """Shares 0..1 of light (..., 3) that ground of a colour (..., 3), linear sRGB, throws back: in sunlight outside the
    air the colour is what shows."""
    return np.minimum(light_of_color(color, nm), 1.0)


def light_of_color(color: ArrayLike, nm: Nanometres) -> Floats:
    """The inverse of `display_color`. Colours that no light of three wavelengths shows come out as near as a few steps
    of Newton's method get."""
    wanted = np.clip(np.asarray(color, dtype=np.float64), 0.0, None)
    if nm not in BETWEEN:
        return np.maximum(wanted @ np.linalg.inv(DISPLAY[nm]).T, 0.0)
    display, between = DISPLAY[nm], BETWEEN[nm]
    # In square roots of light, colours are quadratic forms, without the infinite slopes of roots at 0.
    root = np.sqrt(np.maximum(wanted, 1e-6))
    for _ in range(20):
        slope = 2.0 * display * root[..., None, :]
        slope = slope + between * root[..., None, _NEXT]
        slope = slope + (between * root[..., None, :])[..., (2, 0, 1)]
        off = wanted - display_color(root * root, nm)
        if np.abs(off).max(initial=0.0) < 1e-7:
            break
        step = np.asarray(np.linalg.solve(slope, off[..., None]), dtype=np.float64)[..., 0]
        root = np.clip(root + step, 0.5 * root, 2.0 * root + 1e-3)
    return root * root


def shader(nm: Nanometres) -> str:
    """GLSL: the wavelengths, sunlight there, and the map to colours; DISPLAY_BETWEEN is defined where there are
    means."""
    text = f"const vec3 WAVELENGTHS_NM = vec3({_listed(nm)});\n"
    text += f"const vec3 SUNLIGHT = vec3({_listed(SUNLIGHT[nm])});   // W m^-2 nm^-1\n"
    text += f"const mat3 DISPLAY = mat3({_listed(DISPLAY[nm].T)});\n"
    if nm in BETWEEN:
        text += f"#define DISPLAY_BETWEEN mat3({_listed(BETWEEN[nm].T)})\n"
    return text


def _listed(numbers: ArrayLike) -> str:
    return ", ".join(repr(float(n)) for n in np.ravel(np.asarray(numbers)))


made_shader(WAVELENGTHS_FILE, lambda: shader(GIVEN_NM))
