"""The games that embed a planet: they run, both sides drew, and what stands behind the ground is hidden by it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from window_fixtures import RunWindow, display, run_window

from planetfall.games.embed_moderngl.main import main

__all__ = ["display", "run_window"]

GAMES = Path(__file__).resolve().parents[2] / "games"


@pytest.mark.parametrize("name", ["embed_pyglet", "embed_moderngl_window", "embed_moderngl"])
def test_games_are_short(name: str) -> None:
    assert len((GAMES / name / "main.py").read_text(encoding="utf-8").splitlines()) < 60


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="these systems always have a display")
@pytest.mark.parametrize("name", ["embed_pyglet", "embed_moderngl_window"])
def test_without_a_display_they_say_what_to_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":7654")  # nobody answers
    command = [sys.executable, "-m", f"planetfall.games.{name}"]
    found = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert found.returncode == 1 and "Traceback" not in found.stderr
    assert found.stderr.startswith(f"{name}: expected a display") and "xvfb-run" in found.stderr


@pytest.mark.gpu
def test_bare_moderngl(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "embedded.png"
    assert main(["--size", "320", "180", "-o", str(target)]) == 0
    assert capsys.readouterr().out == ""
    picture = np.asarray(Image.open(target)).astype(int)
    red = (picture[..., 0] > 2 * picture[..., 1]) & (picture[..., 0] > 2 * picture[..., 2]) & (picture[..., 0] > 40)
    green = (picture[..., 1] > picture[..., 0]) & (picture[..., 1] > picture[..., 2])
    sky = picture[:20]
    assert red.sum() > 300  # balls of the host's, drawn before
    assert green[120:].mean() > 0.3  # grass
    assert sky.mean() > 80 and sky[..., 2].mean() >= sky[..., 0].mean()  # day: blue, or clouds
    # The ground hides the lower part of the first ball: it is less high than wide.
    ball = red[:, 50:88]
    rows, columns = np.flatnonzero(ball.any(axis=1)), np.flatnonzero(ball.any(axis=0))
    assert np.ptp(rows) < 0.92 * np.ptp(columns)


@pytest.mark.window
def test_pyglet(run_window: RunWindow, tmp_path: Path) -> None:
    seen = run_window("embedded_pyglet", str(tmp_path / "picture.png"), timeout=120)
    picture = np.asarray(Image.open(tmp_path / "picture.png").convert("RGB")).astype(int)
    height, width, _ = picture.shape
    assert seen == {"frames": 3, "errors": 0, "depth test": 0}
    coin = picture[height - 40 : height - 14, 14:40].reshape(-1, 3)
    np.testing.assert_allclose(coin, np.broadcast_to((255, 200, 40), coin.shape), atol=2)  # the sprite is whole
    label = picture[height - 45 : height - 10, 50 : width // 2]
    assert (label.min(axis=2) > 240).sum() > 40  # and so are the letters
    sky = picture[: height // 8]
    assert sky.mean() > 80 and sky[..., 2].mean() >= sky[..., 0].mean()  # day: blue, or clouds
    cubes = (picture[..., 2] > picture[..., 1] + 40) & (picture[..., 0] > picture[..., 1]) & (picture[..., 2] < 200)
    assert cubes.sum() > 100


@pytest.mark.window
@pytest.mark.parametrize("backend", ["glfw", "pyglet"])
def test_moderngl_window(run_window: RunWindow, tmp_path: Path, backend: str) -> None:
    seen = run_window("embedded_moderngl_window", str(tmp_path / "picture.png"), backend, timeout=120)
    assert seen["errors"] == "GL_NO_ERROR"
    assert seen["aspect"] == 480 / 270 and not any(seen["left"].values())
    picture = np.asarray(Image.open(tmp_path / "picture.png")).astype(int)
    assert picture.shape == (270, 480, 3)
    assert (picture[:, 400:].max(axis=2) > 20).mean() > 0.9  # the planet fills what the window grew by
    height = len(picture)
    cubes = (
        (picture[..., 2] > picture[..., 1] + 30) & (picture[..., 0] < 140) & (np.arange(height) > height / 2)[:, None]
    )
    assert cubes.sum() > 200
    panel = picture[int(0.96 * height)]
    assert (panel[:, 0] > panel[:, 2]).mean() > 0.95  # orange over all of it, blended
    assert np.ptp(panel[:, 0]) > 5  # and the ground shows through


def test_the_first_picture_takes_ten_lines() -> None:
    """docs/embedding.md promises it; tests/api/test_tutorials.py runs it."""
    text = (GAMES.parent / "docs" / "embedding.md").read_text(encoding="utf-8")
    (first,) = re.findall(r"^```python first-picture\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert len([line for line in first.splitlines() if line.strip()]) <= 10
