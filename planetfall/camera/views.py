"""Named views: the camera, sun, time and exposure that tests, benches and the gallery share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from ..components import Planet, Sun, Terrain, Vec3, knob
from ..engine.settings import PresetError, SettingError, check_value, did_you_mean, read_toml, rules_of
from ..errors import UnknownNameError
from ..scene.file import describe, planets
from ..scene.kinds import PLANET_KINDS, PRESETS
from ..scene.scene import PlanetHandle, Scene
from .camera import Camera, PlacedCamera
from .light import light_of
from .place import Optics, Place, SceneCamera, make_place

__all__ = ["View", "view", "views"]

VIEWS_FILE = PRESETS / "views.toml"
_EARTH_RADIUS_M = 6.371e6
# What a view may need of a planet: the components there are, and those that the file looks forward to.
KNOWN_TABLES = (*PLANET_KINDS, "clouds", "atmosphere", "rivers")
_COMPANION = "companions."
"""And the companions of a scene: "companions.moon"."""


@dataclass
class _Row:
    """One view over one planet, as the file says it."""

    about: str = knob("")
    latitude_deg: float = knob(0.0, -90.0, 90.0, "deg")
    longitude_deg: float = knob(0.0, -360.0, 360.0, "deg")
    altitude_m: float = knob(2.0, -1e5, 1e10, "m")
    above: str = knob("sphere", choices=("sphere", "ground"))
    over: str = knob("", help="The companion that the place is on; the scene's own planet if left out")
    scales: bool = knob(False, help="altitude_m is for Earth's radius and grows with that of the planet")
    heading_deg: float = knob(0.0, -360.0, 360.0, "deg")
    pitch_deg: float = knob(0.0, -90.0, 90.0, "deg")
    fov_y_deg: float = knob(60.0, 1.0, 170.0, "deg")
    sun_direction: Vec3 | None = knob(None, nonzero=True, excludes=("sun_elevation_deg",))  # noqa: RUF009
    sun_elevation_deg: float | None = knob(None, -90.0, 90.0, "deg", excludes=("sun_direction",))
    sun_azimuth_deg: float = knob(180.0, -360.0, 360.0, "deg")
    time_s: float = knob(0.0, 0.0, 1e9, "s")
    ev100: float = knob(14.5, -20.0, 30.0, "EV")
    min_radius_m: float = knob(0.0, 0.0, 1e8, "m", "Makes no sense over smaller planets")
    printed_place: Vec3 | None = knob(  # noqa: RUF009
        None, help="On the ground that the printed grid draws: latitude, longitude and heading in place of those here"
    )

    def place(self, radius_m: float) -> Place:
        altitude = self.altitude_m * (radius_m / _EARTH_RADIUS_M if self.scales else 1.0)
        return make_place(self.latitude_deg, self.longitude_deg, altitude, self.heading_deg, self.pitch_deg, self.above)

    def place_on_printed_ground(self, radius_m: float) -> Place | None:
        """If it has one of its own."""
        if self.printed_place is None:
            return None
        latitude, longitude, heading = self.printed_place
        return replace(self.place(radius_m), latitude_deg=latitude, longitude_deg=longitude, heading_deg=heading)

    def optics(self, changes: Mapping[str, Any]) -> Optics:
        """With a fixed exposure, the view's own if changes have none, so that pictures of it can be compared."""
        return replace(Optics(self.fov_y_deg, None, self.ev100), **changes)

    def sun(self, scene: Scene | None) -> Sun | None:
        """The view's own, in the light of a scene's."""
        if self.sun_direction is None and self.sun_elevation_deg is None:
            return None
        light = {} if scene is None else light_of(scene)
        if self.sun_direction is not None:
            return Sun(direction=self.sun_direction, **light)
        return Sun(
            elevation_deg=self.sun_elevation_deg,
            azimuth_deg=self.sun_azimuth_deg,
            latitude_deg=self.latitude_deg,
            longitude_deg=self.longitude_deg,
            **light,
        )


