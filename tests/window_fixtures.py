"""A display for window tests (Xvfb is started when there is none) and a runner for scripts that open windows."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

RunWindow = Callable[..., dict[str, Any]]
_CHILD = Path(__file__).with_name("window_child.py")


@contextlib.contextmanager
def virtual_display(size: str = "1280x800x24") -> Iterator[str]:
    """Start Xvfb on a free display; yields its name."""
    program = shutil.which("Xvfb")
    if program is None:
        pytest.skip("no display and no Xvfb to make one (apt install xvfb)")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(
        [program, "-displayfd", str(write_end), "-screen", "0", size, "-nolisten", "tcp"],
        pass_fds=(write_end,),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(write_end)
    try:
        ready, _, _ = select.select([read_end], [], [], 20.0)
        number = os.read(read_end, 16).decode().strip() if ready else ""
        if not number:
            pytest.skip("Xvfb did not start")
        yield f":{number}"
    finally:
        os.close(read_end)
        server.terminate()
        server.wait(timeout=20)


@pytest.fixture(scope="session")
def display() -> Iterator[str]:
    """Name of an X display: the one there is, or a virtual one."""
    found = os.environ.get("DISPLAY")
    if found:
        yield found
        return
    with virtual_display() as made:
        yield made


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
