"""What the project promises, beside what was found."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Target:
    """A promise: low <= value <= high. `unit` is written after the numbers."""

    low: float = -math.inf
    high: float = math.inf
    unit: str = ""

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        if self.low == -math.inf:
            return f"<= {self.high:g}{unit}"
        if self.high == math.inf:
            return f">= {self.low:g}{unit}"
        return f"{self.low:g} to {self.high:g}{unit}"

    def met(self, value: float) -> bool:
        """NaN never meets a target."""
        return bool(self.low <= value <= self.high)

    def columns(self, value: float) -> dict[str, Any]:
        """The target columns of a Row."""
        return {"target": str(self), "met": self.met(value)}


def at_most(high: float, unit: str = "") -> Target:
    """value <= high"""
    return Target(high=high, unit=unit)


def at_least(low: float, unit: str = "") -> Target:
    """value >= low"""
    return Target(low=low, unit=unit)
