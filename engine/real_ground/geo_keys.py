"""From the GeoKeys of a GeoTIFF to a coordinate system of pyproj: by its EPSG code, by a text (WKT or PROJ), or by a
projection and its parameters.

Names and parameters of projections are those of OGC GeoTIFF 1.1 (19-008r4), annex C, and which key each writer uses for
them is as GDAL reads it. Parameters go to PROJ as its own strings, and the base (datum, ellipsoid, prime meridian)
comes from the keys of the geographic system.
"""

from __future__ import annotations

import math
from functools import lru_cache
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .found import MAPS, MissingLibrary

if TYPE_CHECKING:
    from pyproj import CRS

__all__ = ["KeysError", "Table", "code_of", "length_unit_m", "pyproj_or_error", "system_of_keys"]

Table = dict[str, Any]

_LENGTHS = {9001: 1.0, 9002: 0.3048, 9003: 1200.0 / 3937.0, 9036: 1000.0}
_ANGLES = {9101: 180.0 / math.pi, 9102: 1.0, 9103: 1.0 / 60.0, 9104: 1.0 / 3600.0, 9105: 0.9, 9106: 0.9}
_PROJECTIONS = {
    1: "tmerc", 3: "omerc", 7: "merc", 8: "lcc", 9: "lcc", 10: "laea", 11: "aea", 12: "aeqd", 13: "eqdc", 14: "stere",
    15: "stere", 16: "sterea", 17: "eqc", 18: "cass", 19: "gnom", 20: "mill", 21: "ortho", 22: "poly", 23: "robin",
    24: "sinu", 25: "vandg", 26: "nzmg", 28: "cea",
}  # fmt: skip
"""PROJ's names of those of ProjCoordTransGeoKey."""
_LATITUDES = ("NatOriginLat", "FalseOriginLat", "CenterLat")
_LONGITUDES = ("NatOriginLong", "FalseOriginLong", "CenterLong", "StraightVertPoleLong")
_EASTINGS = ("FalseEasting", "FalseOriginEasting", "CenterEasting")
_NORTHINGS = ("FalseNorthing", "FalseOriginNorthing", "CenterNorthing")
_SCALES = ("ScaleAtNatOrigin", "ScaleAtCenter")


class KeysError(ValueError):
    """What is wrong with keys, as the end of a sentence about a file."""


def pyproj_or_error() -> ModuleType:
    """The module. MissingLibrary without it."""
    try:
        return import_module("pyproj")
    except ImportError:
        raise MissingLibrary(f"needs pyproj to be placed on the planet: {MAPS}") from None


def code_of(keys: Table, name: str) -> int:
    """The EPSG code of a key; 0: there is none, it is user-defined, or no number."""
    value = keys.get(name, 0)
    return value if isinstance(value, int) and 0 < value < 65535 and value != 32767 else 0


def length_unit_m(keys: Table, name: str, size: str | None = None) -> float | None:
    """Metres of the unit that a key names, None where it doesn't. KeysError for one that nobody knows."""
    code = keys.get(name, 0)
    if code == 32767 and size is not None:
        metres = keys.get(size)
        if isinstance(metres, (int, float)) and 0.0 < metres < math.inf:
            return float(metres)
        raise KeysError(f"has {name} 32767 and {size} {metres!r}; expected metres of a unit above 0")
    if not code or code == 32767:
        return None
    return _LENGTHS[code] if code in _LENGTHS else _unit(code, "linear", name)


def _angle_unit_deg(keys: Table) -> float:
    """Degrees of the unit of angles."""
    code = keys.get("GeogAngularUnitsGeoKey", 9102)
    size = keys.get("GeogAngularUnitsSizeGeoKey")
    if code == 32767 and isinstance(size, (int, float)) and size > 0.0:
        return math.degrees(size)
    return _ANGLES[code] if code in _ANGLES else math.degrees(_unit(code, "angular", "GeogAngularUnitsGeoKey"))


def _unit(code: Any, category: str, name: str) -> float:
    pyproj_or_error()
    for unit in import_module("pyproj.database").get_units_map(auth_name="EPSG", category=category).values():
        if unit.code == str(code):
            return float(unit.conv_factor)
    raise KeysError(f"has the unit {code} in {name}; expected an EPSG code such as 9001 (metre) or 9102 (degree)")


@lru_cache(maxsize=256)
def system_of_keys(keys: tuple[tuple[str, object], ...]) -> tuple[CRS, str, float]:
    """A CRS of pyproj, what to call it, and units of the file's coordinates in those of the CRS. KeysError says what is
    wrong."""
    pyproj = pyproj_or_error()
    table: dict[str, Any] = dict(keys)
    model = table.get("GTModelTypeGeoKey", 1 if "ProjectedCSTypeGeoKey" in table else 2)
    if model not in (1, 2):
        raise KeysError(f"has GTModelTypeGeoKey {model}; expected 1 (a projection) or 2 (longitude and latitude)")
    try:
        return _projected(pyproj, table) if model == 1 else _geographic(pyproj, table)
    except (pyproj.exceptions.ProjError, TypeError) as error:
        raise KeysError(f"is in a system that PROJ can't make: {str(error)[:300]}") from error


