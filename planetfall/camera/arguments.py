"""What callers hand to a renderer, checked before any work is done."""

from __future__ import annotations

import math
import operator
from typing import Any

from ..components import Sun
from ..errors import CameraError, SceneError, SettingError, SizeError
from .camera import Camera
from .views import View

__all__ = ["check_moment", "check_scene", "check_size"]


def check_moment(camera: Any, time_s: Any, sun: Any) -> None:
    """Raises CameraError or SettingError for what a frame can't be rendered of."""
    if not isinstance(camera, (Camera, View)):
        raise CameraError(
            f"camera must be a pf.Camera or a pf.View, found {type(camera).__name__}; pf.view('orbit') is one"
        )
    if time_s is not None and not math.isfinite(time_s):
        raise SettingError(f"time_s must be a finite number of seconds, found {time_s!r}")
    if sun is not None and not isinstance(sun, Sun):
        raise SettingError(
            f"sun must be a pf.Sun, found {sun!r}; write pf.Sun(direction=(x, y, z)) or pf.Sun(elevation_deg=..., ...)"
        )


def check_scene(scene: Any, where: str) -> None:
    """Raises SceneError for what isn't a scene, most often a planet's name. where: what was called."""
    if isinstance(scene, str) or not hasattr(scene, "planet"):
        raise SceneError(f"{where}: expected a scene such as pf.load_scene('earth'), found {scene!r}")


def check_size(size: Any, limit: int | None) -> None:
    """Raises SizeError for anything but (width, height) in whole pixels, from 1 to the GPU's limit if that is known."""
    try:
        width, height = (operator.index(n) for n in size)
    except (TypeError, ValueError):
        raise SizeError(f"size must be (width, height) in whole pixels, found {size!r}") from None
    if width < 1 or height < 1:
        raise SizeError(
            f"a picture of {width} x {height} pixels has nothing in it: width and height must be at least 1"
        )
    if limit is not None and max(width, height) > limit:
        raise SizeError(
            f"a picture of {width} x {height} pixels is beyond this GPU's limit of {limit} a side; render tiles with"
            " Camera(frustum_deg=...) instead"
        )
