"""HostSpace: a host's own world standing on a planet; its cameras and its depth buffer in a planet's terms and back.

    space = pf.HostSpace.at(47.0, 8.0, above="ground", planet=scene.planet)     # metres, x right, y up, -z ahead
    camera = space.camera(view_matrix, projection_matrix)
    renderer.render_to(framebuffer, camera, depth=space.depth(projection_matrix))

Matrices are those of OpenGL: the view looks along -z, and a projection maps to clip space. They are given as (4, 4)
arrays that multiply column vectors, or as 16 numbers in OpenGL's memory order, as pyglet.math.Mat4 has them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera.camera import Camera
from ..camera.place import check_number, check_vector, make_place
from ..engine.space import CameraState, heading_pitch_axes
from ..errors import CameraError
from ..scene.scene import PlanetHandle

__all__ = ["HostDepth", "HostSpace"]

Floats = NDArray[np.float64]

_TURN_ERROR = 1e-4
"""How far a host's view matrix, often in single precision, may be from a pure rotation."""


@dataclass(frozen=True)
class HostDepth:
    """How a host's depth buffer stores distances: window depth = offset + scale_m / z, z metres along the view.

    Every perspective projection is of this kind, reversed ones and those without a far plane too. Planet pixels beyond
    the host's far plane get the depth of that plane.
    """

    offset: float
    scale_m: float

    @property
    def reversed(self) -> bool:
        """Whether nearer is greater."""
        return self.scale_m > 0.0

    @classmethod
    def of(
        cls,
        projection: ArrayLike,
        unit_m: float = 1.0,
        zero_to_one: bool = False,
        depth_range: tuple[float, float] = (0.0, 1.0),
    ) -> HostDepth:
        """From a projection matrix. unit_m: metres in the host's unit. zero_to_one: the host has called
        glClipControl(.., GL_ZERO_TO_ONE); else clip depth goes from -1 to 1. depth_range: the host's glDepthRange.
        CameraError for anything but a perspective projection."""
        matrix = _perspective(projection)
        unit = check_number("unit_m", unit_m, 0.0)
        near, far = depth_range
        half = (0.0, far - near, near) if zero_to_one else (0.0, 0.5 * (far - near), 0.5 * (far + near))
        # clip depth / clip w with w = z: (-m22 z + m23) / z, z in the host's unit.
        return cls(half[2] - half[1] * float(matrix[2, 2]), half[1] * float(matrix[2, 3]) * unit)

    def window_depth(self, z_m: ArrayLike) -> Floats:
        """Depths (...) between 0 and 1 of distances along the view (...)."""
        return np.clip(self.offset + self.scale_m / np.asarray(z_m, np.float64), 0.0, 1.0)


