"""What a flight does with places, time and photos: the part of the app behind those keys and the window of F4."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Callable, Generator, Iterator
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from ..camera.kept import Place, Places
from ..capture.captures import check_arrays, outputs_for, save_capture
from ..capture.photos import PhotoPlan, photo_tiles
from ..capture.shot import shot_settings
from ..engine.settings import PresetError, SettingError
from ..errors import OutputError, SceneError, SizeError
from ..scene import sun_clock
from ..systems.capture import CaptureError, require_writable
from .planets import FlightPlanets, Traveller

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..components import Sun
    from ..systems.flight import Mode

__all__ = ["Journey", "Journeying"]

log = logging.getLogger(__name__)

_TWO_DAYS = 2.0 / 365.0
"""As a share of the year."""


class Journeying(Traveller, Protocol):
    """What a journey needs of its flight."""

    planets: FlightPlanets
    quality: str
    overrides: dict[str, Any]

    def camera_for(self, fov_y_deg: float | None) -> Camera: ...
    def place(self, camera: Camera, sun: Sun | None = None) -> None: ...
    def switch(self, mode: Mode) -> None: ...


class Journey:
    """Places kept, the sun's clock and photos of one flight. Errors are shown by the app, not raised."""

    def __init__(self, app: Journeying, places: Places | None = None) -> None:
        self._app = app
        self.places = Places() if places is None else places
        self.photo = PhotoPlan()
        self.photo_fov_deg: float | None = None
        self.photo_suffix = ".png"
        self.folder = Path()
        self._at = ""
        self._season_wanted = 0.0
        self._tiles: Iterator[tuple[int, int, Any]] | None = None
        self._taken: tuple[Path, dict[str, Any]] | None = None

    # -- time ---------------------------------------------------------------------------------------------------------

    @property
    def hour(self) -> float:
        """Hour of the local solar day below the camera, on the planet that the flight is over."""
        app = self._app
        return sun_clock.hour_at(app.scene, app.pilot.position_m, app.time_s, self._over)

    @hour.setter
    def hour(self, hour: float) -> None:
        self._set(sun_clock.set_hour, hour)

    @property
    def season(self) -> float:
        """Share of the year since the northern spring equinox."""
        return sun_clock.season(self._app.scene, self._app.time_s)

    @season.setter
    def season(self, share: float) -> None:
        self._set(sun_clock.set_season, share)

    @property
    def _over(self) -> str:
        """The planet that the flight is over; the scene's own in the frame after that was taken out."""
        name = self._app.planets.name
        return name if name in self._app.scene.planets else ""

    def _set(self, how: Callable[..., None], value: float) -> None:
        app = self._app
        try:
            how(app.scene, app.pilot.position_m, app.time_s, value, self._over)
        except SceneError as error:
            app.say(str(error))

    def later(self, hours: float) -> None:
        """Turn the time of day on (or back)."""
        self.hour = self.hour + hours
        self._app.say(f"{clock_text(self.hour)} by the sun")

    def later_in_year(self, years: float) -> None:
        """Turn the time of year on (or back), at the same hour."""
        # Hours are kept, so seasons come in whole days: small steps add up here until they make one.
        near = abs((self._season_wanted - self.season + 0.5) % 1.0 - 0.5) < _TWO_DAYS
        self._season_wanted = (self._season_wanted if near else self.season) + years
        self.season = self._season_wanted
        self._app.say(f"{season_text(self.season)}, {clock_text(self.hour)} by the sun")

    # -- places -------------------------------------------------------------------------------------------------------

    def keep_place(self, name: str | None = None) -> None:
        """Keep camera, sun and time under a name, or one made of the scene's and a number."""
        app = self._app
        called = self.places.free_name(app.scene.name) if name is None else name.strip()
        place = Place(
            called, app.scene.name, app.camera, dataclasses.replace(app.scene.sun), app.time_s, app.pilot.mode
        )
        try:
            self.places.keep(place)
        except PresetError as error:
            log.warning("%s", error)
            app.say(str(error))
            return
        self._at = called
        app.say(f"kept as {called!r}")

    def forget_place(self, name: str) -> None:
        """Take a place off the list."""
        try:
            self.places.forget(name)
        except SettingError as error:
            self._app.say(str(error))

    def next_place(self, step: int) -> None:
        """To the place kept after (or before) the one that was visited last."""
        names = self.places.names(self._app.scene)
        if not names:
            self._app.say("no place is kept here yet")
            return
        now = names.index(self._at) if self._at in names else (-1 if step > 0 else 0)
        self.go(names[(now + step) % len(names)])

    def go(self, name: str) -> None:
        """To a place kept, at its time and under its sun."""
        place = self.places[name]
        self._app.time_s = place.time_s  # first: which planet that is depends on where they are then
        self._app.place(place.camera, place.sun)
        if place.mode in ("walk", "orbit"):
            self._app.switch(place.mode)
        self._at = name
        self._app.say(name)

    # -- photos -------------------------------------------------------------------------------------------------------

    @property
    def photographing(self) -> bool:
        return self._tiles is not None

    def start_photo(self) -> None:
        """Take a photo as `self.photo` has it; goes on by a tile a frame until it is done or stopped."""
        app = self._app
        file = self.folder / f"planetfall_{datetime.now():%Y%m%d_%H%M%S_%f}{self.photo_suffix}"
        try:
            require_writable(file)
            check_arrays(file, self.photo.size)
            camera = app.camera_for(self.photo_fov_deg)
            self._tiles = photo_tiles(app.renderer, camera, self.photo, app.time_s, outputs=outputs_for(file))
            settings = shot_settings(
                app.scene, camera, app.time_s, self.photo.size, quality=app.quality, overrides=app.overrides,
                supersample=self.photo.supersample, ev100=self.photo.ev100, mode=app.pilot.mode,
            )  # fmt: skip
        except (CaptureError, OutputError, SizeError) as error:
            log.warning("%s", error)
            app.say(str(error))
            return
        self._taken = (file, settings)
        app.say("taking a photo")

    def stop_photo(self) -> None:
        """Give a photo up."""
        if self._tiles is not None:
            self._end_photo()
            self._app.say("the photo was given up")

    def step_photo(self) -> None:
        """The next tile; the file after the last."""
        tiles, taken = self._tiles, self._taken
        if tiles is None or taken is None:
            return
        try:
            done, count, arrays = next(tiles)
            if done < count:
                self._app.say(f"photo: {done} of {count} tiles; Escape gives it up")
                return
            file, settings = taken
            settings["exposure"] = self._app.renderer.exposure if self.photo.ev100 is None else self.photo.ev100
            save_capture(file, arrays, settings)
        except CaptureError as error:
            log.warning("%s", error)
            self._app.say(str(error))
        except BaseException:
            self._end_photo()
            raise
        else:
            self._app.say(f"saved {file.resolve()}")
        self._end_photo()

    def _end_photo(self) -> None:
        tiles, self._tiles, self._taken = self._tiles, None, None
        if isinstance(tiles, Generator):
            tiles.close()  # puts the renderer's size back


def clock_text(hour: float) -> str:
    """6.5 is 06:30."""
    minutes = round(hour * 60.0) % 1440
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def season_text(share: float) -> str:
    """Share of the year since the northern spring equinox, for people."""
    names = ("northern spring", "northern summer", "northern autumn", "northern winter")
    return f"{names[int(share * 4.0) % 4]}, {share * 400.0 % 100.0:.0f} %"
