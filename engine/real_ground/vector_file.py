"""Vector files: GeoJSON (RFC 7946) of water and forests, checked and sorted by what each feature is.

What a feature is says a plain property `kind`, or those of OpenStreetMap. Longitudes and latitudes are WGS84 in
degrees; edges are straight on a map of degrees, as the RFC has it. A ring or a line that jumps across the date line
(where the RFC would have it cut) goes on beyond it.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..user_paths import place_of
from .found import TileError

__all__ = ["DEFAULT_WIDTH_M", "Course", "Patch", "VectorMap", "vector_map", "vector_stamp"]

Floats = NDArray[np.float64]
Rings = tuple[Floats, ...]

DEFAULT_WIDTH_M = {"river": 20.0, "canal": 12.0, "stream": 3.0}
"""Of waterways that don't say theirs."""
_MOST_WIDTH_M = 1e5
_KINDS = {"lake": "lake", "river": "river", "coast": "coast", "sea": "sea", "forest": "forest"}
_OSM = {
    ("natural", "water"): "lake",
    ("natural", "coastline"): "coast",
    ("natural", "sea"): "sea",
    ("natural", "bay"): "sea",
    ("natural", "wood"): "forest",
    ("natural", "scrub"): "forest",
    ("landuse", "forest"): "forest",
    ("waterway", "riverbank"): "bank",
    **{("waterway", name): "river" for name in DEFAULT_WIDTH_M},
}
_AREAS = ("lake", "sea", "bank", "forest")
_TYPES = ("Polygon", "MultiPolygon", "LineString", "MultiLineString", "Point", "MultiPoint", "GeometryCollection")
_SHOWN = 60


@dataclass(frozen=True, eq=False)
class Patch:
    """An area: polygons, each an outer ring and holes (N, 2), longitude and latitude in degrees, closed. level_m: what
    the file says of its water's level, None where it doesn't."""

    polygons: tuple[Rings, ...]
    level_m: float | None = None


@dataclass(frozen=True, eq=False)
class Course:
    """A waterway downstream (N, 2), longitude and latitude in degrees. stated: whether the file says its width."""

    points: Floats
    width_m: float
    stated: bool


@dataclass(eq=False)
class VectorMap:
    """What a file holds. counts: of features by kind; ignored: by why; repaired: rings that were not closed."""

    path: Path
    lakes: list[Patch] = field(default_factory=list)
    banks: list[Patch] = field(default_factory=list)
    seas: list[Patch] = field(default_factory=list)
    islands: list[Patch] = field(default_factory=list)
    forests: list[Patch] = field(default_factory=list)
    rivers: list[Course] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    ignored: Counter[str] = field(default_factory=Counter)
    repaired: int = 0
    vertices: int = 0

    @property
    def watered(self) -> bool:
        """Whether there is any water."""
        return bool(self.lakes or self.banks or self.seas or self.islands or self.rivers)

    def points(self) -> Floats:
        """(N, 2) all that is used."""
        areas = (*self.lakes, *self.banks, *self.seas, *self.islands, *self.forests)
        parts = [ring for area in areas for rings in area.polygons for ring in rings]
        return np.concatenate([np.zeros((0, 2)), *parts, *(course.points for course in self.rivers)])


def vector_stamp(path: str) -> tuple[str, int, int]:
    """What tells whether the file has changed."""
    place = place_of(path)
    try:
        found = os.stat(place)
    except (OSError, ValueError):
        return str(place), 0, -1
    return str(place), found.st_mtime_ns, found.st_size


def vector_map(path: str, what: str = "Terrain.vector_map") -> VectorMap:
    """The file at `path`, read once as long as it stays as it is. TileError says what is wrong with it."""
    return _vector_map(path, vector_stamp(path), what)


