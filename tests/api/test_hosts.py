"""Examples of further hosts: pygame-ce, bare glfw, arcade 3, moderngl-window's Scene. Both sides draw, and leave no
error. What clashes with the library's own environment runs in one of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from window_fixtures import display

__all__ = ["display"]

ROOT = Path(__file__).resolve().parents[2]
CHILD = ROOT / "tests" / "kits" / "host_child.py"
NAMES = ("glfw", "pygame", "arcade", "scene")
NEEDS = {"glfw": "glfw", "pygame": "pygame", "arcade": "arcade", "scene": "moderngl_window"}


@cache
def python_of(host: str) -> str:
    """A Python that has the host: this one, or PLANETFALL_ARCADE_PYTHON for arcade."""
    named = os.environ.get(f"PLANETFALL_{host.upper()}_PYTHON", "")
    if named:
        return named
    if find_spec(NEEDS[host]) is not None:
        return sys.executable
    pytest.skip(
        f"{host} is not installed here. Give it an environment of its own: python -m venv there; there/bin/pip install "
        f"{host} and what planetfall depends on; PLANETFALL_{host.upper()}_PYTHON=there/bin/python"
    )


def drawn(host: str, folder: Path, screen: str) -> tuple[dict[str, Any], NDArray[np.int64]]:
    """What a few frames of the example said, and the last one."""
    picture = folder / f"{host}.png"
    command = [python_of(host), "-P", str(CHILD), host, str(picture)]
    environment = {**os.environ, "DISPLAY": screen, "SDL_AUDIODRIVER": "dummy"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=200, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1]), np.asarray(Image.open(picture).convert("RGB")).astype(int)


@pytest.mark.parametrize("host", NAMES)
def test_examples_are_short(host: str) -> None:
    assert len((ROOT / "games" / f"embed_{host}" / "main.py").read_text(encoding="utf-8").splitlines()) <= 60


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="these systems always have a display")
@pytest.mark.parametrize("host", NAMES)
def test_without_a_display_they_say_what_to_do(host: str) -> None:
    environment = {**os.environ, "DISPLAY": ":7654"}  # nobody answers
    environment.pop("WAYLAND_DISPLAY", None)
    command = [sys.executable, "-m", f"planetfall.games.embed_{host}"]
    found = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, env=environment, cwd=ROOT)
    assert found.returncode == 1 and "Traceback" not in found.stderr
    assert "expected" in found.stderr and ("xvfb-run" in found.stderr or "pip install" in found.stderr)


@pytest.mark.window
def test_glfw(display: str, tmp_path: Path) -> None:
    seen, picture = drawn("glfw", tmp_path, display)
    assert seen == {"frames": 3, "errors": ["GL_NO_ERROR"], "left": {}}
    boxes = (picture[..., 2] > picture[..., 1] + 25) & (picture[..., 0] < 150) & (np.arange(270) > 150)[:, None]
    assert boxes.sum() > 1500
    assert (picture[200:, :, 1] > picture[200:, :, 2]).mean() > 0.4  # grass
    assert picture[:40, :, 2].mean() > 90  # day


@pytest.mark.window
def test_pygame(display: str, tmp_path: Path) -> None:
    seen, picture = drawn("pygame", tmp_path, display)
    assert seen == {"frames": 3, "errors": ["GL_NO_ERROR"], "left": {}}
    text = picture[235:265, 12:160].reshape(-1, 3)
    assert (text.min(axis=1) > 240).sum() > 200 and (np.abs(text - (20, 20, 60)).max(axis=1) < 3).sum() > 1000
    boxes = (picture[..., 0] > picture[..., 1] + 50) & (picture[..., 2] > picture[..., 1] + 20)
    assert boxes[130:200].sum() > 4000
    assert (picture[200:, 200:, 2] > picture[200:, 200:, 0] + 20).mean() > 0.5  # water


@pytest.mark.window
def test_arcade(display: str, tmp_path: Path) -> None:
    seen, picture = drawn("arcade", tmp_path, display)
    assert seen == {"frames": 3, "errors": ["GL_NO_ERROR"], "left": {}}
    coin = picture[230:254, 18:38].reshape(-1, 3)
    np.testing.assert_allclose(coin, np.broadcast_to((255, 200, 40), coin.shape), atol=2)  # the sprite is whole
    assert (picture[225:258, 50:180].min(axis=2) > 230).sum() > 40  # and so are the letters
    boxes = (picture[..., 2] > picture[..., 1] + 25) & (picture[..., 0] > picture[..., 1]) & (picture[..., 2] < 200)
    assert boxes[100:200].sum() > 1000
    assert (picture[200:, 200:440, 2] > picture[200:, 200:440, 0] + 20).mean() > 0.5  # water


@pytest.mark.window
def test_scenes_of_moderngl_window(display: str, tmp_path: Path) -> None:
    seen, picture = drawn("scene", tmp_path, display)
    assert seen == {"frames": 3, "errors": ["GL_NO_ERROR"], "left": {}}
    roofs = (picture[..., 0] > 2 * picture[..., 1]) & (picture[..., 0] > 80)
    walls = (picture.min(axis=2) > 100) & (np.ptp(picture, axis=2) < 70) & (np.arange(270) > 130)[:, None]
    assert roofs.sum() > 1500 and walls.sum() > 500
    # The ground hides the huts' foundations, which reach a metre down: grass is below each wall.
    assert (picture[-20:, :, 1] > picture[-20:, :, 2]).mean() > 0.9