@dataclass(frozen=True)
class _Entry:
    """A view: its row, rows for single planets, and the tables a planet has to have."""

    row: _Row
    over: Mapping[str, _Row]
    needs: tuple[str, ...]

    def for_planet(self, preset: str | None) -> _Row:
        return self.over.get(preset or "", self.row)

    def missing(self, preset: str | None, has: Mapping[str, Any], radius_m: float) -> str | None:
        """Why the view makes no sense over a planet, or None."""
        lacking = [table for table in self.needs if table not in has]
        if lacking:
            return f"it needs {' and '.join(lacking)}"
        least = self.for_planet(preset).min_radius_m
        return f"it needs a radius of at least {least:g} m" if radius_m < least else None


class View(PlacedCamera):
    """A named view: a Camera with a sun, a time and an exposure.

    Which place it is depends on the planet: planet=None (the default) takes the place that the file has for the preset
    of the scene it is rendered in. Until then position_m raises CameraError, and its own sun, time, angle and exposure
    are those that the file has for planets without any of their own; `in_scene(scene)` gives those over a scene. sun
    is None where the scene's own sun shines; its irradiance is the scene's.
    """

    _maker: ClassVar[str] = "pf.view"

    if TYPE_CHECKING:  # what `_fill` gives it
        name: str
        _entry: _Entry
        _preset: str | None
        _changes: Mapping[str, Any]

    def __init__(self, name: str, entry: _Entry, planet: str | PlanetHandle | None = None) -> None:
        # A preset's name chooses the place; the picture is then taken in whatever scene the view is rendered in.
        preset, over = (planet, None) if isinstance(planet, str) else (None, planet)
        self._fill(name=name, _entry=entry, _preset=preset, _planet=over, _changes={})

    def _changed(self, **optics: Any) -> Self:
        return self._with(_changes={**self._changes, **optics})

    def _scene(self) -> Scene | None:
        return self._planet.scene if isinstance(self._planet, PlanetHandle) else None

    def _row_in(self, scene: Scene | None) -> _Row:
        return self._entry.for_planet(self._preset or (None if scene is None else scene.preset))

    def planet_in(self, scene: Scene) -> PlanetHandle:
        planet, over = super().planet_in(scene), self._entry.row.over
        return scene.planets[over] if over else planet

    def in_scene(self, scene: Scene) -> SceneCamera:
        planet, row = self.planet_in(scene), self._row_in(scene)
        place = row.place(planet.radius_m)
        printed = row.place_on_printed_ground(planet.radius_m)
        sun, optics = row.sun(scene), row.optics(self._changes)
        return SceneCamera(planet, place.pose(planet), optics, place, sun, row.time_s, printed)

    @property
    def place(self) -> Place:
        scene = self._scene()
        return self._row_in(scene).place(_EARTH_RADIUS_M if scene is None else self.planet_in(scene).radius_m)

    @property
    def optics(self) -> Optics:
        return self._row_in(self._scene()).optics(self._changes)

    @property
    def ev100(self) -> float:
        """The fixed exposure, so that pictures of it can be compared."""
        return self._changes.get("ev100", self._row_in(self._scene()).ev100)

    @property
    def about(self) -> str:
        """One sentence."""
        return self._row_in(self._scene()).about

    @property
    def camera(self) -> Camera:
        """The camera alone; a View is one already, so this is the view itself."""
        return self

    @property
    def sun(self) -> Sun | None:
        """The view's own sun, with the irradiance and disc of the scene's; None: as the scene has it."""
        scene = self._scene()
        return self._row_in(scene).sun(scene)

    @property
    def time_s(self) -> float:
        """Seconds on the clock of water and weather."""
        return self._row_in(self._scene()).time_s

    def __repr__(self) -> str:
        return f"<View {self.name!r}: {super().__repr__()}>"


def views(planet: str | PlanetHandle | Scene | None = None) -> list[str]:
    """Names of the views, in the order of the file; with a planet those that make sense over it."""
    entries = view_entries(VIEWS_FILE)
    if planet is None:
        return list(entries)
    preset, has, radius = _described(planet)
    return [name for name, entry in entries.items() if entry.missing(preset, has, radius) is None]


