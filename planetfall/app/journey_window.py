"""The window of F4: how to move, places to fly to and places kept, time of day and of year, photos."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from ..engine.gpu.imgui_type import ImGui
from ..errors import SizeError
from ..systems.flight import MODES
from .journey import clock_text, season_text

if TYPE_CHECKING:
    from .flight import Flight

__all__ = ["JourneyWindow"]

_WIDTH_EM = 24.0
TOP_PX, _MARGIN = 235.0, 10.0
_SIZES = ((1920, 1080), (3840, 2160), (7680, 4320), (15360, 8640), (4096, 4096))
_MODE_NAMES = {"ship": "ship", "walk": "on foot", "orbit": "globe"}
_FILES = {".png": "picture (PNG)", ".exr": "light and arrays (EXR)", ".npz": "arrays for numpy (npz)"}
_FOV_DEG = (1.0, 120.0)
_EV = (-6.0, 20.0)


class JourneyWindow:
    """Draws into an ImGui frame and changes the app."""

    def __init__(self) -> None:
        self._place = [0.0, 0.0, 200.0]
        self._name = ""
        self._fov_deg = 60.0
        self._ev100 = 14.0

    def draw(self, imgui: ImGui, app: Flight) -> None:
        """One frame of the window, at the left edge."""
        em, display = imgui.get_font_size(), imgui.get_io().display_size
        top = min(TOP_PX, 0.4 * display.y)
        imgui.set_next_window_pos(imgui.ImVec2(_MARGIN, top), imgui.Cond_.appearing)
        size = imgui.ImVec2(_WIDTH_EM * em, max(display.y - top - _MARGIN, 8.0 * em))
        imgui.set_next_window_size(size, imgui.Cond_.appearing)
        imgui.set_next_window_bg_alpha(0.85)
        imgui.begin("Places, time, photos")
        imgui.push_item_width(-9.0 * em)
        self._moving(imgui, app)
        imgui.separator_text("time")
        self._time(imgui, app)
        imgui.separator_text("places kept")
        self._places(imgui, app)
        imgui.separator_text("photo")
        self._photo(imgui, app)
        imgui.pop_item_width()
        imgui.end()

    def _moving(self, imgui: ImGui, app: Flight) -> None:
        for number, mode in enumerate(MODES):
            if number:
                imgui.same_line()
            if imgui.radio_button(_MODE_NAMES[mode], app.pilot.mode == mode):
                app.switch(mode)
        imgui.separator_text("fly to")
        for index, (label, speed, low, high, shape) in enumerate(
            (
                ("latitude", 0.1, -90.0, 90.0, "%.4f deg"),
                ("longitude", 0.1, -360.0, 360.0, "%.4f deg"),
                ("above ground", 5.0, 2.0, 5e7, "%.0f m"),
            )
        ):
            self._place[index] = imgui.drag_float(label, self._place[index], speed, low, high, shape)[1]
        if imgui.button("fly there"):
            latitude, longitude, altitude = self._place
            app.fly_to_place(latitude, longitude, altitude)
        imgui.same_line()
        if imgui.button("from here"):
            self._place = list(app.latitude_longitude_altitude)
        imgui.set_item_tooltip("the numbers of the place where the camera is")

    def _time(self, imgui: ImGui, app: Flight) -> None:
        journey = app.journey
        changed, hour = imgui.slider_float("time of day", journey.hour, 0.0, 24.0, clock_text(journey.hour))
        if changed:
            journey.hour = hour
        changed, share = imgui.slider_float(
            "of the year", journey.season, 0.0, 1.0, season_text(journey.season).replace("%", "%%")
        )
        if changed:
            journey.season = min(share, 0.999999)
        app.time_runs = imgui.checkbox("time runs", app.time_runs)[1]
        imgui.same_line()
        follows = app.scene.sun.mode == "epoch"
        if imgui.checkbox("moves the sun", follows)[0] and not follows:
            journey.later(0.0)
        app.time_speed = imgui.slider_float(
            "pace", app.time_speed, 1.0 / 64.0, 1e6, "%.3g x", imgui.SliderFlags_.logarithmic
        )[1]

    def _places(self, imgui: ImGui, app: Flight) -> None:
        journey = app.journey
        if journey.places.problem:
            imgui.text_wrapped(journey.places.problem)
        self._name = imgui.input_text("##name", self._name)[1]
        imgui.same_line()
        if imgui.button("keep this place"):
            journey.keep_place(self._name or None)
            self._name = ""
        for name in journey.places.names(app.scene):
            imgui.push_id(name)
            if imgui.small_button("go"):
                journey.go(name)
            imgui.same_line()
            if imgui.small_button("forget"):
                journey.forget_place(name)
            imgui.same_line()
            imgui.text(name)
            imgui.pop_id()

    def _photo(self, imgui: ImGui, app: Flight) -> None:
        journey, plan = app.journey, app.journey.photo
        if imgui.begin_combo("size", "{} x {}".format(*plan.size)):
            for size in _SIZES:
                if imgui.selectable("{} x {}".format(*size), size == plan.size)[0]:
                    plan = dataclasses.replace(plan, size=size)
            imgui.end_combo()
        changed, samples = imgui.slider_int("samples a side", plan.supersample, 1, 4)
        if changed:
            plan = dataclasses.replace(plan, supersample=samples)
        if imgui.begin_combo("file", _FILES[journey.photo_suffix]):
            for suffix, text in _FILES.items():
                if imgui.selectable(text, suffix == journey.photo_suffix)[0]:
                    journey.photo_suffix = suffix
            imgui.end_combo()
        own = imgui.checkbox("own field of view", journey.photo_fov_deg is not None)[1]
        if own:
            self._fov_deg = imgui.slider_float("field of view", self._fov_deg, *_FOV_DEG, "%.1f deg")[1]
        journey.photo_fov_deg = self._fov_deg if own else None
        own = imgui.checkbox("own exposure", plan.ev100 is not None)[1]
        if own:
            self._ev100 = imgui.slider_float("exposure", self._ev100, *_EV, "EV %.1f")[1]
        try:
            journey.photo = dataclasses.replace(plan, ev100=self._ev100 if own else None)
        except SizeError as error:
            app.say(str(error))
        if not app.photographing and imgui.button("take the photo"):
            journey.start_photo()
        elif app.photographing and imgui.button("give it up"):
            journey.stop_photo()
        if not app.photographing:
            imgui.same_line()
            if imgui.button("save this view"):
                app.save_picture(journey.folder, journey.photo_suffix)
            imgui.set_item_tooltip("as it is in the window, in that kind of file")
