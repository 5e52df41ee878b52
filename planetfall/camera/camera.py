"""Camera: where a picture is taken from, in double precision, in the axes of a planet."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..engine.space import CameraState
from ..errors import CameraError
from ..scene.scene import PlanetHandle
from .intrinsics import Intrinsics
from .place import Face, Optics, Place, Pose, SceneCamera, check_ev100, check_intrinsics, make_place

if TYPE_CHECKING:
    from ..scene.scene import Scene

__all__ = ["Camera", "PlacedCamera", "PosedCamera"]

Vector = NDArray[np.float64]
Over = str | PlanetHandle | None


class Camera:
    """A camera over a planet. Immutable, and of no scene until it is rendered; give it to Renderer.render.

    Camera(position_m=(x, y, z), forward=(x, y, z), up=(x, y, z)): planet-centred metres and directions in planet axes.
    Camera.at(latitude_deg, longitude_deg, altitude_m, ...): over a place. fov_y_deg is the whole vertical angle; the
    horizontal one follows the picture's shape. frustum_deg=(left, right, bottom, top), signed angles from forward,
    takes its place for tiles and stereo. ev100: a fixed exposure. intrinsics: a calibrated camera in place of either,
    whose size is then the picture's.
    planet: a name in the scene or scene.planet; None is the default one of the scene that it is rendered in.

    Where Camera.at is depends on its planet: position_m is there with planet=scene.planet, and raises without; what it
    is in a scene says camera.resolve(scene).position_m. Raises CameraError for NaN, zero vectors, angles out of range.
    """

    def __init__(
        self,
        position_m: ArrayLike,
        forward: ArrayLike,
        up: ArrayLike,
        fov_y_deg: float = 60.0,
        planet: str | PlanetHandle | None = None,
        *,
        frustum_deg: Sequence[float] | None = None,
        ev100: float | None = None,
        intrinsics: Intrinsics | None = None,
    ) -> None:
        optics = Optics.checked(fov_y_deg, frustum_deg, ev100, intrinsics)
        self._fill(_pose=Pose.checked(position_m, forward, up), _optics=optics, _planet=_checked_planet(planet))

    if TYPE_CHECKING:  # what `_fill` gives it
        _pose: Pose
        _optics: Optics
        _planet: Over

    def _fill(self, **parts: object) -> Self:
        """What a camera consists of: for constructors and for copies that differ, past __setattr__."""
        self.__dict__.update(parts)
        return self

    def _with(self, **parts: object) -> Self:
        """A copy that differs in these."""
        return copy.copy(self)._fill(**parts)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a {type(self).__name__} can't be changed, and {name!r} was assigned; make a new one")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a {type(self).__name__} can't be changed, and {name!r} was deleted; make a new one")

    @classmethod
    def at(
        cls,
        latitude_deg: float,
        longitude_deg: float,
        altitude_m: float,
        heading_deg: float = 0.0,
        pitch_deg: float = 0.0,
        fov_y_deg: float = 60.0,
        above: str = "sphere",
        planet: str | PlanetHandle | None = None,
        *,
        frustum_deg: Sequence[float] | None = None,
        ev100: float | None = None,
        intrinsics: Intrinsics | None = None,
    ) -> Camera:
        """A camera over a place. heading_deg: 0 north, 90 east (at a pole: longitude looked along); pitch_deg > 0 up.

        above="sphere": altitude_m counts from the reference sphere. above="ground": from the higher of terrain and sea,
        as the scene has them when the camera is rendered.
        """
        place = make_place(latitude_deg, longitude_deg, altitude_m, heading_deg, pitch_deg, above)
        return PlacedCamera(place, Optics.checked(fov_y_deg, frustum_deg, ev100, intrinsics), planet)

    @property
    def planet(self) -> str | PlanetHandle | None:
        """The planet as it was given."""
        return self._planet

    @property
    def optics(self) -> Optics:
        """Angles or lens, and exposure."""
        return self._optics

    @property
    def fov_y_deg(self) -> float:
        """The whole vertical angle; without meaning where frustum_deg or intrinsics are given."""
        return self.optics.fov_y_deg

    @property
    def frustum_deg(self) -> tuple[float, float, float, float] | None:
        """(left, right, bottom, top), signed angles from forward, or None."""
        return self.optics.frustum_deg

    @property
    def intrinsics(self) -> Intrinsics | None:
        """The calibrated camera that it was given, or None."""
        return self.optics.intrinsics

    @property
    def ev100(self) -> float | None:
        """A fixed exposure for pictures of this camera; None: as the scene's Exposure says."""
        return self.optics.ev100

    def exposed(self, ev100: float) -> Self:
        """The same camera with a fixed exposure."""
        return self._changed(ev100=check_ev100(ev100))

    def with_intrinsics(self, intrinsics: Intrinsics) -> Self:
        """The same camera with a lens in place of its angles; of a View too: pf.view("near").with_intrinsics(lens)."""
        return self._changed(intrinsics=check_intrinsics(intrinsics), frustum_deg=None)

    def face(self, face: Face) -> Self:
        """The same camera, of whose lens one face is drawn."""
        return self._changed(face=face)

    def _changed(self, **optics: Any) -> Self:
        """A copy with other optics."""
        return self._with(_optics=replace(self._optics, **optics))

    # -- where it is --------------------------------------------------------------------------------------------------

    @property
    def position_m(self) -> Vector:
        """(3,) f64, planet-centred, planet axes. CameraError for one that is told by a place of no known planet."""
        return self._known_pose().position_m.copy()

    @property
    def forward(self) -> Vector:
        """(3,) f64, unit."""
        return self._axes()[0].copy()

    @property
    def up(self) -> Vector:
        """(3,) f64, unit, at right angles to forward."""
        return self._axes()[1].copy()

    def in_scene(self, scene: Scene) -> SceneCamera:
        """What it comes to in a scene: whose planet, the pose over it, and the sun and time that a View brings."""
        return SceneCamera(self.planet_in(scene), self._known_pose(), self.optics)

    def resolve(self, scene: Scene, aspect: float = 16.0 / 9.0) -> CameraState:
        """The camera in a scene, as engine.space wants it. aspect: width / height of the picture."""
        return self.in_scene(scene).state(aspect)

    def planet_in(self, scene: Scene) -> PlanetHandle:
        """The planet of a scene that it is over. CameraError for one of another scene, UnknownNameError for a name."""
        if isinstance(self._planet, PlanetHandle):
            if self._planet.scene is not scene:
                raise CameraError(
                    f"the camera belongs to planet {self._planet.name!r} of another scene than the one it is rendered "
                    f"in ({scene.name!r}); make it with planet=None or with a planet of this scene"
                )
            return self._planet
        return scene.planet if self._planet is None else scene.planets[self._planet]

    def _known_pose(self) -> Pose:
        return self._pose

    def _axes(self) -> tuple[Vector, Vector]:
        pose = self._known_pose()
        return pose.forward, pose.up

    def __repr__(self) -> str:
        position, forward, up = ([float(x) for x in v] for v in (self.position_m, self.forward, self.up))
        return f"Camera(position_m={position}, forward={forward}, up={up}, {self._optics_text()})"

    def _optics_text(self) -> str:
        if self.intrinsics is not None:
            return f"intrinsics={self.intrinsics!r}"
        return f"fov_y_deg={self.fov_y_deg:g}" if self.frustum_deg is None else f"frustum_deg={self.frustum_deg}"


