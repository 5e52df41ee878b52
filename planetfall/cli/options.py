"""Options that several commands share, and the objects made of them."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from ..camera.light import light_of
from ..capture.photos import LARGEST_PX
from ..engine.space import latitude_longitude, orthonormal_axes
from ..errors import CameraError, SettingError, SizeError

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..camera.views import View
    from ..components import Sun
    from ..scene.scene import Scene

CAMERA = Group(
    "Camera", help="Instead of --view. Heights are above the reference sphere, or the ground (--above ground)."
)
SUN = Group("Sun", help="Left out: the view's sun, else the scene's.")

Vector = tuple[float, float, float]

Planet = Annotated[str, Parameter(help="A planet's name, or a scene's file.")]
Size = Annotated[str, Parameter(help="Width x height in pixels.")]
Quality = Annotated[str, Parameter(help="low, medium, high, ultra, reference or paper.")]
Set = Annotated[
    tuple[str, ...],
    Parameter(
        name="--set", consume_multiple=False, negative="", help="Override a knob, e.g. terrain.edge_px=10. Repeatable."
    ),
]


@Parameter(name="*", group=CAMERA, negative="")
@dataclass(frozen=True)
class CameraOptions:
    """Where the camera is and looks."""

    latitude_deg: float | None = None
    "North is positive."
    longitude_deg: float | None = None
    "East is positive."
    altitude_m: float | None = None
    "Height of the camera."
    heading_deg: float = 0.0
    "0 is north, 90 is east."
    pitch_deg: float = 0.0
    "Above the horizon is positive."
    fov_y_deg: float | None = None
    "Vertical field of view; 60 if left out."
    above: Literal["sphere", "ground"] = "sphere"
    "What --altitude-m counts from."
    position_m: Vector | None = None
    "Instead of latitude, longitude and altitude: planet-centred metres, planet axes."
    forward: Vector | None = None
    "With --position-m: where to look."
    up: Vector | None = None
    "With --position-m: what is up; away from the planet if left out."

    def given(self) -> bool:
        """Whether any option was given at all."""
        return self != CameraOptions()

    def camera(self) -> Camera:
        """The camera that the options describe. CameraError when they contradict each other or lack something."""
        from ..camera.camera import Camera

        fov = 60.0 if self.fov_y_deg is None else self.fov_y_deg
        place = {
            "--latitude-deg": self.latitude_deg,
            "--longitude-deg": self.longitude_deg,
            "--altitude-m": self.altitude_m,
        }
        if self.position_m is not None:
            mixed = [name for name, value in place.items() if value is not None]
            if mixed:
                raise CameraError(f"--position-m and {mixed[0]} exclude each other: give one of them")
            x, y, z = self.position_m
            forward = self.forward or (-x, -y, -z)
            up = self.up
            if up is None and any(forward) and any(self.position_m):
                up = tuple(orthonormal_axes(forward, None, self.position_m)[1])
            return Camera(self.position_m, forward, up or self.position_m, fov)
        latitude, longitude, altitude = place.values()
        if latitude is None or longitude is None or altitude is None:
            missing = [name for name, value in place.items() if value is None]
            raise CameraError(f"a camera needs {', '.join(place)}; missing: {', '.join(missing)}")
        return Camera.at(latitude, longitude, altitude, self.heading_deg, self.pitch_deg, fov, self.above)


@Parameter(name="*", group=SUN, negative="")
@dataclass(frozen=True)
class SunOptions:
    """Where the sun is."""

    sun_elevation_deg: float | None = None
    "Above the horizon of the place below."
    sun_azimuth_deg: float = 180.0
    "0 is north, 90 is east."
    sun_latitude_deg: float | None = None
    "The place; the camera's own if left out."
    sun_longitude_deg: float | None = None
    "The place; the camera's own if left out."
    sun_direction: Vector | None = None
    "To the sun, in planet axes."
    sun_epoch_s: float | None = None
    "Time on the planet's calendar; the sun then moves with --time-s."

    def sun(self, scene: Scene, camera: Camera | View) -> Sun | None:
        """The sun that the options describe, like the scene's in everything but its place; None without options."""
        from ..components import Sun

        named = {
            "--sun-elevation-deg": self.sun_elevation_deg,
            "--sun-direction": self.sun_direction,
            "--sun-epoch-s": self.sun_epoch_s,
        }
        given = [name for name, value in named.items() if value is not None]
        if not given:
            return None
        if len(given) > 1:
            raise SettingError(f"{' and '.join(given)} exclude each other: give one of them")
        light = light_of(scene)
        if self.sun_direction is not None:
            return Sun(direction=self.sun_direction, **light)
        if self.sun_epoch_s is not None:
            return Sun(epoch_s=self.sun_epoch_s, **light)
        latitude, longitude = camera_place(scene, camera)
        return Sun(
            elevation_deg=self.sun_elevation_deg,
            azimuth_deg=self.sun_azimuth_deg,
            latitude_deg=latitude if self.sun_latitude_deg is None else self.sun_latitude_deg,
            longitude_deg=longitude if self.sun_longitude_deg is None else self.sun_longitude_deg,
            **light,
        )


def camera_place(scene: Scene, camera: Camera | View) -> tuple[float, float]:
    """Latitude and longitude in degrees below a camera."""
    latitude, longitude = latitude_longitude(camera.resolve(scene, 1.0).position_m)
    return float(latitude), float(longitude)


def parse_size(text: str) -> tuple[int, int]:
    """ "1280x720" -> (1280, 720). SizeError otherwise."""
    found = re.fullmatch(r"\s*(\d+)\s*[xX*,]\s*(\d+)\s*", text)
    if not found:
        raise SizeError(f"--size: expected width x height such as 1280x720, found {text!r}")
    width, height = int(found[1]), int(found[2])
    if width < 1 or height < 1:
        raise SizeError(f"--size: width and height must be at least 1, found {text!r}")
    if max(width, height) > LARGEST_PX:
        raise SizeError(f"--size: expected at most {LARGEST_PX} pixels a side, found {text!r}")
    return width, height


def parse_overrides(pairs: tuple[str, ...]) -> dict[str, Any]:
    """("terrain.edge_px=10", ...) -> {"terrain.edge_px": 10}; values are TOML, anything else is text."""
    overrides: dict[str, Any] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key.strip():
            raise SettingError(f"--set: expected knob=value such as terrain.edge_px=10, found {pair!r}")
        try:
            overrides[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            overrides[key.strip()] = value.strip()
    return overrides