def _projected(pyproj: ModuleType, keys: Table) -> tuple[Any, str, float]:
    code = code_of(keys, "ProjectedCSTypeGeoKey")
    unit_m = length_unit_m(keys, "ProjLinearUnitsGeoKey", "ProjLinearUnitSizeGeoKey")
    if code:
        found, label = _by_code(pyproj, code)
        own_m = float(found.axis_info[0].unit_conversion_factor) or 1.0
        # A unit of its own goes before that of the code.
        return found, label, 1.0 if unit_m is None else unit_m / own_m
    found = _by_text(pyproj, keys)
    if found is not None:
        return found, _name(found), 1.0
    base = _base(pyproj, keys)
    method = keys.get("ProjCoordTransGeoKey", 0)
    unit_m = 1.0 if unit_m is None else unit_m
    if method in _PROJECTIONS:
        conversion = pyproj.CRS.from_proj4(_proj_text(keys, int(method), unit_m)).coordinate_operation
    elif code_of(keys, "ProjectionGeoKey"):
        conversion = pyproj.crs.CoordinateOperation.from_epsg(code_of(keys, "ProjectionGeoKey"))
    else:
        found = _by_name(pyproj, keys)
        if found is not None:
            return found, _name(found), 1.0
        raise KeysError(
            f"has a projection that isn't known (ProjectedCSTypeGeoKey {keys.get('ProjectedCSTypeGeoKey')}, "
            f"ProjCoordTransGeoKey {method}); expected an EPSG code, or one of {', '.join(map(str, _PROJECTIONS))}"
        )
    name = _words(keys, "PCSCitationGeoKey", "GTCitationGeoKey") or "user-defined"
    found = pyproj.crs.ProjectedCRS(conversion=conversion, name=name, geodetic_crs=base)
    shift = _to_wgs84(pyproj, keys, found)
    return shift, name, unit_m


def _geographic(pyproj: ModuleType, keys: Table) -> tuple[Any, str, float]:
    code = code_of(keys, "GeographicTypeGeoKey")
    if code:
        return *_by_code(pyproj, code), 1.0
    found = _by_text(pyproj, keys)
    if found is not None:
        return found, _name(found), 1.0
    base = _base(pyproj, keys)
    return _to_wgs84(pyproj, keys, base), _words(keys, "GeogCitationGeoKey") or "user-defined", _angle_unit_deg(keys)


def _by_code(pyproj: ModuleType, code: int) -> tuple[Any, str]:
    for authority in ("EPSG", "ESRI"):
        try:
            return pyproj.CRS.from_authority(authority, code), f"{authority}:{code}"
        except pyproj.exceptions.CRSError:
            continue
    raise KeysError(f"is in the projection EPSG:{code}, which PROJ {pyproj.proj_version_str} doesn't know")


def _by_text(pyproj: ModuleType, keys: Table) -> Any:
    """Of a whole system that is written out as WKT or as PROJ's string."""
    for name in ("PCSCitationGeoKey", "GTCitationGeoKey", "GeogCitationGeoKey"):
        text = str(keys.get(name, ""))
        text = text[text.find("= ") + 2 :] if text.startswith("ESRI PE String") else text
        text = text.strip("| \x00")
        if text.startswith(("PROJCS[", "PROJCRS[", "GEOGCS[", "GEOGCRS[", "BOUNDCRS[", "COMPD_CS[", "+proj=")):
            return pyproj.CRS.from_user_input(text)
    return None


def _by_name(pyproj: ModuleType, keys: Table) -> Any:
    for name in ("PCSCitationGeoKey", "GTCitationGeoKey"):
        for part in str(keys.get(name, "")).split("|"):
            text = part.strip().removeprefix("PCS Name = ")
            try:
                found = pyproj.CRS.from_user_input(text) if len(text) > 6 else None
            except pyproj.exceptions.CRSError:
                continue
            if found is not None and found.name.lower() == text.lower() and found.is_projected:
                return found
    return None


def _name(system: Any) -> str:
    authority = system.to_authority()
    return ":".join(authority) if authority else str(system.name)


def _words(keys: Table, *names: str) -> str:
    """The first line of the first of these texts that there is."""
    for name in names:
        text = str(keys.get(name, "")).split("|")[0].strip()
        if text:
            return text[:60]
    return ""


def _number(keys: Table, names: tuple[str, ...]) -> float | None:
    for name in names:
        value = keys.get(f"Proj{name}GeoKey")
        if isinstance(value, (int, float)) and math.isfinite(value):
            return float(value)
    return None