class PosedCamera(Camera):
    """A camera of a pose that is orthonormal already, and stays as it is to the last bit."""

    def __init__(self, pose: Pose, optics: Optics, planet: Over = None) -> None:
        self._fill(_pose=pose, _optics=optics, _planet=_checked_planet(planet))


class PlacedCamera(Camera):
    """What Camera.at makes: a place, which becomes a position over a planet."""

    _maker: ClassVar[str] = "Camera.at"

    def __init__(self, place: Place, optics: Optics, planet: Over = None) -> None:
        self._fill(_place=place, _optics=optics, _planet=_checked_planet(planet))

    if TYPE_CHECKING:
        _place: Place

    @property
    def place(self) -> Place:
        """What it was asked for."""
        return self._place

    def in_scene(self, scene: Scene) -> SceneCamera:
        planet = self.planet_in(scene)
        return SceneCamera(planet, self.place.pose(planet), self.optics, self.place)

    def _known_pose(self) -> Pose:
        if isinstance(self._planet, PlanetHandle):
            return self.in_scene(self._planet.scene).pose
        given = "without planet=" if self._planet is None else f"with planet={self._planet!r}, a name of no scene yet,"
        raise CameraError(
            f"{self._maker} {given} has no position yet; ask camera.resolve(scene).position_m, or make it with "
            "planet=scene.planet"
        )

    def _axes(self) -> tuple[Vector, Vector]:
        return self.place.axes()

    def __repr__(self) -> str:
        p = self.place
        return (
            f"Camera.at({p.latitude_deg:.9g}, {p.longitude_deg:.9g}, {p.altitude_m:.9g}, heading_deg="
            f"{p.heading_deg:g}, pitch_deg={p.pitch_deg:g}, {self._optics_text()}, above={p.above!r})"
        )


def _checked_planet(planet: Over) -> Over:
    if planet is not None and not isinstance(planet, str | PlanetHandle):
        raise CameraError(f"Camera: planet: expected a name, scene.planet or None, found {planet!r}")
    return planet