@lru_cache(maxsize=2)
def _vector_map(path: str, _stamp: tuple[str, int, int], what: str) -> VectorMap:
    place = place_of(path)
    if not os.path.isfile(place):
        found = "a folder" if os.path.isdir(place) else "nothing"
        raise TileError(f"{what}: {place}: expected a GeoJSON file, found {found} there; correct the path")
    try:
        text = place.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise TileError(f"{what}: {place} can't be read: {error}; expected GeoJSON in UTF-8") from None
    if not text.strip():
        raise TileError(f"{what}: {place} is empty; expected a GeoJSON FeatureCollection: export it again")
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise TileError(
            f"{what}: {place}, line {error.lineno}, column {error.colno}: no JSON ({error.msg}); export it again, or "
            "correct that line"
        ) from None
    except ValueError as error:  # numbers of thousands of digits
        raise TileError(f"{what}: {place}: no JSON ({error}); export it again") from None
    except RecursionError:
        raise TileError(f"{what}: {place} nests too deeply for GeoJSON; export it again") from None
    return _Reader(place, f"{what}: {place}").read(data)


class _Reader:
    def __init__(self, path: Path, where: str) -> None:
        self._where = where
        self._found = VectorMap(path)
        self._coasts: list[Floats] = []

    def read(self, data: Any) -> VectorMap:
        kind = data.get("type") if isinstance(data, dict) else None
        self._check_crs(data)
        if kind == "FeatureCollection":
            features = data.get("features")
            if not isinstance(features, list):
                raise TileError(f"{self._where}: features: expected a list, found {features!r:.{_SHOWN}}; export again")
        elif kind == "Feature":
            features = [data]
        else:
            raise TileError(
                f"{self._where}: type: expected 'FeatureCollection', found {kind!r:.{_SHOWN}}; export it as GeoJSON "
                "(RFC 7946): ogr2ogr -f GeoJSON out.geojson FILE, or osmtogeojson"
            )
        if not features:
            raise TileError(f"{self._where}: holds no feature; export it again, with lakes, rivers or forests")
        for number, feature in enumerate(features):
            self._feature(feature, f"{self._where}: features[{number}]")
        self._close_coasts()
        return self._found

    def _check_crs(self, data: Any) -> None:
        """Of files older than the RFC, which may name another projection."""
        crs = data.get("crs") if isinstance(data, dict) else None
        inner = crs.get("properties") if isinstance(crs, dict) else None
        name = str(inner.get("name", "")) if isinstance(inner, dict) else ""
        if name and not any(known in name for known in ("CRS84", "EPSG::4326", "EPSG:4326")):
            raise TileError(f"{self._where}: crs: {name!r}; expected degrees (WGS84): {_TO_DEGREES}")

    def _feature(self, feature: Any, at: str) -> None:
        if not isinstance(feature, dict) or feature.get("type") != "Feature":
            found = feature.get("type") if isinstance(feature, dict) else feature
            raise TileError(f"{at}: expected type 'Feature', found {found!r:.{_SHOWN}}; export the file again")
        properties = feature.get("properties") or {}
        if not isinstance(properties, dict):
            raise TileError(f"{at}.properties: expected an object, found {properties!r:.{_SHOWN}}; export again")
        geometry = feature.get("geometry")
        if geometry is None:
            self._found.ignored["no geometry"] += 1
            return
        kind, tag = _kind_of(properties)
        parts = list(_parts(geometry, f"{at}.geometry"))
        if kind is None:
            self._found.ignored[tag] += 1
            return
        used, why = False, ""
        for type_, coordinates, where in parts:
            refused = self._part(kind, tag, properties, type_, coordinates, where)
            used, why = used or not refused, refused or why
        if used:
            self._found.counts[kind] += 1
        else:
            self._found.ignored[why or "an empty geometry"] += 1

    def _part(self, kind: str, tag: str, properties: dict[str, Any], type_: str, coordinates: Any, where: str) -> str:
        """Why it is of no use, or ""."""
        if not isinstance(coordinates, list):
            raise TileError(f"{where}.coordinates: expected a list, found {coordinates!r:.{_SHOWN}}; export it again")
        if type_ in ("Point", "MultiPoint"):
            return f"{kind}: a point has no area"
        if type_ in ("LineString", "MultiLineString"):
            lines = _inner(type_ == "LineString", coordinates, f"{where}.coordinates")
            found = [self._positions(line, place) for line, place in lines]
            found = [line for line in found if len(line) > 1]
            if not found:
                return f"{kind}: a line of fewer than two positions"
            return self._lines(kind, tag, properties, found, where)
        polygons = _inner(type_ == "Polygon", coordinates, f"{where}.coordinates")
        rings = [self._polygon(each, place) for each, place in polygons]
        rings = [each for each in rings if each]
        if not rings:
            return f"{kind}: a ring of fewer than four positions"
        return self._areas(kind, properties, tuple(rings), where)

    def _areas(self, kind: str, properties: dict[str, Any], polygons: tuple[Rings, ...], where: str) -> str:
        if kind == "river":
            kind = "bank"
        if kind == "coast":
            self._coasts += [rings[0] for rings in polygons]
            return ""
        if kind == "lake" and str(properties.get("water")) in DEFAULT_WIDTH_M:
            kind = "bank"
        level = _number(properties, "level_m", where, (-1e5, 1e6))
        into = {"lake": self._found.lakes, "bank": self._found.banks, "sea": self._found.seas}
        into.get(kind, self._found.forests).append(Patch(polygons, level))
        return ""

    def _lines(self, kind: str, tag: str, properties: dict[str, Any], lines: list[Floats], where: str) -> str:
        if kind in _AREAS:  # areas that were exported as their outlines
            closed = [line for line in lines if len(line) >= 4 and np.array_equal(line[0], line[-1])]
            if not closed:
                return f"{kind}: a line that doesn't close has no area"
            return self._areas(kind, properties, tuple((line,) for line in closed), where)
        if kind == "coast":
            self._coasts += lines
            return ""
        width = self._width(properties, where)
        stated = width is not None
        width_m = width if width is not None else DEFAULT_WIDTH_M[tag]
        self._found.rivers += [Course(line, width_m, stated) for line in lines]
        return ""

    def _width(self, properties: dict[str, Any], where: str) -> float | None:
        """As stated. Mappers write texts such as '~10' or '3;5' as well: those are left out, and counted."""
        try:
            return _number(properties, "width", where, (0.01, _MOST_WIDTH_M))
        except TileError:
            if "kind" in properties or not isinstance(properties["width"], str):
                raise
            self._found.ignored[f"width={properties['width']:.{_SHOWN}}"] += 1
            return None

    def _polygon(self, rings: Any, where: str) -> Rings:
        if not isinstance(rings, list):
            raise TileError(f"{where}: expected a list of rings, found {rings!r:.{_SHOWN}}; export it again")
        found = []
        for number, ring in enumerate(rings):
            points = self._positions(ring, f"{where}[{number}]")
            if len(points) and not np.array_equal(points[0], points[-1]):
                points = np.concatenate([points, points[:1]])
                self._found.repaired += 1
            if len(points) >= 4:
                found.append(points)
            elif number == 0:
                return ()
        return tuple(found)

    def _positions(self, values: Any, where: str) -> Floats:
        """(N, 2) degrees, going on beyond the date line."""
        if not isinstance(values, list):
            raise TileError(f"{where}: expected a list of positions, found {values!r:.{_SHOWN}}; export it again")
        try:
            found = np.array([(p[0], p[1]) for p in values], dtype=np.float64).reshape(-1, 2)
            bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
        except (TypeError, ValueError, IndexError, KeyError, OverflowError):
            bad = np.array([next((k for k, p in enumerate(values) if not _is_position(p)), 0)])
            found = np.zeros((0, 2))
        if bad.size:
            k = int(bad[0])
            raise TileError(
                f"{where}[{k}]: expected a position [longitude, latitude], found {values[k]!r:.{_SHOWN}}; export it "
                "again"
            )
        out = np.flatnonzero((np.abs(found[:, 0]) > 180.0) | (np.abs(found[:, 1]) > 90.0))
        if out.size:
            k = int(out[0])
            raise TileError(
                f"{where}[{k}]: expected longitude -180 to 180 and latitude -90 to 90, found {found[k].tolist()}; "
                + (f"these look like metres of a projection: {_TO_DEGREES}" if np.abs(found[k]).max() > 360.0 else
                   "longitude comes first (RFC 7946)")
            )  # fmt: skip
        self._found.vertices += len(found)
        jump = np.diff(found[:, 0])
        inside = np.abs(found[:, 0]) < 180.0 - 1e-9  # edges along the map's own border are as long as they look
        across = (np.abs(jump) > 180.0) & (inside[1:] | inside[:-1])
        if across.any():
            found[1:, 0] -= 360.0 * np.cumsum(np.where(across, np.sign(jump), 0.0))
        return found

    def _close_coasts(self) -> None:
        """Coastlines, joined end to end: the land is to their left. Those that close are islands or seas."""
        for line in _joined(self._coasts):
            if len(line) < 4 or not np.array_equal(line[0], line[-1]):
                self._found.ignored["coast: an open coastline says not where the sea ends; add it as natural=sea"] += 1
                continue
            x, y = line.T
            area = float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum())
            (self._found.islands if area > 0.0 else self._found.seas).append(Patch(((line,),)))


