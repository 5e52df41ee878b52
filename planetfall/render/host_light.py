"""The sun as a host needs it to light its own objects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..camera.arguments import check_moment
from ..camera.camera import Camera
from ..camera.views import View, view
from ..errors import SettingError
from ..scene.companions import bodies
from ..scene.scene import Scene
from ..systems.light import resolve_sun

__all__ = ["sun_direction"]


def sun_direction(scene: Scene, time_s: float = 0.0, camera: Camera | View | None = None) -> NDArray[np.float64]:
    """(3,) f64, unit: towards the sun at time_s, in the axes of the camera's planet: the scene's own, or the companion
    that the camera names. `HostSpace.direction_to_host` turns it into a host's.

    camera: also a View that brings its own sun. SettingError for a time that isn't finite, UnknownNameError for a
    camera over a planet that isn't there.
    """
    if not isinstance(scene, Scene):
        raise SettingError(f"sun_direction: expected a scene, found {scene!r}")
    check_moment(camera if camera is not None else view("orbit"), time_s, None)
    placed = None if camera is None else camera.in_scene(scene)
    over = scene.planet.name if placed is None else placed.planet.name
    body = next(body for body in bodies(scene, time_s) if body.name == over)
    if placed is not None and placed.sun is not None:
        return resolve_sun(placed.sun, body.scene.planet.planet, time_s).direction.copy()
    return body.axes.T @ resolve_sun(scene.sun, scene.planet.planet, time_s).direction
