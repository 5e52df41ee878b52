"""Offsets between lattice points and an anchor without cancellation: float64 data for the shader, and its twins.

A surface point is sent to the GPU as r (dir(q) - up), up being the anchor's direction. Subtracting two unit vectors in
float32 would lose everything near the anchor, so the difference is built from integer differences of lattice
coordinates: the anchor itself is a lattice point of its own face (fraction zero), and on the other faces its
coordinates are an integer plus a small fraction formed in float64. With a = angle of the point, a0 = angle of the
anchor, d = a - a0: tan a - tan a0 = sin d / (cos a0 cos a). With q = (tan a, tan b, 1), q0 the anchor's and D = q - q0,

    dir(q) - up = (D - q0 w / ((|q| + |q0|) |q0|)) / |q|,   w = |q|^2 - |q0|^2 = D.(q + q0),

in the face's axes. Where the anchor is far to the side of a face or behind it, the offset is large and the plain
difference is used.
"""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..blocks.bindings import LATTICE_BLOCK
from ..blocks.layout import IVec2, StructLayout, Vec2, Vec3, array
from ..made_shaders import made_shader
from .lattice import (
    FACE_AXES,
    FULL,
    FULL_BITS,
    HALF,
    STEP_RAD,
    canonical_lattice,
    direction_of,
    snap,
    to_face,
    to_planet,
)

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

NEAR_COSINE = 0.42
"""A face uses the difference formula when the anchor's direction has at least this component along the face's axis."""


@dataclass
class LatticeFace:
    """The anchor seen from a face of the cube. a0, b0: its angles there; q0 = (tan a0, tan b0, 1)."""

    nearest: Annotated[IVec2, "lattice point I, J next to the anchor"]
    near: Annotated[bool, "or else the plain difference is as good as its terms"]
    fraction: Annotated[Vec2, "anchor - nearest, in steps"]
    step_per_cosine: Annotated[Vec2, "a step / cos a0, a step / cos b0"]
    tangent: Annotated[Vec2, "tan a0, tan b0"]
    norm: Annotated[float, "|q0|"]


@dataclass
class LatticeBlock:
    """What common/lattice.glsl reads of an anchor. GLSL: ``generated/lattice_block.glsl``, instance `lattice_block`."""

    faces: Annotated[Any, array(LatticeFace, 6)]
    up: Annotated[Vec3, "of the anchor, planet axes"]
    radius_m: float
    up_low: Annotated[Vec3, "what up lacks"]

    def tobytes(self) -> bytes:
        """The block as the GPU wants it, 320 bytes."""
        return _LAYOUT.pack(self)


_LAYOUT = StructLayout(LatticeBlock)
made_shader("generated/lattice_block.glsl", lambda: _LAYOUT.block(LATTICE_BLOCK, "lattice_block"))


class LatticeAnchor:
    """A lattice point of the sphere from which other lattice points are measured.

    Parameters: `direction` (3,), snapped to the lattice (to within half a lattice step, 5 mm on Earth), or use
    `at(face, I, J, radius_m)` to name the point itself; `radius_m` of the reference sphere.
    Attributes: face, i, j (canonical lattice point), radius_m, direction (3,) float64, block (LatticeBlock).
    """

    def __init__(self, direction: ArrayLike, radius_m: float) -> None:
        vector = np.asarray(direction, dtype=np.float64)
        if vector.shape != (3,) or not np.all(np.isfinite(vector)) or not np.any(vector):
            raise ValueError(f"LatticeAnchor: direction must be a finite, non-zero vector (3,), found {direction!r}")
        face, i, j = snap(vector, FULL_BITS)
        self._place(int(face), int(i), int(j), radius_m)

    @classmethod
    def at(cls, face: int, i: int, j: int, radius_m: float) -> "LatticeAnchor":
        """The anchor at lattice point (face, I, J)."""
        if not (0 <= face < 6 and 0 <= i <= FULL and 0 <= j <= FULL):
            raise ValueError(f"LatticeAnchor.at: expected face 0..5, I and J 0..{FULL}, found {face}, {i}, {j}")
        anchor = cls.__new__(cls)
        names = canonical_lattice(face, i, j)
        anchor._place(int(names[0]), int(names[1]), int(names[2]), radius_m)
        return anchor

    def _place(self, face: int, i: int, j: int, radius_m: float) -> None:
        if not (np.isfinite(radius_m) and radius_m > 0):
            raise ValueError(f"LatticeAnchor: radius_m must be positive and finite, found {radius_m!r}")
        self.face, self.i, self.j = face, i, j
        self.radius_m = float(radius_m)
        self.direction: Floats = direction_of(face, i, j)
        self._faces = [_FaceData.of(face, i - HALF, j - HALF, other) for other in range(6)]
        self.block = self._make_block()

    def __repr__(self) -> str:
        return f"LatticeAnchor(face={self.face}, i={self.i}, j={self.j}, radius_m={self.radius_m})"

    def _make_block(self) -> LatticeBlock:
        high = self.direction.astype(np.float32)
        return LatticeBlock([data.uniforms() for data in self._faces], high, self.radius_m, self.direction - high)

    def foot_offset64(self, face: ArrayLike, i_full: ArrayLike, j_full: ArrayLike) -> Floats:
        """r (dir - up) in metres, planet axes, (..., 3) float64: relative error of a few 1e-16 at any distance."""
        return self._offset(face, i_full, j_full, np.float64)

    def foot_offset32(self, face: ArrayLike, i_full: ArrayLike, j_full: ArrayLike) -> Floats32:
        """The shader's `lattice_foot_offset` in numpy float32, formula for formula (not bit for bit)."""
        return self._offset(face, i_full, j_full, np.float32)

    def _offset(self, face: ArrayLike, i_full: ArrayLike, j_full: ArrayLike, real: Any) -> Any:
        faces, i, j = canonical_lattice(face, i_full, j_full)
        data = self._faces

        def column(name: str) -> Any:
            return np.array([getattr(d, name) for d in data], dtype=real)[faces]

        step = real(STEP_RAD)
        origin_i = np.array([d.i for d in data])[faces]
        origin_j = np.array([d.j for d in data])[faces]
        steps_i = (i - origin_i).astype(real) - column("fraction_i")
        steps_j = (j - origin_j).astype(real) - column("fraction_j")
        a, b = (i - HALF).astype(real) * step, (j - HALF).astype(real) * step
        cos_a, cos_b = np.cos(a), np.cos(b)
        qx, qy = np.sin(a) / cos_a, np.sin(b) / cos_b
        norm = np.sqrt(qx * qx + qy * qy + real(1))
        radius = real(self.radius_m)
        tan_a, tan_b = column("tan_a"), column("tan_b")
        norm0 = np.sqrt(tan_a * tan_a + tan_b * tan_b + real(1))
        dx = np.sin(steps_i * step) / (column("cos_a") * cos_a)
        dy = np.sin(steps_j * step) / (column("cos_b") * cos_b)
        w = dx * (qx + tan_a) + dy * (qy + tan_b)
        t = w / ((norm + norm0) * norm0)
        scale = radius / norm
        local = np.stack([(dx - tan_a * t) * scale, (dy - tan_b * t) * scale, -t * scale], axis=-1)
        near = to_planet(faces, local)
        plain = to_planet(faces, np.stack([qx / norm, qy / norm, real(1) / norm], axis=-1)).astype(real)
        far = (plain - self.direction.astype(real)) * radius
        return np.where(column("near")[..., None] > 0, near, far).astype(real)


