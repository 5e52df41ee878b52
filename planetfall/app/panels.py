"""The settings window of the flight: the planet's knobs, quality, debug views, places and time, and passes.

Which knobs there are is nowhere said here: components and quality groups bring theirs. What the window remembers (undo,
presets, two states to compare) is a Workbench; its other pages are in app_pages.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, NamedTuple

import tomli_w

from ..engine.gpu.imgui_type import ImGui
from ..engine.settings import latest_revision
from ..errors import OutputError, SceneError, SettingError, UnknownNameError
from ..quality import QUALITY, qualities
from ..scene.file import planets, scenes
from ..scene.kinds import KINDS
from ..scene.presets import brief_companion, left_out, load_companions, load_parts, preset_names, save_preset
from ..scene.scene import scene_of
from ..systems.tweak import FrameHistory, LogLines, Panel, Workbench, icon
from .controls import ControlsPage
from .objects import ObjectsPage
from .pages import ProfilerPage, ViewPage, combo
from .planet_page import PlanetPage
from .tweak_store import QUALITY_HEADING, SceneStore

if TYPE_CHECKING:
    from ..scene.scene import Scene
    from .flight import Flight

__all__ = ["SettingsWindow"]

log = logging.getLogger(__name__)

_WIDTH_EM = 30.0
_MARGIN = 10.0
_ALPHA = 0.93
_SCENE_HEADINGS = tuple(kind.__name__ for kind in KINDS.values())


class _Quality(NamedTuple):
    preset: str
    overrides: dict[str, Any]


class SettingsWindow:
    """Draws into an ImGui frame and changes the app and its scene. "reset" goes back to the preset, which at first is
    how the flight began. history: frame times. log: the last lines of the log, once it is attached to a logger."""

    def __init__(self, scene: Scene, history: FrameHistory) -> None:
        self._scene = scene
        self._store = SceneStore(scene)
        self._bench: Workbench | None = None
        self._quality_panel = Panel()
        self.turn_to = ""
        """The page to show from the next frame on, by its name."""
        self._known_quality: _Quality | None = None
        self._quality_stamp = -1
        self._preset = ""
        self._name = ""
        self.wrong = ""
        self.log = LogLines()
        self.controls = ControlsPage()
        self.planets = PlanetPage(scene, self._store, lambda: self.bench, self._refused)
        self.panel = self.planets.panel
        objects = ObjectsPage(scene, self._store, lambda: self.bench, self._refused)
        self._pages = (
            ("Objects", objects.draw),
            ("View", ViewPage(scene).draw),
            ("Profiler", ProfilerPage(history).draw),
            ("Controls", self.controls.draw),
            ("Log", lambda imgui, app: self.log.draw(imgui)),
        )

    @property
    def bench(self) -> Workbench:
        """What the window remembers; there from the first frame on."""
        assert self._bench is not None, "remember() comes first"
        return self._bench

    def remember(self, app: Flight) -> None:
        """Take the scene as it is now for what "reset" goes back to; only the first time counts."""
        if self._bench is None:
            self._store.take_quality(app.quality, app.overrides)
            self._bench = Workbench(self._store, self._store.wrong)
            self._bench.base = {**self._bench.base, **self._store.preset_parts(app.quality)}
            self._known_quality = _Quality(app.quality, dict(app.overrides))
            self._preset = self._scene.name

    def draw(self, imgui: ImGui, app: Flight) -> None:
        """One frame of the window, at the right edge."""
        em, display = imgui.get_font_size(), imgui.get_io().display_size
        width = self._width(em, display.x)
        height = max(display.y - 2 * _MARGIN, 8 * em)
        imgui.set_next_window_pos(
            imgui.ImVec2(display.x - _MARGIN, _MARGIN), imgui.Cond_.appearing, imgui.ImVec2(1.0, 0.0)
        )
        imgui.set_next_window_size(imgui.ImVec2(width, height), imgui.Cond_.appearing)
        imgui.set_next_window_bg_alpha(_ALPHA)
        self.remember(app)
        self._follow_app(app)
        imgui.begin("Settings")
        self._toolbar(imgui, app)
        if imgui.begin_tab_bar("tabs"):
            for name, page in (("Planet", self._planet_page), ("Quality", self._quality_page), *self._pages):
                chosen = imgui.TabItemFlags_.set_selected if name == self.turn_to else 0
                if imgui.begin_tab_item(name, None, chosen)[0]:
                    imgui.begin_child("page")
                    page(imgui, app)
                    imgui.end_child()
                    imgui.end_tab_item()
            imgui.end_tab_bar()
            self.turn_to = ""
        imgui.end()
        if not imgui.is_any_item_active():
            self.bench.history.seal()
            self._make_quality(app)

    def unfold(self) -> None:
        """Open all sections of knobs, on all pages."""
        headings = self._store.parts()
        self.panel.unfold |= set(headings)
        self._quality_panel.unfold |= {heading.partition(".")[2] for heading in headings}

    def width(self, imgui: ImGui) -> float:
        """What it takes of the right edge, in window units."""
        return self._width(imgui.get_font_size(), imgui.get_io().display_size.x) + _MARGIN

    @staticmethod
    def _width(em: float, available: float) -> float:
        return min(_WIDTH_EM * em, available - 2 * _MARGIN)

    # -- undo, presets, A and B --------------------------------------------------------------------------------------

    def _toolbar(self, imgui: ImGui, app: Flight) -> None:
        bench = self.bench
        typing, chord = imgui.get_io().want_text_input, imgui.Key
        pressed = imgui.is_key_chord_pressed
        undo = not typing and pressed(chord.mod_ctrl | chord.z)
        redo = not typing and (pressed(chord.mod_ctrl | chord.y) or pressed(chord.mod_ctrl | chord.mod_shift | chord.z))
        if _button(imgui, icon("undo"), bench.history.undo_label, "undo", "Ctrl Z") or undo:
            self._say(app, bench.undo(), "undone: {}", "nothing to undo")
        imgui.same_line()
        if _button(imgui, icon("redo"), bench.history.redo_label, "redo", "Ctrl Y") or redo:
            self._say(app, bench.redo(), "done again: {}", "nothing to do again")
        imgui.same_line()
        if imgui.button(f"{icon('swap')} {bench.slot}###ab"):
            self._refused(app, bench.switch())
        other = "B" if bench.slot == "A" else "A"
        imgui.set_item_tooltip(
            f"Compare: this is {bench.slot}; click for {other}" + ("" if bench.comparing else ", at first the same")
        )
        imgui.same_line()
        if imgui.button(icon("copy", "TOML###copy")):
            imgui.set_clipboard_text(self.toml())
            app.say("copied what differs from the preset, as TOML")
        imgui.set_item_tooltip("Copies what differs from the preset: tables of a scene file, then quality")
        imgui.same_line()
        imgui.set_next_item_width(-imgui.calc_text_size(icon("save", "save...")).x - 4 * imgui.get_font_size() / 2.5)
        chosen = combo(imgui, "##preset", self._preset, _built_in, preset_names, heading="yours")
        imgui.set_item_tooltip("The planet, or a scene of yours: loads it here, as one step that can be undone")
        if chosen is not None:
            self.load(app, chosen)
        imgui.same_line()
        if imgui.button(icon("save", "save...###save")):
            self._name = "" if self._preset in planets() else self._preset
            imgui.open_popup("save as")
        self._save_popup(imgui, app)
        if self.wrong:
            imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(1.0, 0.45, 0.4, 1.0))
            imgui.text_wrapped(self.wrong)
            imgui.pop_style_color()

    def _save_popup(self, imgui: ImGui, app: Flight) -> None:
        if not imgui.begin_popup("save as"):
            return
        imgui.text("Save this scene as")
        entered, self._name = imgui.input_text(
            "##name", self._name, imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.auto_select_all
        )
        there = self._name.strip() in preset_names()
        imgui.same_line()
        if (imgui.button("replace" if there else "save") or entered) and self.save(app, self._name):
            imgui.close_current_popup()
        imgui.text_disabled("The one that is there is kept beside it as .old" if there else "F3 lists it as yours")
        imgui.end_popup()

    def load(self, app: Flight, name: str) -> bool:
        """Make the scene that of a preset; whether that worked. What is wrong is shown and nothing changes."""
        try:
            parts, missing = {**load_parts(name), **self._companion_parts(name)}, left_out(name)
        except (SettingError, UnknownNameError, SceneError) as error:
            self._refused(app, str(error))
            return False
        bench = self.bench
        above_m = app.ship.altitude_m
        headings = {*_SCENE_HEADINGS, *parts}
        if not headings <= {*_SCENE_HEADINGS}:  # its companions take the place of those that are there
            headings |= {h for n in self._scene.companions for h in self._store.companion_parts(n)}
        if self._refused(app, bench.to(parts, f"load {name}", headings)):
            return False
        bench.base = {**{k: v for k, v in bench.base.items() if k not in headings}, **parts}
        self._preset = name
        app.ship.position_m = app.ship.position_m * (
            (app.planets.handle.radius_m + above_m) / max(float((app.ship.position_m**2).sum()) ** 0.5, 1e-9)
        )
        but = f" but for its {', '.join(missing)}: start with it to have all of it" if missing else ""
        app.say(f"loaded {name}{but}")
        return True

    def _companion_parts(self, name: str) -> dict[str, Any]:
        """The parts of the companions that a preset has; their names are new where the scene's own planet has one."""
        found: dict[str, Any] = {}
        for described, orbit in load_companions(name):
            own = described.name == self._scene.planet.name
            found |= self._store.expect(
                self._store.free_name(described.name) if own else described.name, scene_of(described), orbit
            )
        return found

    def save(self, app: Flight, name: str) -> bool:
        """Save the scene under a name; whether that worked."""
        try:
            path = save_preset(self._scene, name)
        except (OSError, OutputError, SettingError, SceneError) as error:
            self._refused(app, str(error))
            return False
        self._preset, self.wrong = path.stem, ""
        app.say(f"saved {path}")
        return True

    def toml(self) -> str:
        """What differs from the preset, as the tables of a scene file; quality knobs follow as comments, because they
        belong in a quality file or in overrides. Where something of a companion differs, all companions are told, as a
        file's own take the place of its base's."""
        names = {kind.__name__: table for table, kind in KINDS.items()}
        changed = self.bench.toml_tables()
        tables: dict[str, Any] = {names[h]: table for h, table in changed.items() if h in names and table}
        ours = {*names, *self._store.quality}
        if any(heading not in ours for heading in self.bench.differences()):
            tables["companions"] = [brief_companion(c) for c in self._scene.companions.values()]
        text = tomli_w.dumps(tables)
        gone = [
            names[h]
            for h, fields in self.bench.differences().items()
            if h in names and fields.get("", (0, 0))[1] is None
        ]
        text = "".join(f"# without [{name}]\n" for name in gone) + text
        quality = {h.partition(".")[2]: t for h, t in changed.items() if h.startswith(f"{QUALITY_HEADING}.")}
        if quality:
            lines = tomli_w.dumps(quality).strip().splitlines()
            text += f"\n# quality, on top of {self._store.preset!r}:\n" + "".join(
                f"# {x}\n" if x else "#\n" for x in lines
            )
        return text.lstrip("\n") or "# nothing differs from the preset\n"

    def _refused(self, app: Flight, wrong: str) -> bool:
        self.wrong = wrong
        if wrong:
            log.info("panel: %s", wrong)
            app.say(wrong.splitlines()[0])
        return bool(wrong)

    def _say(self, app: Flight, label: str, done: str, nothing: str) -> None:
        self.wrong = ""
        app.say(done.format(label) if label else nothing)

    def _planet_page(self, imgui: ImGui, app: Flight) -> None:
        self.planets.draw(imgui, app, self._preset)

    # -- quality -----------------------------------------------------------------------------------------------------

    def _quality_page(self, imgui: ImGui, app: Flight) -> None:
        bench, store = self.bench, self._store
        imgui.set_next_item_width(12.0 * imgui.get_font_size())
        chosen = combo(imgui, "preset", store.preset, qualities, tips=QUALITY.about)
        imgui.text_wrapped("Changes are applied when you let go; shaders may be made anew, which takes a moment.")
        self._quality_panel.draw_search()
        parts = {h.partition(".")[2]: part for h, part in store.quality.items() if "." in h}
        base = {h: bench.base.get(f"{QUALITY_HEADING}.{h}") for h in parts}
        for heading, changes in self._quality_panel.draw_all(parts, base, search=False).items():
            self._refused(app, bench.made(f"{QUALITY_HEADING}.{heading}", changes))
        if chosen is not None:
            bench.to({**bench.copy(), **store.preset_parts(chosen)}, f"quality {chosen}")

    def _follow_app(self, app: Flight) -> None:
        """Quality that somebody else has changed is taken over."""
        if self._known_quality != (app.quality, app.overrides):
            self._known_quality = _Quality(app.quality, dict(app.overrides))
            self._store.take_quality(app.quality, app.overrides)
        if self.bench.base[QUALITY_HEADING].preset != self._store.preset:
            self.bench.base = {**self.bench.base, **self._store.preset_parts(self._store.preset)}

    def _make_quality(self, app: Flight) -> None:
        """Have the app render with the quality that is wanted."""
        store = self._store
        if self.bench.base[QUALITY_HEADING].preset != store.preset:
            self.bench.base = {**self.bench.base, **store.preset_parts(store.preset)}
        stamp = latest_revision(*(type(part) for part in store.quality.values()))
        if stamp == self._quality_stamp:
            return
        self._quality_stamp = stamp
        wanted = (store.preset, store.overrides(self.bench.base, app.overrides))
        if wanted == (app.quality, app.overrides):
            return
        app.set_quality(*wanted)
        if (app.quality, app.overrides) != wanted:  # refused; the app has said why
            self.bench.history.forget_last()
            store.take_quality(app.quality, app.overrides)
        self._known_quality = _Quality(app.quality, dict(app.overrides))


def _built_in() -> list[str]:
    return [*planets(), *scenes()]


def _button(imgui: ImGui, label: str, what: str, verb: str, keys: str) -> bool:
    imgui.begin_disabled(not what)
    pressed = imgui.button(f"{label}###{verb}")
    imgui.end_disabled()
    imgui.set_item_tooltip(f"{verb} {what} ({keys})" if what else f"nothing to {verb}")
    return pressed
