"""A field that is a list of parts, such as explicit waves or layers of cloud: add, remove, copy, and their knobs.

The list is a tuple that is never changed in place: an edit makes a new one, and undo brings back the old one itself.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from ...engine.gpu.imgui_type import ImGui
from ...engine.settings import FieldRule, rules_of
from .style import AMBER, QUIET, icon

__all__ = ["choose", "draw_list", "item_kind", "summary"]

_ROWS = 6.5
"""Of a list that are seen at once; half a row says that there are more."""

Rows = Callable[[Any], dict[str, Any]]


def item_kind(rule: FieldRule) -> Any:
    """The class of a list's parts; None for a field that is no list."""
    return {"list": rule.schema, "tables": rule.table}.get(rule.kind)


def summary(item: object) -> str:
    """A part in a line: its first numbers, with their units."""
    shown = []
    for rule in rules_of(type(item)).values():
        value = getattr(item, rule.name)
        if rule.kind in ("float", "int") and value is not None:
            shown.append(f"{rule.name.removesuffix('_' + rule.knob.unit).replace('_', ' ')} {value:.5g}")
    return ", ".join(shown[:3])


def draw_list(
    imgui: ImGui, rule: FieldRule, items: tuple[Any, ...], default: tuple[Any, ...], selected: int, rows: Rows
) -> tuple[tuple[Any, ...], int]:
    """Draw a list with the knobs of its selected part below; the list and the selection that the user wants.

    rows(part): draws its knobs and returns {field: new value} of what was changed. Returns `items` itself while nothing
    was.
    """
    kind = item_kind(rule)
    noun = kind.__name__.lower()
    selected = min(max(selected, 0), max(len(items) - 1, 0))
    wanted = items
    imgui.push_id(rule.name)
    imgui.align_text_to_frame_padding()
    title = f"{rule.name.replace('_', ' ')}: {len(items) or 'none'}"
    if items != default:
        imgui.text_colored(imgui.ImVec4(*AMBER), title)
    else:
        imgui.text(title)
    imgui.set_item_tooltip(rule.knob.help)
    imgui.same_line()
    if imgui.button(f"{icon('add', 'add')}###add {noun}"):
        wanted, selected = (*items, kind()), len(items)
    imgui.set_item_tooltip(f"one more {noun}, as it is by default")
    imgui.same_line()
    imgui.begin_disabled(not items)
    if imgui.button(f"{icon('copy', 'copy')}###copy {noun}"):
        wanted, selected = (*items[: selected + 1], items[selected], *items[selected + 1 :]), selected + 1
    imgui.set_item_tooltip("another one like the selected")
    imgui.same_line()
    if imgui.button(f"{icon('off', 'remove')}###remove {noun}"):
        wanted = (*items[:selected], *items[selected + 1 :])
        selected = max(min(selected, len(wanted) - 1), 0)
    imgui.end_disabled()
    if items != default:
        imgui.same_line()
        if imgui.button(f"{icon('reset')}###reset {noun}"):
            wanted = default
        imgui.set_item_tooltip(f"back to {len(default) or 'none'}")
    changes: dict[str, Any] = {}
    if wanted is items and items:
        selected = choose(imgui, len(items), lambda k: (f"{noun} {k + 1}", summary(items[k])), selected)
        imgui.push_id(selected)
        changes = rows(items[selected])
        imgui.pop_id()
    imgui.pop_id()
    if changes:  # which the part may refuse: not before all that was begun for ImGui has ended
        changed = dataclasses.replace(items[selected], **changes)
        wanted = (*items[:selected], changed, *items[selected + 1 :])
    return wanted, selected


def choose(imgui: ImGui, count: int, label: Callable[[int], tuple[str, str]], selected: int) -> int:
    """A row for each part, with a name and a description; only those in sight are made: a thousand cost no more than
    ten. Returns which one is selected."""
    height = min(count, _ROWS) * imgui.get_text_line_height_with_spacing() + imgui.get_style().item_spacing.y
    if imgui.begin_child("parts", imgui.ImVec2(0.0, height), imgui.ChildFlags_.frame_style):
        clipper = imgui.ListClipper()
        clipper.begin(count)
        while clipper.step():
            for number in range(clipper.display_start, clipper.display_end):
                name, text = label(number)
                imgui.push_id(number)
                if imgui.selectable(name, number == selected)[0]:
                    selected = number
                imgui.pop_id()
                imgui.same_line(7.0 * imgui.get_font_size())
                imgui.text_colored(imgui.ImVec4(*QUIET), text)
    imgui.end_child()
    return selected
