"""The last lines of the log, for a window: a handler that keeps them, and their drawing."""

from __future__ import annotations

import logging
from collections import deque

from ...engine.gpu.imgui_type import ImGui
from .style import AMBER, BAD, QUIET

__all__ = ["LogLines"]

_MOST = 500
_LEVELS = (("all", logging.DEBUG), ("info", logging.INFO), ("warnings", logging.WARNING), ("errors", logging.ERROR))


class LogLines(logging.Handler):
    """Keeps the last lines of a logger while it is attached; changes neither its level nor its other handlers."""

    def __init__(self, most: int = _MOST) -> None:
        super().__init__(logging.DEBUG)
        self.lines: deque[tuple[int, str]] = deque(maxlen=most)
        self.shown = 1
        self._seen = 0
        self._added = 0
        self.setFormatter(logging.Formatter("%(asctime)s  %(name)s  %(message)s", "%H:%M:%S"))

    def emit(self, record: logging.LogRecord) -> None:
        try:
            self.lines.append((record.levelno, self.format(record)))
            self._added += 1
        except Exception:
            self.handleError(record)

    def draw(self, imgui: ImGui) -> None:
        """The lines, newest last, in a child window that follows them."""
        for number, (name, _) in enumerate(_LEVELS):
            if number:
                imgui.same_line()
            if imgui.radio_button(name, self.shown == number):
                self.shown = number
        imgui.same_line()
        if imgui.button("clear"):
            self.lines.clear()
        least = _LEVELS[self.shown][1]
        imgui.begin_child("lines")
        imgui.push_text_wrap_pos(0.0)
        for level, text in list(self.lines):
            if level < least:
                continue
            color = BAD if level >= logging.ERROR else AMBER if level >= logging.WARNING else QUIET
            imgui.text_colored(imgui.ImVec4(*color), text)
        imgui.pop_text_wrap_pos()
        if self._added != self._seen:
            self._seen = self._added
            imgui.set_scroll_here_y(1.0)
        imgui.end_child()