def view(name: str, planet: str | PlanetHandle | None = None) -> View:
    """A named view. planet: a preset's name or scene.planet, whose own place is taken; None: the scene's it is used in.

    Raises UnknownNameError for an unknown name and for a view that the given planet doesn't have.
    """
    entries = view_entries(VIEWS_FILE)
    entry = entries.get(name)
    if entry is None:
        raise UnknownNameError(
            f"no view {name!r}; {did_you_mean(name, entries if planet is None else views(planet), 'views')}"
        )
    if planet is not None:
        preset, has, radius = _described(planet)
        why = entry.missing(preset, has, radius)
        if why is not None:
            there = ", ".join(views(planet))
            called = planet if isinstance(planet, str) else planet.name
            raise UnknownNameError(f"no view {name!r} of planet {called!r}: {why}. Its views: {there}")
    return View(name, entry, planet)


def _described(planet: str | PlanetHandle | Scene) -> tuple[str | None, Mapping[str, Any], float]:
    """(preset, its component tables, radius) of a planet."""
    if isinstance(planet, Scene):
        planet = planet.planet
    if isinstance(planet, str):
        return _described_preset(planet)
    has = {table: True for table, kind in PLANET_KINDS.items() if planet.has(kind)}
    has |= {_COMPANION + name: True for name in planet.scene.companions} | _rivers(planet.get(Terrain))
    return planet.scene.preset, has, planet.radius_m


def _rivers(terrain: Terrain | None) -> dict[str, bool]:
    """ "rivers", where there are any."""
    return {"rivers": True} if terrain is not None and terrain.rivers > 0.0 else {}


@lru_cache(maxsize=32)
def _described_preset(name: str) -> tuple[str | None, Mapping[str, Any], float]:
    description = describe(name)
    body = description.components.get("planet", Planet())
    has = {**description.components, **{_COMPANION + told.name: True for told, _ in description.companions}}
    has |= _rivers(description.components.get("terrain"))
    return description.preset, has, body.radius_m


@lru_cache(maxsize=4)
def view_entries(file: Path) -> dict[str, _Entry]:
    """The views of a file; PresetError with everything that is wrong in it."""
    problems: list[str] = []
    found: dict[str, _Entry] = {}
    data = read_toml(file)
    for key in data:
        if key != "view":
            problems.append(f"{key}: unknown key; every view is a table [view.NAME]")
    for name, table in data.get("view", {}).items():
        values = dict(table)
        over, needs = values.pop("planet", {}), values.pop("needs", [])
        for need in needs:
            if need not in KNOWN_TABLES and not need.startswith(_COMPANION):
                problems.append(f"view.{name}.needs: {did_you_mean(need, KNOWN_TABLES, 'tables')}, found {need!r}")
        row = _row(values, f"view.{name}", problems)
        rows = {}
        for planet, changes in over.items():
            if planet not in planets():
                hint = did_you_mean(planet, planets(), "planets")
                problems.append(f"view.{name}.planet.{planet}: no such planet preset; {hint}")
            rules = rules_of(_Row)
            gone = {other for key in changes if key in rules for other in rules[key].knob.excludes}
            base = {key: value for key, value in values.items() if key not in gone}
            rows[planet] = _row(base | changes, f"view.{name}.planet.{planet}", problems)
        found[name] = _Entry(row, rows, tuple(needs))
    if problems:
        raise PresetError(f"{file}: {len(problems)} problems:\n" + "\n".join(f"  - {p}" for p in problems), problems)
    return found


def _row(values: Mapping[str, Any], where: str, problems: list[str]) -> _Row:
    rules = rules_of(_Row)
    checked: dict[str, Any] = {}
    for key, value in values.items():
        if key not in rules:
            problems.append(f"{where}.{key}: unknown key; {did_you_mean(key, rules, 'allowed')}")
            continue
        try:
            checked[key] = check_value(rules[key], value, f"{where}.{key}")
        except SettingError as error:
            problems.append(str(error))
    return _Row(**checked)
