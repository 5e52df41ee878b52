"""The widget for one field: takes its value, returns the value that the user wants."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...engine.gpu.imgui_type import ImGui
from ...engine.settings import FieldRule

__all__ = ["edit"]

_SLIDER_SPAN = 1000.0
"""Wider ranges are dragged, not slid: a pixel of a slider would be too large a step."""

_F32_WHOLE = 1e7
"""Beyond this ImGui's f32 widgets lose whole numbers: the number is typed."""

_F32_PLACE = 1e5
"""Vectors with larger numbers are places on a planet, which f32 widgets would move by centimetres: they are typed."""

_DIGITS = 6


def edit(imgui: ImGui, rule: FieldRule, value: Any) -> Any:
    """Draw the widget of a field (labels hidden); returns `value` itself while nothing was changed."""
    if rule.kind in ("rows", "function"):  # what a game gives in Python
        given = len(value) if rule.kind == "rows" else value is not None and getattr(value, "__name__", "set")
        imgui.text_disabled(str(given or "none"))
        return value
    if rule.optional:
        width = imgui.calc_item_width()
        toggled, wanted = imgui.checkbox("##set", value is not None)
        if toggled:
            return _first_value(rule) if wanted else None
        if value is None:
            imgui.same_line()
            imgui.text_disabled("not set")
            return value
        imgui.same_line()
        box = imgui.get_frame_height() + imgui.get_style().item_spacing.x
        imgui.set_next_item_width(width - box)
    if rule.kind == "bool":
        return bool(imgui.checkbox("##value", value)[1])
    if rule.kind == "str":
        return _text(imgui, rule, value)
    if rule.kind == "vector":
        return _vector(imgui, rule, value)
    return _integer(imgui, rule, value) if rule.kind == "int" else _number(imgui, rule, value)


def _text(imgui: ImGui, rule: FieldRule, value: str) -> str:
    knob = rule.knob
    if not knob.choices:
        changed, text = imgui.input_text("##value", value, imgui.InputTextFlags_.enter_returns_true)
        return text if changed else value
    result = value
    if imgui.begin_combo("##value", value):
        for choice in knob.choices:
            if imgui.selectable(choice, choice == value)[0]:
                result = choice
        for choice in knob.not_yet:
            imgui.begin_disabled()
            imgui.selectable(f"{choice} (not in this version)", False)
            imgui.end_disabled()
        imgui.end_combo()
    return result


def _integer(imgui: ImGui, rule: FieldRule, value: int) -> int:
    low, high = rule.knob.low, rule.knob.high
    if rule.knob.power_of_two and low is not None and high is not None:
        powers = [1 << k for k in range(int(high).bit_length()) if low <= 1 << k <= high]
        index = powers.index(value) if value in powers else 0
        changed, index = imgui.combo("##value", index, [str(p) for p in powers])
        return powers[index] if changed else value
    if low is not None and high is not None and high - low <= _SLIDER_SPAN:
        flags = imgui.SliderFlags_.always_clamp | (imgui.SliderFlags_.logarithmic if rule.knob.log else 0)
        return int(imgui.slider_int("##value", value, int(low), int(high), "%d", flags)[1])
    changed, wanted = imgui.input_int("##value", value, 1, 100)
    return int(_clamped(wanted, low, high)) if changed else value


def _number(imgui: ImGui, rule: FieldRule, value: float) -> float:
    low, high = rule.knob.low, rule.knob.high
    flags = imgui.SliderFlags_.always_clamp
    if low is not None and high is not None and (rule.knob.log or high - low <= _SLIDER_SPAN):
        if rule.knob.log:
            flags |= imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.no_round_to_format
        changed, wanted = imgui.slider_float("##value", value, low, high, _format(value), flags)
    elif max(abs(low or 0.0), abs(high or 0.0), abs(value)) > _F32_WHOLE or low is None or high is None:
        enter = imgui.InputTextFlags_.enter_returns_true
        changed, wanted = imgui.input_double("##value", value, 0.0, 0.0, "%.12g", enter)
        return float(_clamped(wanted, low, high)) if changed else value
    else:
        changed, wanted = imgui.drag_float("##value", value, _speed(rule, value), low, high, _format(value), flags)
    return _rounded(wanted, low, high) if changed else value


