"""How the panels look: fonts, colours, spacing, icons. Applied to one ImGui context, inside `ImguiBackend.current()`.

Text is Roboto and icons are Font Awesome, both from the imgui-bundle package; where they are missing, ImGui's own font
stands in and icons become words.
"""

from __future__ import annotations

import logging
from importlib.util import find_spec
from pathlib import Path

from ...engine.gpu.imgui_type import ImGui

__all__ = ["ACCENT", "AMBER", "BAD", "QUIET", "apply_style", "icon"]

log = logging.getLogger(__name__)

Color = tuple[float, float, float, float]

ACCENT: Color = (0.36, 0.68, 0.94, 1.0)
AMBER: Color = (1.0, 0.75, 0.3, 1.0)
"""What differs from the preset."""
BAD: Color = (1.0, 0.45, 0.4, 1.0)
QUIET: Color = (0.58, 0.62, 0.67, 1.0)

_TEXT: Color = (0.90, 0.92, 0.94, 1.0)
_GROUND: Color = (0.066, 0.078, 0.098, 1.0)
_RAISED: Color = (0.135, 0.155, 0.190, 1.0)
_HOVER: Color = (0.190, 0.220, 0.270, 1.0)
_HEADER: Color = (0.115, 0.150, 0.205, 1.0)
_LINE: Color = (0.22, 0.25, 0.30, 1.0)

# Font Awesome 6, solid.
_ICONS = {
    "undo": "\uf3e5",
    "redo": "\uf064",
    "reset": "\uf0e2",
    "copy": "\uf0c5",
    "save": "\uf0c7",
    "open": "\uf07c",
    "swap": "\uf24e",
    "search": "\uf002",
    "add": "\u002b",
    "off": "\uf00d",
    "warning": "\uf071",
}
_with_icons = False


def icon(name: str, text: str = "") -> str:
    """A label: the icon with a text behind it, or words alone where there are no icons."""
    sign = _ICONS[name] if _with_icons else ("" if text else name)
    return f"{sign}  {text}" if sign and text else sign or text


def apply_style(imgui: ImGui) -> None:
    """Give the current ImGui context these fonts and colours. Before its first frame."""
    _fonts(imgui)
    style = imgui.get_style()
    style.window_rounding = 6.0
    style.frame_rounding = style.grab_rounding = style.popup_rounding = style.tab_rounding = 4.0
    style.scrollbar_rounding, style.scrollbar_size = 6.0, 11.0
    style.window_border_size = style.popup_border_size = 1.0
    style.window_padding = imgui.ImVec2(10.0, 9.0)
    style.frame_padding = imgui.ImVec2(7.0, 3.0)
    style.item_spacing = imgui.ImVec2(7.0, 5.0)
    style.item_inner_spacing = imgui.ImVec2(6.0, 4.0)
    style.cell_padding = imgui.ImVec2(4.0, 2.0)
    style.grab_min_size = 9.0
    style.separator_text_border_size = 1.0
    for name, color in _colors().items():
        style.set_color_(getattr(imgui.Col_, name), imgui.ImVec4(*color))


def _colors() -> dict[str, Color]:
    def faded(color: Color, alpha: float) -> Color:
        return (*color[:3], alpha)

    return {
        "text": _TEXT,
        "text_disabled": QUIET,
        "window_bg": _GROUND,
        "popup_bg": faded(_GROUND, 0.98),
        "border": faded(_LINE, 0.6),
        "frame_bg": _RAISED,
        "frame_bg_hovered": _HOVER,
        "frame_bg_active": _HOVER,
        "title_bg": _GROUND,
        "title_bg_active": _GROUND,
        "title_bg_collapsed": faded(_GROUND, 0.7),
        "scrollbar_bg": faded(_GROUND, 0.0),
        "scrollbar_grab": _HOVER,
        "scrollbar_grab_hovered": _LINE,
        "scrollbar_grab_active": ACCENT,
        "check_mark": ACCENT,
        "slider_grab": faded(ACCENT, 0.85),
        "slider_grab_active": ACCENT,
        "button": _RAISED,
        "button_hovered": _HOVER,
        "button_active": faded(ACCENT, 0.6),
        "header": _HEADER,
        "header_hovered": _HOVER,
        "header_active": _HOVER,
        "separator": faded(_LINE, 0.8),
        "tab": _GROUND,
        "tab_hovered": _HOVER,
        "tab_selected": _HEADER,
        "tab_selected_overline": ACCENT,
        "tab_dimmed": _GROUND,
        "tab_dimmed_selected": _HEADER,
        "table_header_bg": _HEADER,
        "table_border_light": faded(_LINE, 0.5),
        "table_border_strong": _LINE,
        "table_row_bg_alt": (1.0, 1.0, 1.0, 0.025),
        "text_selected_bg": faded(ACCENT, 0.35),
        "nav_cursor": ACCENT,
        "resize_grip": faded(_LINE, 0.5),
        "resize_grip_hovered": faded(ACCENT, 0.6),
        "resize_grip_active": ACCENT,
        "plot_lines": ACCENT,
        "plot_histogram": ACCENT,
    }


def _fonts(imgui: ImGui) -> None:
    global _with_icons  # noqa: PLW0603 - one package, one answer
    spec = find_spec("imgui_bundle")
    if spec is None or spec.origin is None:
        return
    folder = Path(spec.origin).parent / "assets" / "fonts"
    text, icons = folder / "Roboto" / "Roboto-Regular.ttf", folder / "Font_Awesome_6_Free-Solid-900.otf"
    fonts = imgui.get_io().fonts
    if not text.is_file():
        log.debug("no %s: ImGui's own font is used", text)
        return
    size = imgui.get_style().font_size_base
    fonts.clear_fonts()
    fonts.add_font_from_file_ttf(str(text), size)
    if icons.is_file():
        config = imgui.ImFontConfig()
        config.merge_mode = True
        config.glyph_offset = imgui.ImVec2(0.0, 1.0)
        config.size_pixels = size
        fonts.add_font_from_file_ttf(str(icons), 0.86 * size, config)
        _with_icons = True
