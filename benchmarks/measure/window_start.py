"""The demo's start with its window and interface: runs the demo itself and says when its first picture was on the
screen; prints JSON. Run as a module by the startup suite.

Arguments: the time.time() at which the process was asked for, then those of the demo.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any


def main(asked_s: float, arguments: list[str]) -> dict[str, dict[str, float]]:
    """{"interpreter", "window", "first picture", "second picture"}: {"ms" since the command, "cpu_ms" of processor time
    until then, of all threads}, which other programs beside this one lengthen less."""
    marks: dict[str, tuple[float, float]] = {}

    def mark(name: str) -> None:
        marks[name] = (time.time(), time.process_time())

    mark("interpreter")
    from ...engine.hosts import window as windows
    from ...games.demo_planet.main import main as demo

    made, swap = windows.Window.__init__, windows.Window.swap

    def opened(self: Any, *given: Any) -> None:
        made(self, *given)
        mark("window")

    def shown(self: Any) -> None:
        swap(self)
        self.ctx.finish()  # what was asked for has been drawn, and is on the screen
        name = "second picture" if "first picture" in marks else "first picture"
        mark(name)
        if name == "second picture":
            self.request_close()

    windows.Window.__init__, windows.Window.swap = opened, shown  # type: ignore[method-assign]
    code = demo(arguments)
    if code or "second picture" not in marks:
        raise SystemExit(f"the demo ended with {code} and showed {', '.join(marks)}")
    return {name: {"ms": 1e3 * (at_s - asked_s), "cpu_ms": 1e3 * used_s} for name, (at_s, used_s) in marks.items()}


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(float(sys.argv[1]), sys.argv[2:])))
