"""What the interface shows of a flight."""

from __future__ import annotations

from dataclasses import dataclass, field

__all__ = ["Shown"]


@dataclass
class Shown:
    """What the interface shows of the app, and may change. message fades; errors stay while they last."""

    help: bool = True
    numbers: bool = True
    panels: bool = False
    journey: bool = False
    message: str = ""
    error: str = ""
    shader_errors: tuple[str, ...] = ()
    stats: dict[str, int] = field(default_factory=dict)
