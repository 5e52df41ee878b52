"""Camera: where a picture is taken from, in double precision, in the axes of a planet."""

from __future__ import annotations

import weakref
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..engine.space import CameraState, orthonormal_axes
from ..errors import CameraError
from ..scene.scene import PlanetHandle, Scene, current_scene
from .place import Place, check_frustum, check_number, check_unit, check_vector, make_place

__all__ = ["Camera"]

Vector = NDArray[np.float64]

_NARROWEST_DEG, _WIDEST_DEG = 1e-3, 179.0


class Camera:
    """A camera over a planet. Immutable as seen from outside; give it to Renderer.render.

    Camera(position_m=(x, y, z), forward=(x, y, z), up=(x, y, z)): planet-centred metres and directions in planet axes.
    Camera.at(latitude_deg, longitude_deg, altitude_m, ...): over a place. fov_y_deg is the whole vertical angle; the
    horizontal one follows the picture's shape. frustum_deg=(left, right, bottom, top), signed angles from forward,
    takes its place for tiles and stereo. ev100: a fixed exposure.
    planet: a name in the scene or scene.planet; None is the scene's default one.

    position_m, forward and up (unit, at right angles) are always there. Those of Camera.at with planet=None belong to
    the scene that the camera was last rendered in; before that to the scene that was loaded last; and before that to
    a planet of Earth's radius. Raises CameraError for NaN, zero vectors, angles out of range.
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
    ) -> None:
        position = check_vector("position_m", position_m)
        # An up along forward has no horizon; then the local vertical decides, or north when that is no help either.
        _, above, ahead = orthonormal_axes(check_unit("forward", forward), check_unit("up", up), position)
        self._place: Place | None = None
        self._pose = (position, ahead, above)
        self._optics(fov_y_deg, frustum_deg, planet, ev100)

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
    ) -> Camera:
        """A camera over a place. heading_deg: 0 north, 90 east (at a pole: longitude looked along); pitch_deg > 0 up.

        above="sphere": altitude_m counts from the reference sphere. above="ground": from the higher of terrain and sea,
        as the scene has them when the camera is rendered.
        """
        camera = cls.__new__(cls)
        camera._place = make_place(latitude_deg, longitude_deg, altitude_m, heading_deg, pitch_deg, above)
        camera._pose = None
        camera._optics(fov_y_deg, frustum_deg, planet, ev100)
        return camera

    def _optics(
        self,
        fov_y_deg: float,
        frustum_deg: Sequence[float] | None,
        planet: str | PlanetHandle | None,
        ev100: float | None = None,
    ) -> None:
        if planet is not None and not isinstance(planet, str | PlanetHandle):
            raise CameraError(f"Camera: planet: expected a name, scene.planet or None, found {planet!r}")
        self.planet = planet
        self._fov_y_deg = check_number("fov_y_deg", fov_y_deg, _NARROWEST_DEG, _WIDEST_DEG)
        self.frustum_deg = None if frustum_deg is None else check_frustum(frustum_deg)
        self._ev100 = None if ev100 is None else check_number("ev100", ev100, -20.0, 30.0)
        self._scene: weakref.ref[Scene] | None = None

    @property
    def fov_y_deg(self) -> float:
        """The whole vertical angle; without meaning where frustum_deg is given."""
        return self._fov_y_deg

    @property
    def ev100(self) -> float | None:
        """A fixed exposure for pictures of this camera; None: as the scene's Exposure says."""
        return self._ev100

    # -- where it is --------------------------------------------------------------------------------------------------

    @property
    def position_m(self) -> Vector:
        """(3,) f64, planet-centred, planet axes."""
        if self._pose is not None:
            return self._pose[0].copy()
        return self._requested().position_m(self._planet_in(self._known_scene()))

    @property
    def forward(self) -> Vector:
        """(3,) f64, unit."""
        return self._axes()[0].copy()

    @property
    def up(self) -> Vector:
        """(3,) f64, unit, at right angles to forward."""
        return self._axes()[1].copy()

    def resolve(self, scene: Scene, aspect: float = 16.0 / 9.0) -> CameraState:
        """The camera in a scene, as engine.space wants it. aspect: width / height of the picture."""
        self._scene = weakref.ref(scene)
        planet = self._planet_in(scene)
        position = self._pose[0] if self._pose is not None else self._requested().position_m(planet)
        forward, up = self._axes()
        if self.frustum_deg is not None:
            return CameraState.frustum_deg(position, forward, up, self.frustum_deg)
        return CameraState.look(position, forward, up, self.fov_y_deg, aspect)

    def _requested(self) -> Place:
        """The place asked for; a named view answers with that of the scene's planet."""
        assert self._place is not None
        return self._place

    def _axes(self) -> tuple[Vector, Vector]:
        return self._pose[1:] if self._pose is not None else self._requested().axes()

    def _known_scene(self) -> Scene | None:
        if isinstance(self.planet, PlanetHandle):
            return self.planet.scene
        scene = self._scene() if self._scene is not None else None
        return scene if scene is not None and not scene.world.closed else current_scene()

    def _planet_in(self, scene: Scene | None) -> PlanetHandle | None:
        if isinstance(self.planet, PlanetHandle):
            if scene is not None and self.planet.scene is not scene:
                raise CameraError(
                    f"the camera belongs to planet {self.planet.name!r} of another scene than the one it is rendered "
                    f"in ({scene.name!r}); make it with planet=None or with a planet of this scene"
                )
            return self.planet
        if scene is None:
            if self.planet is not None:
                raise CameraError(f"the camera is over planet {self.planet!r} of no scene yet; use load_scene first")
            return None
        return scene.planet if self.planet is None else scene.planets[self.planet]

    def __repr__(self) -> str:
        optics = f"fov_y_deg={self.fov_y_deg:g}" if self.frustum_deg is None else f"frustum_deg={self.frustum_deg}"
        if self._place is not None:
            p = self._requested()
            return (
                f"Camera.at({p.latitude_deg:.9g}, {p.longitude_deg:.9g}, {p.altitude_m:.9g}, heading_deg="
                f"{p.heading_deg:g}, pitch_deg={p.pitch_deg:g}, {optics}, above={p.above!r})"
            )
        position, forward, up = ([float(x) for x in v] for v in (self.position_m, self.forward, self.up))
        return f"Camera(position_m={position}, forward={forward}, up={up}, {optics})"