def _proj_text(keys: Table, method: int, unit_m: float) -> str:
    """PROJ's string of a projection. Lengths are in metres there."""
    angle = _angle_unit_deg(keys)
    words = {"proj": _PROJECTIONS[method]}

    def put(name: str, keys_of: tuple[str, ...], factor: float, needed: bool = False) -> float | None:
        value = _number(keys, keys_of)
        if value is None and needed:
            raise KeysError(f"has a projection ({words['proj']}) without Proj{keys_of[0]}GeoKey")
        if value is not None:
            words[name] = repr(value * factor)
        return value

    put("x_0", _EASTINGS, unit_m)
    put("y_0", _NORTHINGS, unit_m)
    put("lon_0", _LONGITUDES, angle)
    latitude = put("lat_0", _LATITUDES, angle)
    if method in (8, 11, 13):  # cones through two parallels
        put("lat_1", ("StdParallel1",), angle, True)
        put("lat_2", ("StdParallel2",), angle, True)
    elif method == 9:
        words["lat_1"] = repr((latitude or 0.0) * angle)
        put("k_0", _SCALES, 1.0)
    elif method in (7, 17, 28):
        if put("lat_ts", ("StdParallel1",), angle) is None and method == 7:
            put("k_0", _SCALES, 1.0)
        if method != 17:
            words.pop("lat_0", None)
    elif method == 15:
        if latitude is None:
            raise KeysError("has a polar projection without ProjNatOriginLatGeoKey")
        words["lat_0"] = repr(math.copysign(90.0, latitude))
        if abs(latitude * angle) < 90.0 - 1e-9:
            words["lat_ts"] = repr(latitude * angle)
        else:
            put("k_0", _SCALES, 1.0)
        put("lon_0", ("StraightVertPoleLong", "NatOriginLong"), angle)
    elif method == 3:
        words["lonc"] = words.pop("lon_0", "0.0")
        put("alpha", ("AzimuthAngle",), angle, True)
        put("gamma", ("RectifiedGridAngle",), angle)
        put("k_0", _SCALES, 1.0)
        words["no_uoff"] = ""
    elif method in (1, 14, 16):
        put("k_0", _SCALES, 1.0)
    return " ".join(f"+{k}={v}" if v else f"+{k}" for k, v in words.items()) + " +ellps=WGS84 +units=m +type=crs"


def _base(pyproj: ModuleType, keys: Table) -> Any:
    """The geographic system below a projection."""
    crs = pyproj.crs
    code = code_of(keys, "GeographicTypeGeoKey")
    if code:
        return crs.CRS.from_epsg(code)
    datum = code_of(keys, "GeogGeodeticDatumGeoKey")
    if datum:
        return crs.GeographicCRS(datum=crs.Datum.from_epsg(datum))
    ellipsoid = _ellipsoid(pyproj, keys)
    if ellipsoid is None:
        return crs.CRS.from_epsg(4326)
    meridian = keys.get("GeogPrimeMeridianLongGeoKey", 0.0)
    code = code_of(keys, "GeogPrimeMeridianGeoKey")
    if code and code != 8901:
        prime = crs.PrimeMeridian.from_epsg(code)
    elif isinstance(meridian, (int, float)) and meridian:
        prime = crs.datum.CustomPrimeMeridian(longitude=float(meridian) * _angle_unit_deg(keys))
    else:
        prime = crs.PrimeMeridian.from_epsg(8901)
    return crs.GeographicCRS(datum=crs.datum.CustomDatum(ellipsoid=ellipsoid, prime_meridian=prime))


def _ellipsoid(pyproj: ModuleType, keys: Table) -> Any:
    """None where keys say none."""
    code = code_of(keys, "GeogEllipsoidGeoKey")
    if code:
        return pyproj.crs.Ellipsoid.from_epsg(code)
    major, minor = keys.get("GeogSemiMajorAxisGeoKey"), keys.get("GeogSemiMinorAxisGeoKey")
    flat = keys.get("GeogInvFlatteningGeoKey")
    if not isinstance(major, (int, float)):
        return None
    if not 1e5 < major < 1e8:
        raise KeysError(f"has a planet of radius {major:g} m (GeogSemiMajorAxisGeoKey); expected 1e5 to 1e8 m")
    if isinstance(flat, (int, float)) and flat > 1.0:
        return pyproj.crs.datum.CustomEllipsoid(semi_major_axis=float(major), inverse_flattening=float(flat))
    if isinstance(minor, (int, float)) and 0.5 * major < minor < major:
        return pyproj.crs.datum.CustomEllipsoid(semi_major_axis=float(major), semi_minor_axis=float(minor))
    return pyproj.crs.datum.CustomEllipsoid(radius=float(major))


def _to_wgs84(pyproj: ModuleType, keys: Table, system: Any) -> Any:
    """The system, bound to WGS84 where keys say how its datum lies there."""
    shift = keys.get("GeogTOWGS84GeoKey")
    if not isinstance(shift, tuple) or len(shift) not in (3, 7):
        return system
    crs = pyproj.crs
    turned = crs.coordinate_operation.ToWGS84Transformation(system.geodetic_crs, *shift)
    return crs.BoundCRS(source_crs=system, target_crs=crs.CRS.from_epsg(4326), transformation=turned)
