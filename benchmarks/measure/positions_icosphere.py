"""Vertices of the icosphere's tiles against extended precision, level by level, as an angle on screen."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.blocks.bindings import TRIANGLE_BLOCK
from ...engine.gpu import Gpu
from ...engine.surface.icosphere import CORNERS, FULL_BITS, ROOTS, TriangleScheme, vector_of
from ...engine.surface.icosphere_anchor import TriangleAnchor
from ...engine.surface.proxy import snap_proxy
from .. import exact
from ..evaluate import Evaluator
from .positions import EDGE_PX, PIXEL_RAD

SEGMENTS = 32
SCHEME = TriangleScheme()


class IcospherePositions:
    """Evaluates `triangle_foot_offset` as vertices are made and drawn: one rounding to f32 from the anchor, one from
    the camera."""

    def __init__(self, gpu: Gpu) -> None:
        self._scope = gpu.scope("icosphere positions")
        self._block = self._scope.buffer(reserve=len(TriangleAnchor((1, 0, 0), 1.0).block), dynamic=True)
        self._evaluate = Evaluator(
            gpu,
            "precise vec3 relative = triangle_foot_offset(root, bc) - offset; seen = relative;",
            {"root": "int", "bc": "ivec2", "offset": "vec3"},
            {"seen": "vec3"},
            '#include "common/icosphere.glsl"',
        )

    def worst_px(self, radius_m: float, level: int, zenith: ArrayLike) -> float:
        """A camera above `zenith` (3,), as high as makes a segment EDGE_PX long; the tile below it and those beside.

        Returns the largest angle, in pixels of PIXEL_RAD, between where a vertex is drawn and where it is."""
        spacing_m = float(SCHEME.spacing_rad(level, SEGMENTS)) * radius_m
        position = np.asarray(zenith, dtype=np.float64)
        altitude_m = max(0.5 * spacing_m / (EDGE_PX * PIXEL_RAD), 0.05)
        position = position * ((radius_m + altitude_m) / np.linalg.norm(position))
        proxy = snap_proxy(position, radius_m, lambda d: np.zeros(len(d)), None)
        anchor = TriangleAnchor(proxy.anchor().direction, radius_m)
        tile = SCHEME.at(position, level)
        root, b, c = tile_points(np.unique(np.append(SCHEME.neighbour(tile, np.arange(3)), tile)))
        self._block.write(anchor.block)
        offset = position - anchor.direction * radius_m
        found = self._evaluate(
            lambda: self._block.bind_to_uniform_block(TRIANGLE_BLOCK),
            root=root,
            bc=np.stack([b, c], axis=-1),
            offset=np.broadcast_to(offset, (len(root), 3)),
        )["seen"]
        vectors = vector_of(root, b, c).astype(exact.Real)
        feet = vectors / np.sqrt((vectors * vectors).sum(axis=-1))[:, None]
        truth = feet * exact.Real(radius_m) - position.astype(exact.Real)
        return float(np.max(exact.angle_between(found, truth)) / PIXEL_RAD)

    def release(self) -> None:
        """Free the GL objects."""
        self._evaluate.release()
        self._scope.release()

    def __enter__(self) -> IcospherePositions:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def tile_points(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """All vertices of tiles as lattice points: root, b, c."""
    root, b, c = SCHEME.corner_points(keys)
    q, p = np.nonzero(np.add.outer(np.arange(SEGMENTS + 1), np.arange(SEGMENTS + 1)) <= SEGMENTS)
    sign = np.sign(b[:, 1] - b[:, 0])[:, None]
    step = (np.int64(1) << FULL_BITS - SCHEME.level(keys))[:, None] // SEGMENTS * sign
    all_b, all_c = b[:, :1] + p * step, c[:, :1] + q * step
    return np.repeat(root, len(p)), all_b.ravel(), all_c.ravel()


def special_places() -> list[NDArray[np.float64]]:
    """A pole, corners, the middles of an edge and of a root."""
    corners = CORNERS.astype(np.float64)
    edge = corners[ROOTS[3, 0]] + corners[ROOTS[3, 1]]
    return [
        np.array([0.0, 0.0, 1.0]),
        np.array([0.0, 0.0, -1.0]),
        corners[0],
        corners[7],
        edge,
        corners[ROOTS[9]].sum(0),
    ]
