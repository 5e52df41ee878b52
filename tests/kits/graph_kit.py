"""Small helpers of the frame graph's tests."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from planetfall.engine.graph import GraphBuilder, NullBackend, PassIO, Plan, TextureSpec

SIZE = (64, 32)


def idle(io: PassIO) -> Callable[[], None]:
    """A bind whose pass does nothing."""
    return lambda: None


def tex(name: str, **changes: Any) -> TextureSpec:
    """A small texture spec."""
    return TextureSpec(name, changes.pop("format", "rgba8"), **changes)


class Trail:
    """Binds that write down which passes ran, in order."""

    def __init__(self) -> None:
        self.ran: list[str] = []
        self.bound: list[str] = []

    def bind(self, io: PassIO) -> Callable[[], None]:
        name = io.pass_name
        self.bound.append(name)
        return lambda: self.ran.append(name)

    def frame(self, plan: Plan) -> list[str]:
        """Execute once and return what ran."""
        self.ran.clear()
        plan.execute()
        return list(self.ran)


def compiled(builder: GraphBuilder, *exports: str, size: tuple[int, int] = SIZE) -> Plan:
    """Export, compile on a fresh NullBackend."""
    for name in exports:
        builder.export(name)
    return builder.compile(NullBackend(), size)
