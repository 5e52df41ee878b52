"""A settings panel made from the knobs of any component: slider, checkbox, list, vector or colour by type.

Nothing here names a component or a field: a new knob appears by itself, with its range, unit, help and cost.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from ...engine.gpu.imgui_type import ImGui
from ...engine.settings import FieldRule, SettingError, rules_of
from .list_editor import draw_list, item_kind
from .style import AMBER, BAD, QUIET, icon
from .widgets import edit

__all__ = ["Change", "Panel"]

log = logging.getLogger(__name__)

_UNIT_SUFFIXES = ("_px", "_ev", "_deg", "_rad", "_per_m", "_m_s", "_nm", "_m", "_s")


class Change(NamedTuple):
    """A field that was changed in the panel, with its value before and after."""

    field: str
    old: Any
    new: Any


class Panel:
    """Draws components inside an ImGui frame and reports what the user changed.

    search: only fields whose name, help or group contains these words are drawn. only_changed: only those that differ
    from their default. Both may be set from code, or by the user with `draw_search`. unfold: headings that open with
    the next frame.
    """

    def __init__(self) -> None:
        self.search = ""
        self.only_changed = False
        self.unfold: set[str] = set()
        self._heading = ""
        self.errors: dict[tuple[str, str], str] = {}
        """What was not allowed, by component and field, until it is put right."""
        self._selected: dict[tuple[str, str], int] = {}

    def draw_search(self) -> None:
        """The search field, and the switch that leaves only what was changed."""
        from imgui_bundle import imgui

        em = imgui.get_font_size()
        imgui.set_next_item_width(-6.5 * em)
        _, self.search = imgui.input_text_with_hint("##search", icon("search", "search names and help"), self.search)
        imgui.same_line()
        _, self.only_changed = imgui.checkbox("changed", self.only_changed)
        imgui.set_item_tooltip("only what differs from the preset")

    def draw(self, component: Any, preset: Any = None, *, apply: bool = True, heading: str = "") -> list[Change]:
        """Draw all knobs of a component; returns this frame's changes, usually none.

        preset: a component of the same type whose values are the defaults to mark against and to reset to; None takes
        those of the class. apply: assign changes to the component. A value that it refuses is not applied and not
        reported; the panel shows why. heading: tells components of one type apart; left out, the name of its class.
        """
        from imgui_bundle import imgui

        changes: list[Change] = []
        kind = type(component)
        self._heading = heading or kind.__name__
        imgui.push_id(self._heading)
        lists, searching = _lists(kind), bool(self.search.strip()) or self.only_changed
        for group, rules in _groups(kind):
            shown = rules
            if searching:
                shown = [rule for rule in rules if self._matches(kind, rule, component, preset)]
            if not shown:
                continue
            if group:
                imgui.separator_text(group)
            plain = [rule for rule in shown if rule.name not in lists] if lists else shown
            if plain and _begin_rows(imgui, group):
                for rule in plain:
                    changes += self._row(imgui, component, rule, _default(rule, preset), apply)
                imgui.end_table()
            for rule in shown if lists else ():
                if rule.name in lists:
                    changes += self._list(imgui, component, rule, _default(rule, preset), apply)
        imgui.pop_id()
        return changes

    def draw_all(
        self,
        components: Mapping[str, Any],
        presets: Mapping[str, Any] | None = None,
        *,
        apply: bool = True,
        search: bool = True,
    ) -> dict[str, list[Change]]:
        """Search field and a collapsible section for each component {heading: component}; headings with changes.

        search: False where the search field has been drawn already, or is not wanted.
        """
        from imgui_bundle import imgui

        if search:
            self.draw_search()
        searching = bool(self.search.strip()) or self.only_changed
        found: dict[str, list[Change]] = {}
        for heading, component in components.items():
            preset = (presets or {}).get(heading)
            rules = rules_of(type(component)).values()
            if searching and not any(self._matches(type(component), r, component, preset) for r in rules):
                continue
            if searching or heading in self.unfold:
                self.unfold.discard(heading)
                imgui.set_next_item_open(True)
            count = sum(_differs(component, r, preset) for r in rules)
            if count:
                imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*AMBER))
            opened = imgui.collapsing_header(
                f"{heading}   {count} changed###{heading}" if count else f"{heading}###{heading}"
            )
            if count:
                imgui.pop_style_color()
            if opened:
                changes = self.draw(component, preset, apply=apply, heading=heading)
                if changes:
                    found[heading] = changes
        return found

    def _matches(self, kind: type, rule: FieldRule, component: Any, preset: Any) -> bool:
        if self.only_changed and not _differs(component, rule, preset):
            return False
        words = self.search.lower().split()
        text = f"{kind.__name__} {rule.name} {rule.name.replace('_', ' ')} {rule.knob.help} {rule.knob.group}".lower()
        inner = item_kind(rule)
        if inner is not None:
            text += " " + " ".join(f"{name} {name.replace('_', ' ')}" for name in rules_of(inner))
        return all(word in text for word in words)

    def _list(self, imgui: ImGui, component: Any, rule: FieldRule, default: Any, apply: bool) -> list[Change]:
        """A list of parts with the knobs of one of them; a change is one of the whole list."""
        kind, key = item_kind(rule), (self._heading, rule.name)
        old = getattr(component, rule.name)

        def rows(item: Any) -> dict[str, Any]:
            changed: dict[str, Any] = {}
            for group, rules in _groups(kind):
                if group:
                    imgui.separator_text(group)
                if _begin_rows(imgui, group):
                    for inner in rules:
                        if item_kind(inner) is None:
                            for change in self._row(imgui, item, inner, inner.default, apply=False):
                                changed[change.field] = change.new
                    imgui.end_table()
            return changed

        changes: list[Change] = []
        try:
            wanted, self._selected[key] = draw_list(imgui, rule, old, default, self._selected.get(key, 0), rows)
            if wanted is not old:
                self.errors.pop(key, None)
                if apply:
                    setattr(component, rule.name, wanted)
                    wanted = getattr(component, rule.name)
                changes.append(Change(rule.name, old, wanted))
        except SettingError as error:
            self.errors[key] = str(error)
            log.info("panel: %s", error)
        if key in self.errors:
            imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*BAD))
            imgui.text_wrapped(self.errors[key])
            imgui.pop_style_color()
        return changes

    def _row(self, imgui: ImGui, component: Any, rule: FieldRule, default: Any, apply: bool) -> list[Change]:
        old, key = getattr(component, rule.name), (self._heading, rule.name)
        imgui.table_next_row()
        imgui.table_next_column()
        # Most rows of a long page are scrolled out of sight; while one is used, all are there for the tabulator key.
        size = imgui.ImVec2(1.0, imgui.get_frame_height())
        one_line = rule.kind != "vector" and key not in self.errors
        if one_line and not imgui.is_rect_visible(size) and not imgui.is_any_item_active():
            imgui.dummy(size)
            return []
        changed = old != default
        imgui.push_id(rule.name)
        wanted = old
        imgui.align_text_to_frame_padding()
        if changed:
            imgui.text_colored(imgui.ImVec4(*AMBER), _label(rule))
        else:
            imgui.text(_label(rule))
        hovered = imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip)
        imgui.table_next_column()
        imgui.push_item_width(-1.0)
        edited = edit(imgui, rule, old)
        imgui.pop_item_width()
        hovered = hovered or imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip)
        if hovered:
            self._tooltip(imgui, type(component), rule, default)
        imgui.table_next_column()
        if changed:  # its column stays when there is nothing to reset, so that nothing moves under the pointer
            imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
            if imgui.button(icon("reset")):
                wanted = default
            imgui.pop_style_color()
            imgui.set_item_tooltip(f"back to {_shown(default)}")
        if edited != old:
            wanted = edited
        changes: list[Change] = []
        if wanted != old:
            self.errors.pop(key, None)
            others = {name: getattr(component, name) for name in rule.knob.excludes}
            try:
                if apply:
                    setattr(component, rule.name, wanted)
                    wanted = getattr(component, rule.name)
                changes.append(Change(rule.name, old, wanted))
                for name, before in others.items():  # setting one of several ways may have switched off another
                    if getattr(component, name) != before:
                        changes.append(Change(name, before, getattr(component, name)))
            except SettingError as error:
                self.errors[key] = str(error)
                log.info("panel: %s", error)
        if key in self.errors:
            imgui.table_next_row()
            imgui.table_next_column()
            imgui.table_next_column()
            imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*BAD))
            imgui.text_wrapped(self.errors[key])
            imgui.pop_style_color()
        imgui.pop_id()
        return changes

    @staticmethod
    def _tooltip(imgui: ImGui, kind: type, rule: FieldRule, default: Any) -> None:
        if not imgui.begin_tooltip():
            return
        imgui.push_text_wrap_pos(imgui.get_font_size() * 28.0)
        imgui.text(rule.knob.help or rule.name)
        if rule.knob.cost:
            imgui.text(f"Cost: {rule.knob.cost}")
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*QUIET))
        imgui.text(f"{kind.__name__}.{rule.name}: {rule.expected}; default {_shown(default)}")
        imgui.pop_style_color()
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


@lru_cache(maxsize=256)
def _groups(kind: type) -> list[tuple[str, list[FieldRule]]]:
    """Fields by heading, in order of declaration; those without a heading first."""
    groups: dict[str, list[FieldRule]] = {"": []}
    for rule in rules_of(kind).values():
        groups.setdefault(rule.knob.group, []).append(rule)
    return list(groups.items())


@lru_cache(maxsize=256)
def _lists(kind: type) -> frozenset[str]:
    """Names of the fields that are lists of parts."""
    return frozenset(rule.name for rule in rules_of(kind).values() if item_kind(rule) is not None)


def _begin_rows(imgui: ImGui, group: str) -> bool:
    """Begin the table of a group's rows: name, value, reset."""
    if not imgui.begin_table(group or "##plain", 3, imgui.TableFlags_.no_pad_outer_x):
        return False
    imgui.table_setup_column("name", imgui.TableColumnFlags_.width_stretch, 0.43)
    imgui.table_setup_column("value", imgui.TableColumnFlags_.width_stretch, 0.57)
    imgui.table_setup_column("reset", imgui.TableColumnFlags_.width_fixed, imgui.get_frame_height())
    return True


def _default(rule: FieldRule, preset: Any) -> Any:
    return rule.default if preset is None else getattr(preset, rule.name)


def _differs(component: Any, rule: FieldRule, preset: Any) -> bool:
    return getattr(component, rule.name) != _default(rule, preset)


@lru_cache(maxsize=1024)
def _label_of(name: str, unit: str) -> str:
    if unit:
        for suffix in _UNIT_SUFFIXES:
            if name.endswith(suffix):
                name = name.removesuffix(suffix)
                break
    text = name.replace("_", " ")
    return f"{text} [{unit}]" if unit else text


def _label(rule: FieldRule) -> str:
    return _label_of(rule.name, rule.knob.unit)


def _shown(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, float):
        return f"{value:.7g}"
    if isinstance(value, tuple):
        return "(" + ", ".join(f"{v:.5g}" for v in value) + ")"
    return str(value)