def _vector(imgui: ImGui, rule: FieldRule, value: tuple[float, ...]) -> tuple[float, ...]:
    low, high = rule.knob.low, rule.knob.high
    largest = max((abs(v) for v in value), default=0.0)
    if largest > _F32_PLACE:
        return _typed_vector(imgui, rule, value)
    if rule.knob.widget == "color" and rule.length == 3:
        flags = imgui.ColorEditFlags_.float | imgui.ColorEditFlags_.display_rgb
        changed, wanted = imgui.color_edit3("##value", list(value), flags)
    elif rule.length in (2, 3, 4):
        flags = imgui.SliderFlags_.always_clamp
        drag = {2: imgui.drag_float2, 3: imgui.drag_float3, 4: imgui.drag_float4}[rule.length]
        speed = 0.01 if rule.knob.widget == "direction" else _speed(rule, largest)
        # Without limits ImGui clamps nothing; equal ones mean the same.
        changed, wanted = drag("##value", list(value), speed, low or 0.0, high or 0.0, "%.5g", flags)
    else:
        imgui.text(", ".join(f"{v:.5g}" for v in value))
        return value
    if not changed:
        return value
    # Only what was changed is rounded: the other numbers keep all their digits.
    if rule.knob.widget == "place":
        return _clamped(_rounded(wanted[0], None, None), -90.0, 90.0), _rounded(wanted[1], -360.0, 360.0)
    return tuple(
        old if math.isclose(old, new, rel_tol=1e-6, abs_tol=0.0) else _rounded(new, low, high)
        for old, new in zip(value, wanted, strict=True)
    )


def _typed_vector(imgui: ImGui, rule: FieldRule, value: tuple[float, ...]) -> tuple[float, ...]:
    """Each number on a line of its own, in double precision."""
    numbers = list(value)
    for axis, old in enumerate(value):
        imgui.set_next_item_width(-1.0)
        enter = imgui.InputTextFlags_.enter_returns_true
        changed, wanted = imgui.input_double(f"##{axis}", old, 0.0, 0.0, "%.12g", enter)
        if changed:
            numbers[axis] = float(_clamped(wanted, rule.knob.low, rule.knob.high))
    return tuple(numbers) if numbers != list(value) else value


def _first_value(rule: FieldRule) -> Any:
    """What a field becomes when it is switched on: something near zero that it accepts."""
    if rule.kind == "vector":
        return (1.0,) + (0.0,) * (rule.length - 1)
    if rule.kind == "str":
        return rule.knob.choices[0] if rule.knob.choices else ""
    if rule.kind == "bool":
        return True
    zero = _clamped(0.0, rule.knob.low, rule.knob.high)
    return int(zero) if rule.kind == "int" else zero


def _speed(rule: FieldRule, value: float) -> float:
    """Change for each pixel that is dragged: in proportion to the value, and not zero at zero."""
    if rule.knob.log and rule.default:
        # Values over many powers of ten, such as air per metre: the default says how small the usual ones are.
        return 0.005 * max(abs(value), float(np.max(np.abs(rule.default))))
    low, high = rule.knob.low, rule.knob.high
    span = high - low if low is not None and high is not None else 1.0
    return max(abs(value) * 0.005, 10.0 ** (math.floor(math.log10(span)) - 5))


def _format(value: float) -> str:
    return "%.5g" if abs(value) < 1e5 else "%.7g"


def _rounded(value: float, low: float | None, high: float | None) -> float:
    return float(_clamped(float(f"{value:.{_DIGITS}g}"), low, high))


def _clamped(value: float, low: float | None, high: float | None) -> float:
    if low is not None and value < low:
        return low
    return high if high is not None and value > high else value