class HostSpace:
    """A host's world: where its origin stands on a planet, how its axes lie there and how long its unit is.

    origin_m: (3,) f64, planet-centred, planet axes. axes: (3, 3) f64, rows are the host's x, y and z in planet axes.
    unit_m: metres in the host's unit. planet: the planet it stands on, for the cameras made here; None: the scene's.
    """

    def __init__(
        self, origin_m: ArrayLike, axes: ArrayLike, unit_m: float = 1.0, planet: str | PlanetHandle | None = None
    ) -> None:
        self.origin_m = check_vector("origin_m", origin_m)
        self.axes = _rotation("axes", np.asarray(axes, np.float64))
        self.unit_m = check_number("unit_m", unit_m, 1e-12, 1e12)
        self.planet = planet

    @classmethod
    def at(
        cls,
        latitude_deg: float,
        longitude_deg: float,
        altitude_m: float = 0.0,
        heading_deg: float = 0.0,
        *,
        above: str = "sphere",
        up: str = "y",
        unit_m: float = 1.0,
        planet: PlanetHandle,
    ) -> HostSpace:
        """A world whose origin stands over a place of a planet such as scene.planet, as in Camera.at.

        up="y": x to the right of the heading, y up, -z along the heading (OpenGL, pyglet). up="z": x to the right, y
        along the heading, z up.
        """
        if up not in ("y", "z"):
            raise CameraError(f"HostSpace: up: expected 'y' or 'z', found {up!r}")
        if not isinstance(planet, PlanetHandle):
            raise CameraError(
                f"HostSpace.at: planet: expected one of a scene, whose radius and ground count, found {planet!r}; "
                'give planet=scene.planet or planet=scene.planets["moon"]'
            )
        place = make_place(latitude_deg, longitude_deg, altitude_m, heading_deg, 0.0, above)
        origin = place.position_m(planet)
        ahead, above_axis = heading_pitch_axes(origin / np.linalg.norm(origin), heading_deg, 0.0)
        right = np.cross(ahead, above_axis)
        rows = (right, above_axis, -ahead) if up == "y" else (right, ahead, above_axis)
        return cls(origin, np.stack(rows), unit_m, planet)

    # -- points ------------------------------------------------------------------------------------------------------

    def to_planet(self, points: ArrayLike) -> Floats:
        """Host points (..., 3) as planet-centred metres (..., 3)."""
        return self.origin_m + self.unit_m * (np.asarray(points, np.float64) @ self.axes)

    def to_host(self, points_m: ArrayLike) -> Floats:
        """Planet-centred metres (..., 3) as host points (..., 3)."""
        return (np.asarray(points_m, np.float64) - self.origin_m) @ self.axes.T / self.unit_m

    def on_surface(self, points: ArrayLike, height_m: float = 0.0) -> Floats:
        """Host points (N, 3) moved along the planet's vertical to height_m above the higher of ground and sea: (N, 3).

        Needs the planet: HostSpace(..., planet=scene.planet)."""
        if not isinstance(self.planet, PlanetHandle):
            raise CameraError("HostSpace.on_surface: which ground? Make the space with planet=scene.planet")
        places = np.atleast_2d(self.to_planet(points))
        up = places / np.linalg.norm(places, axis=1, keepdims=True)
        away = self.planet.radius_m + self.planet.surface_height_m(up) + height_m
        return self.to_host(up * away[:, None])

    def direction_to_planet(self, directions: ArrayLike) -> Floats:
        """Host directions (..., 3) in planet axes."""
        return np.asarray(directions, np.float64) @ self.axes

    def direction_to_host(self, directions: ArrayLike) -> Floats:
        """Directions (..., 3) in planet axes, such as the sun's, in host axes."""
        return np.asarray(directions, np.float64) @ self.axes.T

    # -- cameras -----------------------------------------------------------------------------------------------------

    def camera(self, view: ArrayLike, projection: ArrayLike) -> Camera:
        """The host's camera as the planet's. CameraError for matrices that are no view or no perspective."""
        turn, place = _view_parts(view)
        matrix = _perspective(projection)
        for row, name in ((0, "width"), (1, "height")):
            if not matrix[row, row] > 0.0:
                raise CameraError(f"HostSpace: projection: mirrored or without {name}: element {row}, {row} is "
                                  f"{matrix[row, row]:g}, expected a positive one")  # fmt: skip
        angles = [
            math.degrees(math.atan((float(matrix[row, 2]) + side) / float(matrix[row, row])))
            for row in (0, 1)
            for side in (-1.0, 1.0)
        ]
        return Camera(
            self.to_planet(place),
            forward=self.direction_to_planet(-turn[2]),
            up=self.direction_to_planet(turn[1]),
            planet=self.planet,
            frustum_deg=angles,
        )

    def depth(
        self, projection: ArrayLike, zero_to_one: bool = False, depth_range: tuple[float, float] = (0.0, 1.0)
    ) -> HostDepth:
        """How the host's depth buffer stores distances with this projection; see HostDepth.of."""
        return HostDepth.of(projection, self.unit_m, zero_to_one, depth_range)

    def matrices(self, state: CameraState, near: float, far: float = math.inf) -> tuple[Floats, Floats]:
        """(view, projection), each (4, 4) f64 for column vectors, of a camera as the renderer uses it
        (`renderer.camera_state(camera)`): for hosts that let the planet's camera lead. near, far: in host units, clip
        depth -1..1; far may be inf."""
        near = check_number("near", near, 1e-30)
        if not far > near:
            raise CameraError(f"HostSpace: far: expected more than near ({near:g}), found {far!r}")
        turn = np.stack([state.right, state.up, -state.forward]) @ self.axes.T
        view = np.eye(4)
        view[:3, :3], view[:3, 3] = turn, -turn @ self.to_host(state.position_m)
        projection = np.zeros((4, 4))
        width, height = state.tan_right - state.tan_left, state.tan_top - state.tan_bottom
        projection[0, [0, 2]] = 2.0 / width, (state.tan_right + state.tan_left) / width
        projection[1, [1, 2]] = 2.0 / height, (state.tan_top + state.tan_bottom) / height
        share = 0.0 if math.isinf(far) else near / far
        projection[2, [2, 3]] = -(1.0 + share) / (1.0 - share), -2.0 * near / (1.0 - share)
        projection[3, 2] = -1.0
        return view, projection

    def __repr__(self) -> str:
        return f"HostSpace(origin_m={self.origin_m.tolist()}, axes={self.axes.tolist()}, unit_m={self.unit_m:g})"


