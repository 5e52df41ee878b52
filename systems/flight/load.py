"""Reads scripted paths from TOML (assets/presets/paths.toml), checked by msgspec: unknown keys, types and ranges."""

from __future__ import annotations

import math
import re
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

_UNKNOWN = re.compile("Object contains unknown field `(.*)`")

Latitude = Annotated[float, Meta(ge=-90.0, le=90.0)]
Longitude = Annotated[float, Meta(ge=-360.0, le=360.0)]
Pitch = Annotated[float, Meta(ge=-90.0, le=90.0)]
Field = Annotated[float, Meta(gt=0.0, lt=180.0)]
# Bounds far beyond any flight: they keep nan and inf out.
Angle = Annotated[float, Meta(ge=-1e6, le=1e6)]
Positive = Annotated[float, Meta(gt=0.0, le=1e15)]
NotNegative = Annotated[float, Meta(ge=0.0, le=1e15)]


class _Sun(msgspec.Struct, forbid_unknown_fields=True):
    elevation_deg: Pitch
    azimuth_deg: Angle = 180.0


class _Key(msgspec.Struct, forbid_unknown_fields=True):
    time_s: NotNegative
    altitude_m: Positive
    away_deg: Annotated[float, Meta(ge=0.0, le=180.0)] = 0.0
    bearing_deg: Angle | None = None
    heading_deg: Angle = 0.0
    pitch_deg: Pitch = 0.0
    fov_y_deg: Field = 60.0


class _Common(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    help: str = ""
    planet: str = ""
    latitude_deg: Latitude
    longitude_deg: Longitude
    above: Literal["ground", "sphere"] = "ground"
    smooth_s: NotNegative = 4.0
    clearance_m: NotNegative = 1.0
    sun: _Sun | None = None


class _KeyFrames(_Common, tag_field="kind", tag="keys", kw_only=True):
    keys: Annotated[list[_Key], Meta(min_length=1)]


class _Cruise(_Common, tag_field="kind", tag="cruise", kw_only=True):
    heading_deg: Angle
    speed_m_s: Positive
    altitude_m: Positive
    duration_s: Positive
    pitch_deg: Pitch = 0.0
    fov_y_deg: Field = 60.0


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
    if not isinstance(data["path"], dict):
        raise PresetError(f"{file}: path: expected tables [path.NAME], found {data['path']!r}")
    file = FilePath(file)
    return {name: _build(file, name, _checked(file, name, table)) for name, table in data["path"].items()}


def find_path(name: str, file: FilePath | str = PATHS_FILE) -> Path:
    """One path by name; an unknown one raises PresetError with the nearest names."""
    paths = load_paths(file)
    if name not in paths:
        raise PresetError(f"unknown path {name!r}: {did_you_mean(name, paths, 'paths')} (in {file})")
    return paths[name]


def _checked(file: FilePath, name: str, table: object) -> _KeyFrames | _Cruise:
    try:
        return msgspec.convert(table, _KeyFrames | _Cruise)
    except msgspec.ValidationError as error:
        text, _, where = str(error).partition(" - at `$")  # "... - at `$.keys[0].time_s`", or no place at all
        unknown = _UNKNOWN.match(text)
        if unknown:
            text = f"unknown key {unknown[1]!r}; {did_you_mean(unknown[1], _keys_of(table, where), 'keys')}"
        raise PresetError(f"{file}: path.{name}{where.rstrip('`')}: {text}") from error


def _keys_of(table: object, where: str) -> tuple[str, ...]:
    """The keys that the part of a flight's table at `where` may have."""
    if where.startswith(".keys"):
        return _Key.__struct_fields__
    if where.startswith(".sun"):
        return _Sun.__struct_fields__
    kind = table.get("kind") if isinstance(table, dict) else None
    return (_Cruise if kind == "cruise" else _KeyFrames).__struct_fields__


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
