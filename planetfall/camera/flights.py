"""Scripted flights over a scene: `pf.paths()` names them, `pf.path("descent", scene)` gives cameras over time."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

from ..components import Ocean, Sun
from ..systems.flight import PATHS_FILE, BoundPath, Path, find_path, load_paths
from .arguments import check_scene
from .camera import Camera
from .light import light_of

if TYPE_CHECKING:
    from ..scene.scene import Scene

__all__ = ["ScenePath", "over_scene", "path", "paths", "told_of"]

log = logging.getLogger(__name__)


def paths(file: str | PathLike[str] = PATHS_FILE) -> list[str]:
    """Names of the scripted flights."""
    return sorted(load_paths(str(file)))


def path(name: str, scene: Scene, file: str | PathLike[str] = PATHS_FILE) -> ScenePath:
    """A scripted flight over the ground of a scene's planet, as it is now. PresetError for an unknown name.

    One that was made for another planet is played all the same, with a warning in the log.
    """
    check_scene(scene, "path")
    return over_scene(find_path(name, str(file)), scene)


def over_scene(flight: Path, scene: Scene) -> ScenePath:
    """A flight that was read over the ground of a scene's planet, as it is now."""
    planet = scene.planet
    ocean = planet.get(Ocean)
    if flight.planet and flight.planet not in (scene.preset, scene.name, planet.name):
        log.warning(
            "the flight %r was made for %s: over %s its heights (in m) and places show something else; flights of your "
            "own go into a TOML file (pf.path(name, scene, file), planetfall record --paths)",
            flight.name, flight.planet, scene.name,
        )  # fmt: skip
    bound = flight.over(planet.radius_m, scene.height_field(), None if ocean is None else ocean.sea_level_m)
    return ScenePath(flight.name, bound, light_of(scene))


def told_of(flight: Path) -> dict[str, Any]:
    """All that a flight's file says, as plain data."""
    return {name: value for name, value in dataclasses.asdict(flight).items() if not name.startswith("_")}


class ScenePath:
    """A flight over one planet. `camera_at(time_s)` for 0 to `duration_s`; `sun`, with the irradiance and disc of the
    scene's (None: the scene's own)."""

    def __init__(self, name: str, bound: BoundPath, light: Mapping[str, Any]) -> None:
        self.name = name
        self._bound = bound
        place = bound.path.sun
        self.sun: Sun | None = None
        if place is not None:
            self.sun = Sun(
                elevation_deg=place.elevation_deg,
                azimuth_deg=place.azimuth_deg,
                latitude_deg=place.latitude_deg,
                longitude_deg=place.longitude_deg,
                **light,
            )

    @property
    def help(self) -> str:
        """One line for lists."""
        return self._bound.path.help

    @property
    def keys(self) -> dict[str, Any]:
        """All that its file says, as plain data."""
        return told_of(self._bound.path)

    @property
    def duration_s(self) -> float:
        return self._bound.duration_s

    def camera_at(self, time_s: float) -> Camera:
        """The camera at a time in seconds; times outside of the flight count as its start or end."""
        pose = self._bound.pose_at(time_s)
        return Camera(position_m=pose.position_m, forward=pose.forward, up=pose.up, fov_y_deg=pose.fov_y_deg)

    def times_s(self, count: int) -> list[float]:
        """`count` times spread evenly over the flight, start and end included."""
        return [float(time) for time in self._bound.times_s(count)]

    def __repr__(self) -> str:
        return f"<ScenePath {self.name!r}, {self.duration_s:g} s>"
