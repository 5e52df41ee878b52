"""The settings window of the flight: the planet's knobs, quality, debug views, places and time, and passes.

Which knobs there are is nowhere said here: components and quality groups bring theirs.
"""

from __future__ import annotations

import dataclasses
import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._kinds import KINDS, PLANET_KINDS
from .components import Atmosphere, Ocean, Stars, Terrain
from .engine.graph import TextureSpec
from .engine.settings import rules_of
from .errors import OutputError
from .flights import paths
from .quality import _GROUPS as QUALITY_GROUPS
from .quality import QUALITY, qualities, resolve_quality
from .systems.debug import NAMED_VIEWS
from .systems.tweak import Panel, PassTime, draw_passes
from .views import view, views

if TYPE_CHECKING:
    from .app import FlightApp
    from .scene import Scene

__all__ = ["SettingsWindow"]

log = logging.getLogger(__name__)

OPTIONAL: tuple[type, ...] = (Terrain, Ocean, Atmosphere, Stars)
"""Components that a scene can do without: they have a switch."""

_WIDTH_EM = 30.0
_LABEL_EM = 11.5
_MARGIN = 10.0
_FOV_DEG = (2.0, 120.0)


class SettingsWindow:
    """Draws into an ImGui frame and changes the app and its scene. "reset" goes back to how the flight began."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._panel = Panel()
        self._quality_panel = Panel()
        self._loaded: dict[str, Any] = {}
        self._taken_off: dict[type, Any] = {}
        self._quality = ""
        self._groups: dict[str, Any] = {}
        self._presets: dict[str, Any] = {}
        self._wants_quality = False
        self._culled = False
        self._names: tuple[int, list[str]] = (0, [])

    def draw(self, imgui: Any, app: FlightApp) -> None:
        """One frame of the window, at the right edge."""
        em, display = imgui.get_font_size(), imgui.get_io().display_size
        width = self._width(em, display.x)
        height = max(display.y - 2 * _MARGIN, 8 * em)
        imgui.set_next_window_pos(
            imgui.ImVec2(display.x - _MARGIN, _MARGIN), imgui.Cond_.appearing, imgui.ImVec2(1.0, 0.0)
        )
        imgui.set_next_window_size(imgui.ImVec2(width, height), imgui.Cond_.appearing)
        imgui.set_next_window_bg_alpha(0.85)
        self.remember()
        imgui.begin("Settings")
        if imgui.begin_tab_bar("tabs"):
            for name, page in (
                ("Planet", self._planet_page),
                ("View", self._view_page),
                ("Quality", self._quality_page),
                ("Passes", self._passes_page),
            ):
                if imgui.begin_tab_item(name)[0]:
                    page(imgui, app)
                    imgui.end_tab_item()
            imgui.end_tab_bar()
        imgui.end()

    def remember(self) -> None:
        """Take the scene as it is now for what "reset" goes back to; only the first time counts."""
        if not self._loaded:
            self._loaded = {name: dataclasses.replace(part) for name, part in self._parts().items()}

    def width(self, imgui: Any) -> float:
        """What it takes of the right edge, in window units."""
        return self._width(imgui.get_font_size(), imgui.get_io().display_size.x) + _MARGIN

    @staticmethod
    def _width(em: float, available: float) -> float:
        return min(_WIDTH_EM * em, available - 2 * _MARGIN)

    # -- planet ------------------------------------------------------------------------------------------------------

    def _parts(self) -> dict[str, Any]:
        """The scene's components by the heading that the panel gives them."""
        handles = (self._scene.planet, self._scene.environment)
        found = {type(part): part for handle in handles for part in handle.components()}
        return {kind.__name__: found[kind] for kind in KINDS.values() if kind in found}

    def _planet_page(self, imgui: Any, app: FlightApp) -> None:
        imgui.push_id("parts")
        for number, kind in enumerate(OPTIONAL):
            if number:
                imgui.same_line()
            self._switch(imgui, app, kind)
        imgui.pop_id()
        if imgui.button("reset all"):
            self._reset_all(app)
        imgui.same_line()
        if imgui.button("save scene"):
            self._save(app)
        imgui.set_item_tooltip("as a TOML file in the current folder; `planetfall fly FILE` opens it")
        parts = self._parts()
        changes = self._panel.draw_all(parts, self._loaded)
        if changes and not app.validate():
            for heading, made in changes.items():
                for change in reversed(made):
                    setattr(parts[heading], change.field, change.old)

    def _switch(self, imgui: Any, app: FlightApp, kind: type) -> None:
        handle = self._scene.planet if kind in PLANET_KINDS.values() else self._scene.environment
        toggled, wanted = imgui.checkbox(kind.__name__, handle.has(kind))
        if not toggled:
            return
        if not wanted:
            self._taken_off[kind] = handle.remove(kind)
            return
        handle.add(self._taken_off.pop(kind, None) or kind())
        if not app.validate():
            self._taken_off[kind] = handle.remove(kind)

    def _reset_all(self, app: FlightApp) -> None:
        for name, part in self._parts().items():
            loaded = self._loaded.get(name)
            if loaded is None:
                continue
            # Values that exclude each other: first what is to be nothing, then the rest.
            for rule in sorted(rules_of(type(part)).values(), key=lambda r: getattr(loaded, r.name) is not None):
                if getattr(part, rule.name) != getattr(loaded, rule.name):
                    setattr(part, rule.name, getattr(loaded, rule.name))
        app.say("the scene is as the flight began")

    def _save(self, app: FlightApp) -> None:
        target = Path(f"{self._scene.name}_changed.toml")
        try:
            self._scene.save(target)
        except (OSError, OutputError) as error:
            app.say(f"{target.resolve()} could not be written: {error}")
            return
        app.say(f"saved {target.resolve()}")

    # -- view --------------------------------------------------------------------------------------------------------

    def _view_page(self, imgui: Any, app: FlightApp) -> None:
        imgui.push_item_width(-_LABEL_EM * imgui.get_font_size())
        imgui.separator_text("debug view")
        chosen = _combo(imgui, "shows", app.debug_view, ("off", *NAMED_VIEWS), self._resources(app))
        if chosen is not None:
            app.debug_view = chosen
        imgui.separator_text("places")
        chosen = _combo(imgui, "go to", "", views(self._scene), tips=lambda name: view(name, self._scene.planet).about)
        if chosen is not None:
            app.go_to(chosen)
        chosen = _combo(imgui, "play", app.playing.name if app.playing else "", paths())
        if chosen is not None:
            app.play(chosen)
        if app.playing is not None:
            imgui.same_line()
            if imgui.button("stop"):
                app.play(None)
        if app.playing is not None:
            moved, at = imgui.slider_float("s##played", app.played_s, 0.0, app.playing.duration_s, "%.1f")
            if moved:
                app.played_s = at
        imgui.separator_text("camera")
        low, high = _FOV_DEG
        app.fov_y_deg = imgui.slider_float("field of view [deg]", app.fov_y_deg, low, high, "%.1f")[1]
        throttle = app.ship.limits.wheel_range
        logarithmic = imgui.SliderFlags_.logarithmic
        app.ship.throttle = imgui.slider_float(
            "speed", app.ship.throttle, 1.0 / throttle, throttle, "%.2f x", logarithmic
        )[1]
        imgui.separator_text("time")
        app.time_runs = imgui.checkbox("runs", app.time_runs)[1]
        imgui.same_line()
        if imgui.button("to 0"):
            app.time_s = 0.0
        imgui.same_line()
        imgui.text(f"{app.time_s:.1f} s")
        app.time_speed = imgui.slider_float("pace", app.time_speed, 1.0 / 64.0, 1e6, "%.3g x", logarithmic)[1]
        if self._scene.sun.mode != "epoch":
            imgui.text_wrapped("The sun stands still: set Sun epoch_s, and it follows the time.")
        imgui.pop_item_width()

    def _resources(self, app: FlightApp) -> list[str]:
        """Textures of the frame that can be looked at; looked up again when the graph has been compiled anew."""
        try:
            plan = app.renderer.graph
        except Exception:  # nothing has been drawn yet
            return []
        if self._names[0] != id(plan):
            specs = plan.analysis.model.specs
            names = [n for n, s in specs.items() if isinstance(s, TextureSpec) and not n.startswith("debug.")]
            self._names = (id(plan), sorted(names))
        return self._names[1]

    # -- quality -----------------------------------------------------------------------------------------------------

    def _quality_page(self, imgui: Any, app: FlightApp) -> None:
        if self._quality != app.quality or not self._groups:
            self._take_quality(app)
        chosen = _combo(imgui, "preset", app.quality, qualities(), tips=QUALITY.about)
        imgui.text_wrapped("Changes are applied when you let go; shaders are made anew, which takes a moment.")
        if self._quality_panel.draw_all(self._groups, self._presets):
            self._wants_quality = True
        if chosen is not None:
            app.set_quality(chosen)
            self._take_quality(app)
            self._wants_quality = False
        elif self._wants_quality and not imgui.is_any_item_active():
            self._wants_quality = False
            own = {key: value for key, value in app.overrides.items() if key not in QUALITY.rules}
            app.set_quality(app.quality, own | self._differences())
            self._take_quality(app)

    def _take_quality(self, app: FlightApp) -> None:
        self._quality = app.quality
        self._groups = _quality_groups(resolve_quality(app.quality, app.overrides))
        self._presets = _quality_groups(resolve_quality(app.quality))

    def _differences(self) -> dict[str, Any]:
        return {
            f"{name}.{rule}": getattr(group, rule)
            for name, group in self._groups.items()
            for rule in rules_of(type(group))
            if getattr(group, rule) != getattr(self._presets[name], rule)
        }

    # -- passes ------------------------------------------------------------------------------------------------------

    def _passes_page(self, imgui: Any, app: FlightApp) -> None:
        try:
            plan = app.renderer.graph
        except Exception:
            imgui.text("nothing has been drawn yet")
            return
        toggled, on = imgui.checkbox("GPU times", plan.gpu_timing)
        if toggled:
            plan.gpu_timing = on
        imgui.set_item_tooltip("time stamps around each pass; they cost some time themselves")
        imgui.same_line()
        self._culled = imgui.checkbox("unused passes too", self._culled)[1]
        imgui.text(f"{plan.memory_bytes() / 2**20:.1f} MiB in the frame's textures and buffers")
        helps = {declared.name: declared.help for declared in plan.analysis.model.passes}
        passes = [
            PassTime(
                report.name,
                report.cpu_ms or 0.0,
                report.gpu_ms,
                report.skipped_why or "",
                culled=(report.skipped_why or "").startswith("culled"),
                help=helps.get(report.name, ""),
            )
            for report in app.renderer.passes()
        ]
        draw_passes(passes, culled=self._culled)


def _quality_groups(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: kind(**{rule: values[f"{name}.{rule}"] for rule in rules_of(kind)})
        for name, kind in QUALITY_GROUPS.items()
    }


def _combo(imgui: Any, label: str, shown: str, names: Any, more: Any = (), tips: Any = None) -> str | None:
    """A list to choose from; the choice of this frame, or None. more: names after a line. tips: name -> text."""
    found = None
    if imgui.begin_combo(label, shown, imgui.ComboFlags_.height_large):
        for group, members in enumerate((names, more)):
            if group and members:
                imgui.separator_text("resources")
            for name in members:
                if imgui.selectable(name, name == shown)[0]:
                    found = name
                if tips is not None:
                    imgui.set_item_tooltip(tips(name))
        imgui.end_combo()
    return found