_TO_DEGREES = "ogr2ogr -t_srs EPSG:4326 -f GeoJSON out.geojson FILE makes degrees of them"


def _inner(single: bool, coordinates: list[Any], where: str) -> list[tuple[Any, str]]:
    """Coordinates of each line or polygon, and where in the file they are."""
    return [(coordinates, where)] if single else [(each, f"{where}[{k}]") for k, each in enumerate(coordinates)]


def _is_position(value: Any) -> bool:
    try:
        return bool(np.isfinite([float(value[0]), float(value[1])]).all())
    except (TypeError, ValueError, IndexError, KeyError, OverflowError):
        return False


def _kind_of(properties: dict[str, Any]) -> tuple[str | None, str]:
    """What a feature is, and of waterways which; else why it is none."""
    plain = properties.get("kind")
    if isinstance(plain, str) and plain in _KINDS:
        return _KINDS[str(plain)], "river"
    for (key, value), kind in _OSM.items():
        if properties.get(key) == value:
            return kind, value if kind == "river" else "river"
    for key in ("natural", "waterway", "landuse"):
        if key in properties:
            return None, f"{key}={properties[key]}"
    return None, "no kind, natural, waterway or landuse" if plain is None else f"kind={plain}"


def _number(properties: dict[str, Any], name: str, where: str, within: tuple[float, float]) -> float | None:
    """A number, or a text of one with "m" behind it."""
    value = properties.get(name)
    if value is None:
        return None
    try:
        found = float(value.removesuffix("m").strip().replace(",", ".") if isinstance(value, str) else value)
    except (TypeError, ValueError, OverflowError):
        found = float("nan")
    if not within[0] <= found <= within[1]:
        raise TileError(
            f"{where.removesuffix('.geometry')}.properties.{name}: expected metres, {within[0]:g} to {within[1]:g}, "
            f"found {value!r:.{_SHOWN}}; correct or remove it"
        )
    return found


