"""The page of the settings window that binds actions to keys, buttons and sticks, and keeps what was chosen."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from ..engine.gpu.imgui_type import ImGui
from ..engine.settings import PresetError
from ..engine.settings.user import user_folder
from ..systems.flight import ACTIONS, LOOKING, TWO_SIDED, Binding, Catch, Controls, load_controls, rebind, rivals
from ..systems.tweak import icon
from ..systems.tweak.style import AMBER, BAD

if TYPE_CHECKING:
    from ..engine.input import InputState
    from .flight import Flight

__all__ = ["ControlsPage", "keep_controls"]

log = logging.getLogger(__name__)


class ControlsPage:
    """Lists all actions with what they are bound to. A click on a key waits for the one to take its place.

    Every change is written to controls.toml in the user's settings folder at once. file: another one.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._catch: Catch | None = None
        self._replaces: Binding | None = None
        self._clash: tuple[str, Binding, tuple[str, ...]] | None = None
        self._kept_old = self._numbers_changed = False
        self._wrong = ""

    @property
    def waiting(self) -> bool:
        """Whether the next key is to be bound: then it does nothing else."""
        return self._catch is not None

    def take(self, state: InputState, app: Flight) -> None:
        """Look for the key while one is waited for."""
        catch = self._catch
        if catch is None:
            return
        found = catch.take(state)
        if not catch.ended:
            return
        self._catch = None
        if catch.ended == "cancelled":
            return
        self._bind(app, catch.action, self._replaces, found)
        others = rivals(app.controls).get(catch.action, {}).get(found, ()) if found is not None else ()
        self._clash = (catch.action, found, others) if found is not None and others else None

    def draw(self, imgui: ImGui, app: Flight) -> None:
        """One frame of the page."""
        if self._catch is not None:
            imgui.text_colored(
                imgui.ImVec4(*AMBER), f"{ACTIONS[self._catch.action]}: press a key or a button, or push a stick"
            )
            also = "; or move the mouse" if self._catch.action in LOOKING else ""
            imgui.text_disabled(f"Escape leaves it as it is, Delete takes this one off{also}")
        else:
            imgui.text_wrapped("Click on a key to put another in its place, on + for one more.")
        if self._wrong:
            imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*BAD))
            imgui.text_wrapped(self._wrong)
            imgui.pop_style_color()
        self._ask(imgui, app)
        self._numbers(imgui, app)
        defaults = load_defaults()
        imgui.begin_disabled(app.controls.table() == defaults.table())
        if imgui.button(icon("reset", "reset all controls") + "###reset all controls"):
            app.controls = load_controls()
            self._save(app)
            self._clash = None
        imgui.end_disabled()
        clashes = rivals(app.controls, defaults)
        if imgui.begin_table("actions", 3, imgui.TableFlags_.row_bg):
            imgui.table_setup_column("action", imgui.TableColumnFlags_.width_stretch, 0.45)
            imgui.table_setup_column("keys", imgui.TableColumnFlags_.width_stretch, 0.55)
            imgui.table_setup_column("reset", imgui.TableColumnFlags_.width_fixed, imgui.get_frame_height())
            for action, text in ACTIONS.items():
                imgui.push_id(action)
                self._row(imgui, app, action, text, defaults, clashes.get(action, {}))
                imgui.pop_id()
            imgui.end_table()

    def _row(
        self,
        imgui: ImGui,
        app: Flight,
        action: str,
        text: str,
        defaults: Controls,
        clashes: dict[Binding, tuple[str, ...]],
    ) -> None:
        bound = app.controls.bindings.get(action, ())
        changed = bound != defaults.bindings.get(action, ())
        imgui.table_next_row()
        imgui.table_next_column()
        imgui.align_text_to_frame_padding()
        imgui.push_text_wrap_pos(0.0)
        if changed:
            imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*AMBER))
        imgui.text(text)
        if changed:
            imgui.pop_style_color()
        imgui.pop_text_wrap_pos()
        imgui.table_next_column()
        right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
        for number, binding in enumerate(bound):
            label = ("- " if binding.sign < 0.0 else "") + binding.shown
            self._beside(imgui, number, label, right)
            clash = clashes.get(binding)
            if clash:
                imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*BAD))
            if imgui.button(f"{label}###{action} {binding}"):
                self._wait(action, binding.sign, binding)
            if clash:
                imgui.pop_style_color()
                imgui.set_item_tooltip("also: " + "; ".join(ACTIONS[other] for other in clash))
        self._beside(imgui, len(bound), "+", right)
        if imgui.button(f"+###+ {action}"):
            self._wait(action, 1.0, None)
        imgui.set_item_tooltip("one more key" + (", button or axis" if action in TWO_SIDED else " or button"))
        if action in TWO_SIDED:
            self._beside(imgui, 1, "-", right)
            if imgui.button(f"-###- {action}"):
                self._wait(action, -1.0, None)
            imgui.set_item_tooltip("one more for the other way")
        imgui.table_next_column()
        if changed and imgui.button(f"{icon('reset')}###reset {action}"):
            app.controls.bindings[action] = defaults.bindings.get(action, ())
            self._save(app)

    @staticmethod
    def _beside(imgui: ImGui, number: int, label: str, right: float) -> None:
        """The next button in the same line, where it has room."""
        wide = imgui.calc_text_size(label).x + 2.0 * imgui.get_style().frame_padding.x
        gap = imgui.get_style().item_spacing.x
        if number and imgui.get_item_rect_max().x + gap + wide < right:
            imgui.same_line()

    def _wait(self, action: str, sign: float, replaces: Binding | None) -> None:
        self._catch, self._replaces, self._clash = Catch(action, sign), replaces, None

    def _ask(self, imgui: ImGui, app: Flight) -> None:
        """A key that two actions have now: whose is it?"""
        if self._clash is None:
            return
        action, binding, others = self._clash
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*BAD))
        imgui.text_wrapped(f"{binding.shown} is also: {'; '.join(ACTIONS[other] for other in others)}.")
        imgui.pop_style_color()
        if imgui.button("take it from there"):
            slot = (binding.kind, binding.name, binding.modifier)
            for other in others:
                for theirs in app.controls.bindings.get(other, ()):
                    if (theirs.kind, theirs.name, theirs.modifier) == slot:
                        rebind(app.controls, other, theirs, None)
            self._save(app)
            self._clash = None
        imgui.same_line()
        if imgui.button("keep both"):
            self._clash = None
        imgui.same_line()
        if imgui.button("not here"):
            self._bind(app, action, binding, self._replaces)
            self._clash = None

    def _numbers(self, imgui: ImGui, app: Flight) -> None:
        controls, logarithmic = app.controls, imgui.SliderFlags_.logarithmic
        imgui.push_item_width(-12.0 * imgui.get_font_size())
        for label, name, low, high, shape, flags in (
            ("mouse [rad a pixel]", "look_rad_per_pixel", 1e-4, 0.02, "%.4f", logarithmic),
            ("stick [rad/s]", "look_rad_per_s", 0.1, 10.0, "%.2f", 0),
            ("dead zone of sticks", "dead_zone", 0.0, 0.9, "%.2f", 0),
        ):
            # ImGui's numbers are f32: what was not dragged keeps its own.
            changed, value = imgui.slider_float(label, getattr(controls, name), low, high, shape, flags)
            if changed:
                setattr(controls, name, float(f"{min(max(value, low), high):.4g}"))
                self._numbers_changed = True
        toggled, on = imgui.checkbox("up is down for the mouse", controls.invert_y)
        if toggled:
            controls.invert_y, self._numbers_changed = on, True
        imgui.pop_item_width()
        if self._numbers_changed and not imgui.is_any_item_active():  # a drag is written once
            self._numbers_changed = False
            self._save(app)

    def _bind(self, app: Flight, action: str, old: Binding | None, new: Binding | None) -> None:
        try:
            rebind(app.controls, action, old, new)
        except PresetError as error:
            self._wrong = str(error)
            return
        self._save(app)

    def _save(self, app: Flight) -> None:
        path = user_folder() / "controls.toml" if self._file is None else self._file
        try:
            keep_controls(app.controls, path, keep_old=not self._kept_old)
        except PresetError as error:
            self._wrong = f"The controls are changed, but could not be kept: {error}"
            log.warning("%s", self._wrong)
            return
        self._kept_old, self._wrong = True, ""
        app.say(f"kept in {path}")


_DEFAULTS: list[Controls] = []


def load_defaults() -> Controls:
    """The default controls, read once; not to be changed."""
    if not _DEFAULTS:
        _DEFAULTS.append(load_controls())
    return _DEFAULTS[0]


def keep_controls(controls: Controls, path: Path, keep_old: bool) -> None:
    """Write the user's controls. keep_old: a file that is there, with its comments or whatever is wrong in it, stays
    beside as NAME.old. PresetError when anything can't be written: then the file is as it was."""
    if keep_old and path.exists():
        beside = path.with_name(f".{path.name}.old.tmp")
        try:
            shutil.copy2(path, beside)
            beside.replace(path.with_name(f"{path.name}.old"))
        except OSError as error:
            beside.unlink(missing_ok=True)
            raise PresetError(f"{path} is there and can't be kept as {path.name}.old: {error}") from error
    controls.save(path)
