"""Automatic quality: holds a frame budget by turning one dial. Plain Python; time comes in as numbers.

The dial is a quality from 0 (cheapest) to 1; what it stands for (rows, steps, edges of triangles) is the caller's
business. Frames that are cheaper than the budget are waited for (`wait_ms`), as a frame cap does, so
that a frame lasts the budget although its cost moves; the dial is then set so that the cost lies some way below, and
only what grows by more than that in one interval comes out longer.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

__all__ = ["BudgetChange", "FrameBudget"]

_AIM = 0.78
"""Share of the budget that a frame's cost is set to: load may grow by a quarter before a frame is late."""
_LOW = 0.60
"""Below this share there is room for more quality."""
_HIGH = 0.97
"""Above this share the next frames would be late."""
_FEW = 5
"""Frames that have to agree: one long frame (a snap, a load) is no reason."""
_STEADY_S = 1.0
"""How long a cheap load must last before quality is given back."""
_TREND_S = 1.5
"""Over how long the trend of the cost is taken."""


@dataclass(frozen=True)
class BudgetChange:
    """A change of the dial, for the log. cost_ms: what made it so."""

    at_s: float
    before: float
    after: float
    cost_ms: float
    budget_ms: float

    def __str__(self) -> str:
        return (
            f"automatic quality {self.before:.2f} -> {self.after:.2f}: frames cost {self.cost_ms:.1f} ms of "
            f"{self.budget_ms:.1f} ms"
        )


class FrameBudget:
    """Feed it each frame's cost; it says what the dial should be.

    budget_ms: what a frame may last. cost_of: relative cost of a frame at a dial, a rising function; where it is wrong,
    the next change mends it. every_s: at most one change in this time.
    """

    def __init__(
        self, budget_ms: float, cost_of: Callable[[float], float], dial: float = 1.0, every_s: float = 5.0
    ) -> None:
        if not (math.isfinite(budget_ms) and budget_ms > 0.0):
            raise ValueError(f"budget_ms: expected a positive number of milliseconds, found {budget_ms!r}")
        self.budget_ms = budget_ms
        self.dial = min(max(dial, 0.0), 1.0)
        self.changes: list[BudgetChange] = []
        self._cost_of = cost_of
        self._every_s = every_s
        self._recent: deque[tuple[float, float]] = deque()
        self._last_s = -math.inf

    def wait_ms(self, cost_ms: float) -> float:
        """How long to wait after a frame of this cost, so that it lasts the budget."""
        return max(self.budget_ms - cost_ms, 0.0)

    def frame(self, now_s: float, cost_ms: float) -> BudgetChange | None:
        """Take in a frame that ended at now_s and cost cost_ms without waiting; the change to make now, or None."""
        self._recent.append((now_s, cost_ms))
        while len(self._recent) > _FEW and now_s - self._recent[0][0] > _TREND_S:
            self._recent.popleft()
        if now_s - self._last_s < self._every_s or len(self._recent) < _FEW:
            return None
        last = sorted(cost for _, cost in list(self._recent)[-_FEW:])
        cost = last[_FEW // 2]
        expected = cost * self._growth(now_s)
        late = min(last[1], expected) > _HIGH * self.budget_ms or expected > self.budget_ms
        spare = (
            self._recent[-1][0] - self._recent[0][0] >= min(_STEADY_S, _TREND_S)
            and _percentile_90(c for _, c in self._recent) < _LOW * self.budget_ms
        )
        if not late and not (spare and self.dial < 1.0):
            return None
        if late and self.dial <= 0.0:
            return None
        return self._change(now_s, cost, max(cost, expected) if late else cost)

    def _growth(self, now_s: float) -> float:
        """By how much the cost will have grown after half the time to the next possible change, from its trend."""
        span = self._recent[-1][0] - self._recent[0][0]
        if span < 0.5:
            return 1.0
        half = len(self._recent) // 2
        costs = [cost for _, cost in self._recent]
        early, late = sorted(costs[:half])[half // 2], sorted(costs[half:])[(len(costs) - half) // 2]
        if early <= 0.0:
            return 1.0
        rate = min(max((late / early - 1.0) / (0.5 * span), 0.0), 0.06)
        # A jump is no trend: what grew by half at once is measured again instead of carried on.
        return 1.0 if late > 1.5 * early else 1.0 + rate * 0.5 * self._every_s

    def _change(self, now_s: float, cost: float, expected: float) -> BudgetChange | None:
        wanted = _AIM * self.budget_ms / expected
        dial = self._dial_for(wanted)
        if abs(dial - self.dial) < 0.01:
            return None
        change = BudgetChange(now_s, self.dial, dial, cost, self.budget_ms)
        self._last_s, self.dial = now_s, dial
        self._recent.clear()
        self.changes.append(change)
        return change

    def _dial_for(self, ratio: float) -> float:
        """The dial at which frames cost `ratio` times what they do now, by bisection of the cost model."""
        now = self._cost_of(self.dial)
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = 0.5 * (low + high)
            if self._cost_of(middle) <= ratio * now:
                low = middle
            else:
                high = middle
        return low if low > 1e-6 else 0.0


def _percentile_90(costs: Iterable[float]) -> float:
    """What nine of ten frames cost at most: a hitch every second must not keep quality down for good."""
    ordered = sorted(costs)
    return ordered[-(-9 * len(ordered) // 10) - 1]
