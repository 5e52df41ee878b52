"""Reads scripted paths from TOML (assets/presets/paths.toml), checked by msgspec: unknown keys, types and ranges."""

from __future__ import annotations

import math
from pathlib import Path as FilePath
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ...engine.settings.check import PresetError
from ...engine.settings.presets import read_toml
from ...engine.settings.suggest import did_you_mean
from ...engine.space import direction, heading_pitch_axes, latitude_longitude
from .path import CruisePath, KeyFrame, KeyFramePath, Path, PathSun
from .rotation import exp_map

# The assets folder lies beside systems/, in a checkout and in an installed wheel.
PATHS_FILE = FilePath(__file__).resolve().parents[2] / "assets" / "presets" / "paths.toml"

Latitude = Annotated[float, Meta(ge=-90.0, le=90.0)]
Longitude = Annotated[float, Meta(ge=-360.0, le=360.0)]
Pitch = Annotated[float, Meta(ge=-90.0, le=90.0)]
Field = Annotated[float, Meta(gt=0.0, lt=180.0)]
Positive = Annotated[float, Meta(gt=0.0)]


class _Sun(msgspec.Struct, forbid_unknown_fields=True):
    elevation_deg: Pitch
    azimuth_deg: float = 180.0


class _Key(msgspec.Struct, forbid_unknown_fields=True):
    time_s: Annotated[float, Meta(ge=0.0)]
    altitude_m: Positive
    away_deg: Annotated[float, Meta(ge=0.0, le=180.0)] = 0.0
    bearing_deg: float | None = None
    heading_deg: float = 0.0
    pitch_deg: Pitch = 0.0
    fov_y_deg: Field = 60.0


class _Common(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    help: str = ""
    planet: str = ""
    latitude_deg: Latitude
    longitude_deg: Longitude
    above: Literal["ground", "sphere"] = "ground"
    smooth_s: Annotated[float, Meta(ge=0.0)] = 4.0
    clearance_m: Annotated[float, Meta(ge=0.0)] = 1.0
    sun: _Sun | None = None


class _KeyFrames(_Common, tag_field="kind", tag="keys", kw_only=True):
    keys: Annotated[list[_Key], Meta(min_length=1)]


class _Cruise(_Common, tag_field="kind", tag="cruise", kw_only=True):
    heading_deg: float
    speed_m_s: Positive
    altitude_m: Positive
    duration_s: Positive
    pitch_deg: Pitch = 0.0
    fov_y_deg: Field = 60.0


class _File(msgspec.Struct, forbid_unknown_fields=True):
    path: dict[str, _KeyFrames | _Cruise]


def load_paths(file: FilePath | str = PATHS_FILE) -> dict[str, Path]:
    """All paths of a TOML file by name. Raises PresetError naming file, key, expected and found."""
    data = read_toml(file)
    stray = next((key for key in data if key != "path"), None)
    if stray is not None or "path" not in data:
        found = "nothing of the kind" if stray is None else repr(stray)
        raise PresetError(
            f"{file}: expected flights, tables [path.NAME] as in {PATHS_FILE}, and no other tables, found {found}. "
            "A scene file is no flight: it goes where a planet's name does"
        )
    try:
        checked = msgspec.convert(data, _File)
    except msgspec.ValidationError as error:
        raise PresetError(f"{file}: {_plain(str(error))}") from error
    file = FilePath(file)
    return {name: _build(file, name, entry) for name, entry in checked.path.items()}


def find_path(name: str, file: FilePath | str = PATHS_FILE) -> Path:
    """One path by name; an unknown one raises PresetError with the nearest names."""
    paths = load_paths(file)
    if name not in paths:
        raise PresetError(f"unknown path {name!r}: {did_you_mean(name, paths, 'paths')} (in {file})")
    return paths[name]


def _build(file: FilePath, name: str, entry: _KeyFrames | _Cruise) -> Path:
    sun = None
    if entry.sun is not None:
        sun = PathSun(entry.sun.elevation_deg, entry.sun.azimuth_deg, entry.latitude_deg, entry.longitude_deg)
    if isinstance(entry, _Cruise):
        return CruisePath(
            name, entry.help, entry.planet, entry.above, entry.smooth_s, entry.clearance_m, sun,
            latitude_deg=entry.latitude_deg, longitude_deg=entry.longitude_deg, heading_deg=entry.heading_deg,
            speed_m_s=entry.speed_m_s, altitude_m=entry.altitude_m, pitch_deg=entry.pitch_deg,
            fov_y_deg=entry.fov_y_deg, lasts_s=entry.duration_s,
        )  # fmt: skip
    end = direction(entry.latitude_deg, entry.longitude_deg)
    keys = []
    for key in entry.keys:
        bearing = key.heading_deg + 180.0 if key.bearing_deg is None else key.bearing_deg
        along = heading_pitch_axes(end, bearing, 0.0)[0]
        latitude, longitude = latitude_longitude(exp_map(end, along * math.radians(key.away_deg))[None, :])
        keys.append(
            KeyFrame(
                key.time_s, float(latitude[0]), float(longitude[0]), key.altitude_m,
                key.heading_deg, key.pitch_deg, key.fov_y_deg,
            )
        )  # fmt: skip
    try:
        return KeyFramePath(
            name, entry.help, entry.planet, entry.above, entry.smooth_s, entry.clearance_m, sun, keys=tuple(keys)
        )
    except ValueError as error:
        raise PresetError(f"{file}: path.{name}.keys: {error}") from error


def _plain(message: str) -> str:
    """msgspec says "... - at `$.path.descent`"; put the key first, as everywhere else."""
    text, _, where = message.rpartition(" - at ")
    return f"{where.strip('`').removeprefix('$.')}: {text}" if text else message
