"""Coordinate systems of GeoTIFFs: longitudes and latitudes of their coordinates and back, by PROJ, and which of them
are degrees or web Mercator already, whose samples are used as they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .found import MissingLibrary, TileError
from .geo_keys import KeysError, code_of, length_unit_m, pyproj_or_error, system_of_keys
from .geo_tags import WARP_LINE, GeoHeader, Keys

__all__ = ["System", "height_unit_m", "plain_kind", "system_of"]

Floats = NDArray[np.float64]

_EARTH_M, _NEAR_EARTH = 6378137.0, 0.01
_AS_WGS84 = (4326, 4979, 4258, 4937, 4269, 6318, 4617, 4283, 7844, 4612, 6668, 4674, 4167, 4490, 4171, 4151, 4019)
"""Geographic systems within 2 m of WGS84 that ride on a continent: ETRS89, NAD83, GDA, JGD, SIRGAS and the like. Their
degrees count as WGS84's, as PROJ's own transformations of zero do."""
_FEET = {6360: 1200.0 / 3937.0, 8228: 0.3048}
_MERCATORS = (3857, 900913, 3785)


@dataclass(frozen=True, eq=False)
class System:
    """label: such as EPSG:2056. name: its own. accuracy_m: of the way to WGS84 as PROJ says, None: it says nothing.
    radius_m: of its ellipsoid. geographic: its coordinates are angles."""

    label: str
    name: str
    radius_m: float
    geographic: bool
    unit: float
    transformer: Any

    def place(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Longitude and latitude in degrees of coordinates, infinite where there are none."""
        lon, lat = self.transformer.transform(np.asarray(x) * self.unit, np.asarray(y) * self.unit)
        return np.asarray(lon), np.asarray(lat)

    def model(self, longitude_deg: Floats, latitude_deg: Floats) -> tuple[Floats, Floats]:
        """The inverse of `place`."""
        x, y = self.transformer.transform(longitude_deg, latitude_deg, direction="INVERSE")
        return np.asarray(x) / self.unit, np.asarray(y) / self.unit

    def accuracy_m(self, x: float, y: float) -> float | None:
        """Of longitudes and latitudes there, as PROJ says; None: it says nothing."""
        if isinstance(self.transformer, _Degrees):
            return None
        self.transformer.transform(x * self.unit, y * self.unit)
        try:
            found = float(self.transformer.get_last_used_operation().accuracy)
        except pyproj_or_error().exceptions.ProjError:
            return None
        return found if found >= 0.0 else None


class _Degrees:
    """A transformer of degrees that are those of the map."""

    def transform(self, x: Floats, y: Floats, direction: str = "FORWARD") -> tuple[Floats, Floats]:
        return x, y


_PLAIN = System("degrees", "longitude and latitude", _EARTH_M, True, 1.0, _Degrees())


def plain_kind(keys: Keys) -> str | None:
    """ "degrees" or "mercator" of systems that need no library, None of others."""
    table = dict(keys)
    model = table.get("GTModelTypeGeoKey", 1 if "ProjectedCSTypeGeoKey" in table else 2)
    if model == 1:
        return "mercator" if table.get("ProjectedCSTypeGeoKey") in _MERCATORS else None
    if model != 2 or table.get("GeogAngularUnitsGeoKey", 9102) != 9102:
        return None
    code = code_of(table, "GeographicTypeGeoKey")
    if code:
        return "degrees" if code in _AS_WGS84 else None
    moved = "GeogTOWGS84GeoKey" in table or table.get("GeogPrimeMeridianLongGeoKey", 0) != 0
    named = code_of(table, "GeogGeodeticDatumGeoKey") not in (0, 6326, 6258, 6269)
    return None if moved or named else "degrees"


def system_of(file: Path, header: GeoHeader) -> System:
    """The system of a file. TileError says what is wrong."""
    if plain_kind(header.keys) == "degrees":
        return _PLAIN
    try:
        return _system(header.keys)
    except MissingLibrary as error:
        raise MissingLibrary(f"{file} is in {_said(header.keys)}: it {error}") from None
    except KeysError as error:
        raise TileError(f"{file} {error}: {WARP_LINE}") from error


@lru_cache(maxsize=256)
def _system(keys: Keys) -> System:
    pyproj = pyproj_or_error()
    found, label, unit = system_of_keys(keys)
    radius_m = float(found.ellipsoid.semi_major_metre) if found.ellipsoid is not None else _EARTH_M
    # Of another planet longitude and latitude are its own.
    earth = abs(radius_m / _EARTH_M - 1.0) < _NEAR_EARTH
    try:
        target = pyproj.CRS.from_epsg(4326) if earth else found.geodetic_crs
        transformer = pyproj.Transformer.from_crs(found, target, always_xy=True)
    except pyproj.exceptions.ProjError as error:
        raise KeysError(f"is in a system that PROJ has no way from: {str(error)[:300]}") from error
    if not (found.is_projected or found.is_geographic):
        raise KeysError(f"is in {label}, a {found.type_name}; expected a projection, or longitude and latitude")
    return System(label, str(found.name), radius_m, not found.is_projected, unit, transformer)


def _said(keys: Keys) -> str:
    table = dict(keys)
    code = code_of(table, "ProjectedCSTypeGeoKey") or code_of(table, "GeographicTypeGeoKey")
    return f"EPSG:{code}" if code else "a projection of its own"


def height_unit_m(file: Path, header: GeoHeader) -> float:
    """Metres of the unit of a file's heights: as its band says, its vertical keys, or the vertical part of its system;
    metres where nobody says. TileError for a unit that nobody knows."""
    if header.unit_m is not None:
        return header.unit_m
    table = dict(header.keys)
    try:
        said = length_unit_m(table, "VerticalUnitsGeoKey")
    except KeysError as error:
        raise TileError(f"{file} {error}: {WARP_LINE}") from error
    except MissingLibrary as error:
        raise MissingLibrary(f"{file} has a unit of heights that {error}") from None
    if said is not None:
        return said
    code = code_of(table, "VerticalCSTypeGeoKey")
    return _FEET[code] if code in _FEET else _axis_unit_m(code, code_of(table, "ProjectedCSTypeGeoKey"))


@lru_cache(maxsize=256)
def _axis_unit_m(vertical: int, projected: int) -> float:
    if not (vertical or projected):
        return 1.0
    try:
        pyproj = pyproj_or_error()
    except MissingLibrary:
        return 1.0
    for code, axis in ((vertical, 0), (projected, 2)):
        if code:
            try:
                axes = pyproj.CRS.from_epsg(code).axis_info
            except pyproj.exceptions.CRSError:
                continue
            if len(axes) > axis and axes[axis].direction.lower() in ("up", "down"):
                return float(axes[axis].unit_conversion_factor) or 1.0
    return 1.0