def _matrix(name: str, value: ArrayLike) -> Floats:
    matrix = np.asarray(value, np.float64)
    if matrix.shape == (16,):
        matrix = matrix.reshape(4, 4).T
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise CameraError(
            f"HostSpace: {name}: expected 4 x 4 finite numbers, or 16 in OpenGL's order, found shape {matrix.shape}"
        )
    return matrix


def _perspective(value: ArrayLike) -> Floats:
    matrix = _matrix("projection", value)
    if matrix[2, 3] == -1.0 and matrix[3, 2] != -1.0:
        raise CameraError("HostSpace: projection: it multiplies row vectors; pass its transpose (matrix.T)")
    if not np.allclose(matrix[3] / max(abs(matrix[3, 2]), 1e-30), (0.0, 0.0, -1.0, 0.0), atol=1e-6):
        raise CameraError(
            f"HostSpace: projection: expected a perspective with last row (0, 0, -1, 0), found "
            f"{matrix[3].tolist()}; a planet can't be drawn with a parallel projection"
        )
    if matrix[2, 3] == 0.0:
        raise CameraError("HostSpace: projection: element 2, 3 is 0: its depth tells no distances")
    return matrix / -matrix[3, 2]


def _view_parts(value: ArrayLike) -> tuple[Floats, Floats]:
    """The rotation (3, 3) of a view matrix and the place of its eye (3,)."""
    matrix = _matrix("view", value)
    if not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0), atol=1e-6):
        hint = "; it multiplies row vectors: pass its transpose (matrix.T)" if matrix[3, :3].any() else ""
        raise CameraError(f"HostSpace: view: expected the last row (0, 0, 0, 1), found {matrix[3].tolist()}{hint}")
    turn = _rotation("view", matrix[:3, :3])
    return turn, -turn.T @ matrix[:3, 3]


def _rotation(name: str, matrix: Floats) -> Floats:
    """The rotation nearest to a matrix that should be one."""
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise CameraError(f"HostSpace: {name}: expected 3 x 3 finite numbers, found shape {matrix.shape}")
    error = float(np.abs(matrix @ matrix.T - np.eye(3)).max())
    if error > _TURN_ERROR or np.linalg.det(matrix) < 0.0:
        raise CameraError(
            f"HostSpace: {name}: expected a rotation, found {matrix.tolist()}, which scales, shears or mirrors; put "
            "scale into unit_m"
        )
    left, _, right = np.linalg.svd(matrix)
    return left @ right
