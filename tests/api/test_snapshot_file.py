"""Files of snapshots: whole or not there, and errors that say what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from planetfall.render.snapshot import Snapshot
from planetfall.systems.capture import CaptureError

PICTURE = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)


def test_it_comes_back(tmp_path: Path) -> None:
    path = Snapshot(PICTURE).save(tmp_path / "a.png")
    with Image.open(path) as image:
        assert np.array_equal(np.asarray(image), PICTURE)
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize("name", ["missing/a.png", "a.nothing", "a"])
def test_what_can_not_be_written_is_told_and_leaves_nothing(tmp_path: Path, name: str) -> None:
    with pytest.raises(CaptureError, match=r"can.t be written.*expected a name such as picture\.png"):
        Snapshot(PICTURE).save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_an_old_file_survives_a_failure(tmp_path: Path) -> None:
    path = Snapshot(PICTURE).save(tmp_path / "a.png")
    before = path.read_bytes()
    with pytest.raises(CaptureError):
        Snapshot(PICTURE).save(path, format="nothing")
    assert path.read_bytes() == before
