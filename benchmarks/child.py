"""Measurements in a process of their own, whose last line is JSON."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

from .. import __file__ as _package_file

__all__ = ["answer_of", "keeping_bytecode"]


def answer_of(*arguments: str, environment: Mapping[str, str] = MappingProxyType({}), timeout_s: float = 300.0) -> Any:
    """What a fresh Python with these arguments prints last, decoded. environment: on top of this process' own.

    Raises RuntimeError with the end of what it said where it fails, subprocess.TimeoutExpired where it takes too long.
    """
    root = str(Path(_package_file).resolve().parents[1])
    path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, **environment, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )
    if done.returncode:
        said = (done.stdout + done.stderr).strip()[-600:]
        raise RuntimeError(f"the process ended with {done.returncode}: {said}")
    return json.loads(done.stdout.splitlines()[-1])


@contextmanager
def keeping_bytecode() -> Iterator[dict[str, str]]:
    """An environment in which Python keeps its compiled modules, in a folder of its own: what a second start finds,
    even where the machine forbids it for tests' sake."""
    with tempfile.TemporaryDirectory() as folder:
        yield {"PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
