"""The sun as a host needs it to light its own objects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .arguments import check_moment
from .camera import Camera
from .errors import SettingError
from .scene import Scene
from .systems.light import resolve_sun
from .views import View, view

__all__ = ["sun_direction"]


def sun_direction(scene: Scene, time_s: float = 0.0, camera: Camera | View | None = None) -> NDArray[np.float64]:
    """(3,) f64, unit: towards the sun in planet axes at time_s. `HostSpace.direction_to_host` turns it into a host's.

    camera: a View that brings its own sun. SettingError for a time that isn't finite.
    """
    if not isinstance(scene, Scene):
        raise SettingError(f"sun_direction: expected a scene, found {scene!r}")
    check_moment(camera if camera is not None else view("orbit"), time_s, None)
    own = None
    if isinstance(camera, View):
        camera.resolve(scene)  # which place it is, and so how high the sun stands, is the scene's to say
        own = camera.sun
    return resolve_sun(own if own is not None else scene.sun, scene.planet.planet, time_s).direction.copy()
