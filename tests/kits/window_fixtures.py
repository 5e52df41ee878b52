"""A display for window tests (Xvfb is started when there is none) and a runner for scripts that open windows."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from planetfall.benchmarks import display as benches

RunWindow = Callable[..., dict[str, Any]]
_CHILD = Path(__file__).with_name("window_child.py")


@pytest.fixture(scope="session")
def display() -> Iterator[str]:
    """Name of an X display: the one there is, or a virtual one."""
    try:
        with benches.display() as added:
            yield {**os.environ, **added}.get("DISPLAY", "")
    except benches.NoDisplay as missing:
        pytest.skip(str(missing))


@pytest.fixture
def run_window(display: str) -> RunWindow:
    """Run a function of window_child.py in a process of its own and return what it returns.

    A window library that crashes, or keeps global state, then fails one test only.
    """

    def run(function: str, *arguments: str, environment: dict[str, str] | None = None, timeout: float = 60) -> Any:
        return run_child(function, *arguments, environment={"DISPLAY": display, **(environment or {})}, timeout=timeout)

    return run


def run_child(function: str, *arguments: str, environment: dict[str, str], timeout: float = 60) -> dict[str, Any]:
    """The same with an environment of the test's own (an empty DISPLAY: none)."""
    merged = {**os.environ, **environment}
    for name in [name for name, value in merged.items() if not value]:
        del merged[name]
    done = subprocess.run(
        [sys.executable, str(_CHILD), function, *arguments],
        capture_output=True,
        text=True,
        timeout=timeout,
        env=merged,
        cwd=_CHILD.parents[1],
        check=False,
    )
    lines = done.stdout.strip().splitlines()
    if done.returncode or not lines:
        pytest.fail(f"window_child.py {function} failed ({done.returncode}):\n{done.stdout}\n{done.stderr}")
    return json.loads(lines[-1])
