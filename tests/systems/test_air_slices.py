"""Tables of the air that are made bit by bit between frames, as on a slow machine, are those that are made at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planetfall as pf


@pytest.mark.gpu
def test_frames_between_slices_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for frames in (0, 60):
        folder = tmp_path / str(frames)
        monkeypatch.setenv("PLANETFALL_CACHE", str(folder))
        with pf.Renderer(pf.load_scene("earth"), (64, 36), "low", {"atmosphere.budget_ms": 0.1}) as renderer:
            for _ in range(frames):
                renderer.render(pf.view("near"))
            renderer.settle(pf.view("near"))
        (path,) = (folder / "atmosphere").glob("*.npz")
        with np.load(path) as tables:
            found.append({name: tables[name] for name in ("depth", "moments")})
    for name, at_once in found[0].items():
        np.testing.assert_array_equal(found[1][name], at_once, err_msg=name)