def _parts(geometry: Any, where: str) -> Iterator[tuple[str, Any, str]]:
    """Type, coordinates and place of each simple geometry."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind not in _TYPES:
        raise TileError(
            f"{where}.type: expected {', '.join(_TYPES)}, found {kind!r:.{_SHOWN}}; convert it to one of these"
        )
    if kind != "GeometryCollection":
        yield kind, geometry.get("coordinates"), where
        return
    members = geometry.get("geometries")
    if not isinstance(members, list):
        raise TileError(f"{where}.geometries: expected a list, found {members!r:.{_SHOWN}}; export it again")
    for number, member in enumerate(members):
        yield from _parts(member, f"{where}.geometries[{number}]")


def _joined(lines: list[Floats]) -> list[Floats]:
    """Lines that begin where others end in one, as far as they go."""
    begins: dict[bytes, list[int]] = {}
    for number, line in enumerate(lines):
        begins.setdefault(line[0].tobytes(), []).append(number)
    left, found = set(range(len(lines))), []
    ends = {line[-1].tobytes() for line in lines}
    # Those that nothing leads to first; what is left are rings.
    order = sorted(left, key=lambda k: (lines[k][0].tobytes() in ends, k))
    for first in order:
        if first not in left:
            continue
        left.discard(first)
        parts = [lines[first]]
        while not np.array_equal(parts[0][0], parts[-1][-1]):
            after = next((k for k in begins.get(parts[-1][-1].tobytes(), ()) if k in left), None)
            if after is None:
                break
            left.discard(after)
            parts.append(lines[after][1:])
        found.append(np.concatenate(parts))
    return found
