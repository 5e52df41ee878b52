"""Places kept by the user: camera, sun and time, by name, in a file of theirs."""

from __future__ import annotations

import dataclasses
import logging
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from ..components import Sun
from ..engine.settings import PresetError, did_you_mean, plain_table, read_toml, write_toml
from ..engine.settings.user import user_folder
from ..errors import UnknownNameError
from .camera import Camera

if TYPE_CHECKING:
    from ..scene.scene import Scene

__all__ = ["Place", "Places"]

log = logging.getLogger(__name__)

_MOST = 10_000


@dataclasses.dataclass(frozen=True)
class Place:
    """A place kept: over which scene, the camera there, the sun and the time."""

    name: str
    scene: str
    camera: Camera
    sun: Sun
    time_s: float
    mode: str = "ship"


class _Entry(msgspec.Struct, forbid_unknown_fields=True):
    name: str
    scene: str
    position_m: tuple[float, float, float]
    forward: tuple[float, float, float]
    up: tuple[float, float, float]
    sun: dict[str, Any]
    fov_y_deg: float = 60.0
    time_s: float = 0.0
    mode: str = "ship"


class _File(msgspec.Struct, forbid_unknown_fields=True):
    place: list[_Entry] = []


class Places:
    """The list of kept places, in the order in which they were kept; every change is written at once.

    file: None is places.toml in the user's settings folder. A file that can't be read is left alone: `problem` says
    what is wrong with it, the list is empty, and the first change puts it aside under another name.
    """

    def __init__(self, file: Path | str | None = None) -> None:
        self.file = user_folder() / "places.toml" if file is None else Path(file)
        self.problem = ""
        self._places: list[Place] = []
        if self.file.exists():
            try:
                self._places = _read(self.file)
            except PresetError as error:
                log.warning("%s", error)
                self.problem = (
                    f"{error}\nNone of its places is shown; the file was left as it is, and is put aside under another "
                    "name when a place is kept."
                )

    def names(self, scene: Scene | None = None) -> list[str]:
        """Names of all places, or of those over a scene."""
        return [place.name for place in self._places if scene is None or place.scene == scene.name]

    def __getitem__(self, name: str) -> Place:
        for place in self._places:
            if place.name == name:
                return place
        raise UnknownNameError(f"no place {name!r}; {did_you_mean(name, self.names(), 'places')}")

    def keep(self, place: Place) -> None:
        """Add a place, or change the one of that name. PresetError when it can't be written: then nothing changes."""
        if not place.name.strip():
            raise PresetError("a place needs a name")
        optics = place.camera.optics
        if optics.intrinsics is not None or optics.frustum_deg is not None or optics.ev100 is not None:
            raise PresetError(
                f"place {place.name!r}: a place keeps where a camera is and its fov_y_deg; intrinsics, frustum_deg and "
                "ev100 are kept by pictures (planetfall render --like)"
            )
        kept = [place if old.name == place.name else old for old in self._places]
        if place.name not in self.names():
            kept.append(place)
        if len(kept) > _MOST:
            raise PresetError(f"{self.file}: {_MOST} places are kept already; forget some")
        self._write(kept)

    def forget(self, name: str) -> None:
        """Take a place off the list. UnknownNameError for one that isn't there."""
        gone = self[name]
        self._write([place for place in self._places if place is not gone])

    def free_name(self, stem: str) -> str:
        """A name that isn't taken yet: the stem, or the stem and a number."""
        taken, number, name = set(self.names()), 2, stem
        while name in taken:
            name, number = f"{stem} {number}", number + 1
        return name

    def _write(self, places: list[Place]) -> None:
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            if self.problem and self.file.exists():
                aside = _aside(self.file)
                self.file.replace(aside)
                log.warning("%s could not be read and was put aside as %s", self.file, aside.name)
        except OSError as error:
            raise PresetError(f"{self.file}: can't be written: {error.strerror or error}") from error
        write_toml(self.file, {"place": [_table(place) for place in places]})
        self._places, self.problem = places, ""


def _read(file: Path) -> list[Place]:
    try:
        checked = msgspec.convert(read_toml(file), _File)
    except msgspec.ValidationError as error:
        text, _, where = str(error).rpartition(" - at ")
        raise PresetError(
            f"{file}: {where.strip('`').removeprefix('$.')}: {text}" if text else f"{file}: {where}"
        ) from error
    except RecursionError:
        raise PresetError(f"{file}: tables inside tables without end") from None
    places = []
    for number, entry in enumerate(checked.place):
        where = f"{file}: place[{number}] ({entry.name!r})"
        if not math.isfinite(entry.time_s):
            raise PresetError(f"{where}: time_s: expected a finite number, found {entry.time_s!r}")
        try:
            camera = Camera(entry.position_m, entry.forward, entry.up, entry.fov_y_deg)
            sun = Sun(**entry.sun)
        except (ValueError, TypeError) as error:
            raise PresetError(f"{where}: {error}") from error
        places.append(Place(entry.name, entry.scene, camera, sun, entry.time_s, entry.mode))
    return places


def _table(place: Place) -> dict[str, Any]:
    camera = place.camera
    return {
        "name": place.name,
        "scene": place.scene,
        "position_m": [float(x) for x in camera.position_m],
        "forward": [float(x) for x in camera.forward],
        "up": [float(x) for x in camera.up],
        "fov_y_deg": float(camera.fov_y_deg),
        "time_s": float(place.time_s),
        "mode": place.mode,
        "sun": plain_table(place.sun),
    }


def _aside(file: Path) -> Path:
    """A name beside it that isn't taken."""
    number, name = 1, file.with_suffix(".damaged.toml")
    while name.exists():
        number, name = number + 1, file.with_suffix(f".damaged{number + 1}.toml")
    return name