@dataclass(frozen=True)
class _FaceData:
    """The anchor seen from one face: integer and fraction of its lattice coordinates, and its angles a0, b0."""

    i: int
    j: int
    fraction_i: float
    fraction_j: float
    tan_a: float
    tan_b: float
    cos_a: float
    cos_b: float
    near: int

    def uniforms(self) -> LatticeFace:
        steps = STEP_RAD / self.cos_a, STEP_RAD / self.cos_b
        norm = float(np.sqrt(1.0 + self.tan_a**2 + self.tan_b**2))
        ij, fraction, tangent = (self.i, self.j), (self.fraction_i, self.fraction_j), (self.tan_a, self.tan_b)
        return LatticeFace(ij, bool(self.near), fraction, steps, tangent, norm)

    @staticmethod
    def of(own_face: int, u: int, v: int, face: int) -> "_FaceData":
        """From the anchor's own face and centred integer coordinates (u, v).

        On a side face one of the two angles is exactly pi/2 minus an own angle, an integer again; the other is the
        own one plus a correction that vanishes at the common edge, so both stay exact next to the edge.
        """
        direction = to_face(face, direction_of(own_face, u + HALF, v + HALF))
        if direction[2] < NEAR_COSINE:
            return _FaceData(0, 0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0)
        if face == own_face:
            a, b = u * STEP_RAD, v * STEP_RAD
            return _FaceData(u + HALF, v + HALF, 0.0, 0.0, np.tan(a), np.tan(b), float(np.cos(a)), float(np.cos(b)), 1)
        rows = FACE_AXES[own_face] @ FACE_AXES[face].T
        # rows[k, m]: own axis k along this face's axis m. The own axis that is this face's outward axis:
        towards = int(np.flatnonzero(rows[:2, 2])[0])
        own = (u, v)
        k_towards = int(rows[towards, 2]) * own[towards]
        k_other = own[1 - towards]
        # tan of the other angle here is tan(other) / tan(towards): a correction of the own angle.
        delta = (HALF - k_towards) * STEP_RAD
        tan_delta, tan_other = np.tan(delta), np.tan(k_other * STEP_RAD)
        short = 2.0 * tan_delta / (1.0 + tan_delta)
        correction = np.arctan(tan_other * short / (1.0 - short + tan_other**2)) / STEP_RAD
        whole = round(correction)
        along_other = (k_other + whole, correction - whole)
        along_z = (FULL - k_towards, 0.0)
        result: list[tuple[int, float]] = [(0, 0.0), (0, 0.0)]
        for axis in range(2):
            if rows[2, axis]:
                sign, source = int(rows[2, axis]), along_z
            else:
                sign, source = int(rows[1 - towards, axis]), along_other
            result[axis] = (sign * source[0], sign * source[1])
        (ki, fi), (kj, fj) = result
        a, b = (ki + fi) * STEP_RAD, (kj + fj) * STEP_RAD
        return _FaceData(
            ki + HALF, kj + HALF, fi, fj, float(np.tan(a)), float(np.tan(b)), float(np.cos(a)), float(np.cos(b)), 1
        )
