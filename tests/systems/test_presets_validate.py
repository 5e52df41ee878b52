"""Presets with all they have are drawn under PLANETFALL_VALIDATE=1: each pass touches only what it declares."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.gpu

CASES = (("earth", "near", "low"), ("earth", "near", "medium"), ("woods", "meadow", "low"), ("woods", "grove", "low"))


@pytest.mark.parametrize(("planet", "view", "quality"), CASES)
def test_passes_declare_what_they_touch(tmp_path, planet, view, quality):
    """Clouds included: at low they are drawn coarser, by other passes."""
    command = [sys.executable, "-P", "-m", "planetfall", "render", planet, "--view", view, "--quality", quality]
    command += ["--size", "160x90", "-o", str(tmp_path / "a.png")]
    environment = {**os.environ, "PLANETFALL_VALIDATE": "1"}
    told = subprocess.run(command, check=False, env=environment, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr[-2000:]
