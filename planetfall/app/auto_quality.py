"""Automatic quality in a window: what the dial of systems/tweak/budget.py stands for, and what frames cost here."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..quality import LIVE
from ..systems.tweak.budget import BudgetChange, FrameBudget

if TYPE_CHECKING:
    from ..render.renderer import Renderer

__all__ = ["AutoQuality", "cost_of", "scale_of", "settings_at"]

log = logging.getLogger(__name__)

_LEAST_SCALE = 0.5
"""A quarter of the pixels: below that letters of a sign would be lost before time is won."""
_FIXED = 0.2
"""Share of a frame that hardly depends on the dial: tables, lists, Python. Measured shares go from 0.1 to 0.4; what is
wrong here is mended by the next change."""
_COARSEST_EDGE = 1.8
_COARSEST_ERROR = 2.5
_FEWEST_STEPS = 0.5


def scale_of(dial: float) -> float:
    """Rows drawn for each row of the window."""
    return _LEAST_SCALE + (1.0 - _LEAST_SCALE) * dial


def cost_of(dial: float) -> float:
    """Cost of a frame against that of full quality: pixels, and what does not depend on them."""
    return _FIXED + (1.0 - _FIXED) * scale_of(dial) ** 2


def settings_at(dial: float, full: Mapping[str, Any]) -> dict[str, Any]:
    """The knobs of a running renderer at a dial; at 1 those of its quality. Triangles get longer edges and clouds fewer
    steps as pixels get larger, so that what is drawn stays about as wrong as it is sharp."""
    less = 1.0 - dial
    return {
        "terrain.edge_px": min(full["terrain.edge_px"] * (1.0 + (_COARSEST_EDGE - 1.0) * less), 64.0),
        "terrain.error_px": min(full["terrain.error_px"] * (1.0 + (_COARSEST_ERROR - 1.0) * less), 16.0),
        "clouds.fine_steps": max(round(full["clouds.fine_steps"] * (1.0 - (1.0 - _FEWEST_STEPS) * less)), 8),
    }


class AutoQuality:
    """Holds a frame budget for one renderer after another: `frame` after each frame, before it is shown.

    Off until `budget_ms` is set. Changes are logged, and the last one is `said`.
    """

    def __init__(self) -> None:
        self._budget: FrameBudget | None = None
        self._renderer: Renderer | None = None
        self._full: dict[str, Any] = {}
        self.last: BudgetChange | None = None

    @property
    def budget_ms(self) -> float | None:
        """What a frame may last; None: off, and quality is full again."""
        return None if self._budget is None else self._budget.budget_ms

    @budget_ms.setter
    def budget_ms(self, budget_ms: float | None) -> None:
        if budget_ms is None:
            if self._renderer is not None and not self._renderer.released:
                self._apply(self._renderer, 1.0)
            self._budget = self._renderer = self.last = None
        elif self._budget is None:
            self._budget = FrameBudget(budget_ms, cost_of)
        else:
            self._budget = FrameBudget(budget_ms, cost_of, self._budget.dial)

    @property
    def dial(self) -> float:
        """0 to 1: how much of the quality that was chosen is drawn."""
        return 1.0 if self._budget is None else self._budget.dial

    @property
    def changes(self) -> list[BudgetChange]:
        """All changes since the budget was set."""
        return [] if self._budget is None else self._budget.changes

    def frame(self, renderer: Renderer, cost_ms: float, now_s: float | None = None) -> float:
        """Take in a frame's cost, change what has to be changed; milliseconds to wait before the next one."""
        if self._budget is None:
            return 0.0
        if renderer is not self._renderer:  # another quality was chosen
            self._renderer = renderer
            self._full = {key: renderer.settings[key] for key in LIVE}
            self._apply(renderer, self._budget.dial)
        change = self._budget.frame(time.perf_counter() if now_s is None else now_s, cost_ms)
        if change is not None:
            self.last = change
            log.info("%s", change)
            self._apply(renderer, change.after)
        return self._budget.wait_ms(cost_ms)

    def _apply(self, renderer: Renderer, dial: float) -> None:
        renderer.render_scale = scale_of(dial)
        renderer.retune(settings_at(dial, self._full))
