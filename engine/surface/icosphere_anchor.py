"""Points of the icosphere's lattice, measured in float64 from any direction without cancellation.

The anchor's direction u is three float64 numbers, so the point q0 = t u on the plane of a root (t rational) is known
exactly; it is kept as the nearest integer vector P0 and a rest below one lattice unit, rounded once. For a lattice
point with the integer vector P the difference D = (P - P0) - rest then has all its digits, next to the anchor too, and
with q0 = P0 + rest

    dir(P) - u = (D - q0 w / ((|P| + |q0|) |q0|)) / |P|,   w = |P|^2 - |q0|^2 = D.(P + q0).

Which root's q0 is used is a matter of digits only (P is exact in any case), but of bits as well: a point on an edge
uses the lowest root that contains it. Where the anchor is far to the side of a root or behind it, offsets are large and
the plain difference is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..blocks.bindings import TRIANGLE_BLOCK
from ..blocks.layout import Double, DVec3, StructLayout, array
from ..made_shaders import made_shader
from .icosphere import FULL, ROOT_VECTORS, lowest_root, unit, vector_of

Floats = NDArray[np.float64]

NEAR_COSINE = 0.5
"""A root uses the difference formula when the anchor lies within 60 degrees of its middle: all of the root itself lies
within 37.4 degrees, so offsets from anchors farther out than this are longer than 0.38 radii."""


@dataclass
class TriangleRoot:
    """Where the anchor's ray meets a root's plane, in units of the lattice: whole + rest."""

    whole: Annotated[DVec3, "integers"]
    length: Annotated[Double, "0: use the plain difference"]
    rest: DVec3


@dataclass
class TriangleBlock:
    """GLSL: ``generated/triangle_anchor.glsl``, ``triangle_anchor``."""

    roots: Annotated[Any, array(TriangleRoot, 20)]
    direction: Annotated[DVec3, "of the anchor, unit"]
    radius_m: Double


_LAYOUT = StructLayout(TriangleBlock)
made_shader("generated/triangle_anchor.glsl", lambda: _LAYOUT.block(TRIANGLE_BLOCK, "triangle_anchor"))


class AnchorKey(NamedTuple):
    """What a view's anchor is made for. proxy: its generation."""

    proxy: int
    radius_m: float


class TriangleAnchor:
    """A direction from which lattice points of the icosphere are measured, e.g. that of a `LatticeAnchor`.

    Parameters: `direction` (3,) float64, taken exactly as it is but for its length; `radius_m` of the reference sphere.
    `block` (bytes) is the uniform block `TriangleBlock`.
    """

    def __init__(self, direction: ArrayLike, radius_m: float) -> None:
        u = np.asarray(direction, dtype=np.float64)
        if u.shape != (3,) or not np.all(np.isfinite(u)) or not np.any(u):
            raise ValueError(f"TriangleAnchor: direction must be a finite, non-zero vector (3,), found {direction!r}")
        if not (np.isfinite(radius_m) and radius_m > 0):
            raise ValueError(f"TriangleAnchor: radius_m must be positive and finite, found {radius_m!r}")
        self.radius_m = float(radius_m)
        self.direction: Floats = u / np.linalg.norm(u)
        self.whole: Floats = np.zeros((20, 3))
        self.rest: Floats = np.zeros((20, 3))
        self.norm: Floats = np.zeros(20)
        exact = [Fraction(float(x)) for x in u]
        for root, corners in enumerate(ROOT_VECTORS):
            if _MIDDLES[root] @ self.direction >= NEAR_COSINE:
                self._place(root, corners, exact)

    def _place(self, root: int, corners: NDArray[np.int64], u: list[Fraction]) -> None:
        a, b, c = ([int(x) for x in corner] for corner in corners)
        normal = _cross([y - x for x, y in zip(a, b, strict=True)], [y - x for x, y in zip(a, c, strict=True)])
        height = sum(n * x for n, x in zip(normal, a, strict=True)) * FULL
        t = height / sum(n * x for n, x in zip(normal, u, strict=True))
        foot = [t * x for x in u]
        whole = [round(x) for x in foot]
        self.whole[root] = whole
        self.rest[root] = [float(x - n) for x, n in zip(foot, whole, strict=True)]
        # sqrt of a rational to all digits of a float64: 40 more bits than the integer part has.
        self.norm[root] = isqrt(int(sum(x * x for x in foot) * (1 << 80))) / float(1 << 40)

    @property
    def block(self) -> bytes:
        record = np.zeros((), _LAYOUT.dtype)
        roots = record["roots"]
        roots["whole"], roots["length"], roots["rest"] = self.whole, self.norm, self.rest
        record["direction"], record["radius_m"] = self.direction, self.radius_m
        return record.tobytes()

    def foot_offset64(self, root: ArrayLike, b: ArrayLike, c: ArrayLike) -> Floats:
        """r (dir - u) in metres, planet axes, (..., 3): relative error of a few 1e-16. The shader's, formula for
        formula."""
        row = lowest_root(root, b, c)
        p = vector_of(root, b, c).astype(np.float64)
        norm = np.sqrt(p[..., 0] * p[..., 0] + p[..., 1] * p[..., 1] + p[..., 2] * p[..., 2])
        norm0 = self.norm[row]
        near = norm0 > 0
        whole, rest = self.whole[row], self.rest[row]
        d = (p - whole) - rest
        q0 = whole + rest
        sums = p + q0
        w = d[..., 0] * sums[..., 0] + d[..., 1] * sums[..., 1] + d[..., 2] * sums[..., 2]
        t = w / ((norm + norm0) * np.where(near, norm0, 1.0))
        close = (d - q0 * t[..., None]) * (self.radius_m / norm)[..., None]
        far = (p / norm[..., None] - self.direction) * self.radius_m
        return np.where(near[..., None], close, far)


def _cross(x: list[int], y: list[int]) -> list[int]:
    return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]


_MIDDLES: Floats = unit(ROOT_VECTORS.sum(axis=1))
