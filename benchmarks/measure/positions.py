"""Undisplaced vertex positions against extended precision, as an angle on screen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import LATTICE_BLOCK
from ...engine.gpu import Gpu
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.lattice import FULL_BITS
from ...engine.surface.proxy import ProxyCell, snap_proxy
from ...engine.surface.selection import CellSet, select_rings
from .. import exact
from ..evaluate import Evaluator

ROWS, FOV_Y_DEG = 1080, 60.0
PIXEL_RAD = 2.0 * np.tan(np.radians(FOV_Y_DEG) / 2) / ROWS
"""The angle of a pixel in the middle of a picture of 1080 rows and 60 degrees: the unit "px" of all results."""

EDGE_PX = 6.0


@dataclass(frozen=True)
class PositionError:
    """Of one camera: the worst angle, in pixels, and what was looked at."""

    worst_px: float
    baseline_px: float
    """The same with planet coordinates in f32, what a renderer without anchors would show."""
    not_finite: int
    vertices: int
    cells: int


class PositionProbe:
    """Evaluates the statements of terrain/vertices.comp and terrain/gbuffer.vert on flat ground."""

    def __init__(self, gpu: Gpu) -> None:
        self._scope = gpu.scope("position probe")
        self._lattice = self._scope.buffer(reserve=320, dynamic=True)
        self._evaluate = Evaluator(
            gpu,
            """
            vec3 D = lattice_foot_offset(face, ij);
            precise vec3 position = D * (1.0 + 0.0 / lattice_block.radius_m) + lattice_block.up * 0.0;
            precise vec3 relative = position - offset;
            seen = relative;
            precise vec3 absolute = lattice_direction(face, ij) * lattice_block.radius_m;
            plain = absolute - camera;
            """,
            {"face": "int", "ij": "ivec2", "offset": "vec3", "camera": "vec3"},
            {"seen": "vec3", "plain": "vec3"},
            '#include "common/lattice.glsl"',
        )

    def measure(
        self, radius_m: float, altitude_m: float, rng: np.random.Generator, most: int = 20_000
    ) -> PositionError:
        """A camera at a random place and altitude; up to `most` vertices, the nearest cells always among them."""
        zenith = rng.normal(size=3)
        position = zenith / np.linalg.norm(zenith) * (radius_m + altitude_m)
        cell = snap_proxy(position, radius_m, _flat, None)
        cells = select_flat(cell)
        face, ij = some_vertices(cells, rng, most)
        anchor = cell.anchor()
        self._lattice.write(anchor.block.tobytes())
        offset = position - anchor.direction * radius_m  # as ProxySystem forms it
        found = self._evaluate(
            lambda: self._lattice.bind_to_uniform_block(LATTICE_BLOCK),
            face=face,
            ij=ij,
            offset=np.broadcast_to(offset, (len(face), 3)),
            camera=np.broadcast_to(position, (len(face), 3)),
        )
        truth = exact.lattice_direction(face, ij[:, 0], ij[:, 1]) * exact.Real(radius_m) - position.astype(exact.Real)
        # A vertex at the camera's very place has no direction: a near plane in front of it hides it.
        away = np.sqrt((truth * truth).sum(axis=1)).astype(float) > 1e-3
        finite = np.isfinite(found["seen"]).all(axis=1)
        usable = finite & away
        return PositionError(
            worst_px=_worst(found["seen"][usable], truth[usable]),
            baseline_px=_worst(found["plain"][usable], truth[usable]),
            not_finite=int((~finite).sum()),
            vertices=len(face),
            cells=len(cells),
        )

    def release(self) -> None:
        """Free the GL objects."""
        self._evaluate.release()
        self._scope.release()

    def __enter__(self) -> PositionProbe:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def select_flat(cell: ProxyCell, edge_px: float = EDGE_PX, quads: int = 16, highest_m: float = 0.0) -> CellSet:
    """The cells of a planet without relief, for a picture of 1080 rows."""
    reach = proxy_coverage(cell.highest_altitude_m, cell.max_sideways_rad, cell.radius_m, highest_m)
    return select_rings(
        cell.direction,
        cell.altitude_above_ground_m,
        cell.ground_height_m,
        cell.radius_m,
        edge_px * PIXEL_RAD,
        quads,
        coverage_rad=reach.half_angle_rad,
        min_spacing_m=0.06,
    )


def some_vertices(cells: CellSet, rng: np.random.Generator, most: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Lattice points (face (N,), IJ (N, 2)) of vertices: all of the nearest cells, a random sample of the others."""
    side = cells.quads + 1
    nearest = min(len(cells), 16)
    rest = rng.permutation(np.arange(nearest, len(cells)))[: max(most // side**2 - nearest, 0)]
    chosen = np.concatenate([np.arange(nearest), rest])
    shift = FULL_BITS - cells.level[chosen].astype(np.int64)
    step = np.int64(1) << (shift - (cells.quads.bit_length() - 1))
    b, a = np.divmod(np.arange(side**2), side)
    i = (cells.i[chosen].astype(np.int64) << shift)[:, None] + a * step[:, None]
    j = (cells.j[chosen].astype(np.int64) << shift)[:, None] + b * step[:, None]
    face = np.repeat(cells.face[chosen].astype(np.int64), side**2)
    return face, np.stack([i.ravel(), j.ravel()], axis=1)


def _flat(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros(len(directions))


def _worst(found: NDArray[np.float32], truth: NDArray[np.longdouble]) -> float:
    usable = np.isfinite(found).all(axis=1) & (found != 0.0).any(axis=1)
    if not usable.any():
        return 0.0
    found, truth = found[usable], truth[usable]
    return float(np.max(exact.angle_between(found, truth)) / PIXEL_RAD)
