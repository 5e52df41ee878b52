"""The example of a host of one's own: runs, and both drew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from planetfall.games.embed_moderngl.main import main


@pytest.mark.gpu
def test_host_and_planet_share_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "embedded.png"
    assert main(["--size", "160", "90", "--frames", "2", "-o", str(target)]) == 0
    assert str(target) in capsys.readouterr().out
    picture = np.asarray(Image.open(target)).astype(int)
    panel, planet, space = picture[85, 80], picture[60:70, 20:140], picture[2]
    assert panel[0] > 180 and panel[0] > panel[2] + 60  # the host's, blended over the planet
    assert planet.mean() > 30
    assert space.max() < 30
