"""What the frame's contract states once holds where it has to be said again: in GLSL."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import planetfall as pf
from planetfall.engine.frame import View
from planetfall.engine.frame.gbuffer import ATTACHMENTS, GBUFFER, TILE_PX, tiles_of
from planetfall.engine.made_shaders import MADE
from planetfall.engine.world import MissingError

ROOT = Path(__file__).resolve().parents[2]


def test_the_size_of_tiles_stands_nowhere_else() -> None:
    by_hand = re.compile(r"local_size_x = 16, local_size_y = 8\b|ivec2\(16, 8\)")
    files = [file for file in (ROOT / "assets" / "shaders").rglob("*") if file.is_file()]
    found = [file.name for file in files if by_hand.search(file.read_text(encoding="utf-8"))]
    assert files and not found, "write TILE_WIDTH and TILE_HEIGHT of generated/tiles.glsl"
    assert f"TILE_WIDTH {TILE_PX[0]}\n" in MADE["generated/tiles.glsl"]()
    assert tiles_of((1, 1)) == (1, 1) and tiles_of((17, 8)) == (2, 1) and tiles_of((160, 90)) == (10, 12)


def test_the_list_of_attachments_stands_nowhere_else() -> None:
    assert [spec.name for spec in ATTACHMENTS] == ["gbuffer.depth", *GBUFFER]
    listed = re.compile(r",\s*".join(f'"{name}"' for name in GBUFFER))
    files = [file for folder in ("systems", "engine", "planetfall") for file in (ROOT / folder).rglob("*.py")]
    found = [file.name for file in files if listed.search(file.read_text(encoding="utf-8"))]
    assert not found, "write GBUFFER of engine/frame/gbuffer.py"


def test_a_view_without_a_proxy_says_so() -> None:
    view = View(2)
    with pytest.raises(MissingError, match="view 2 has no proxy yet"):
        _ = view.proxy


@pytest.mark.gpu
def test_a_released_view_is_as_new() -> None:
    away = pf.Camera.at(20.0, -30.0, 2e6, pitch_deg=60.0)
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
        renderer.render(away)
        view = renderer.views[0]
        assert view.proxy.generation > 0 and not view.seen.ground() and not view.seen.planet()
        assert abs(view.proxy.cell.altitude_m / 2e6 - 1.0) < 0.5
        view.release()
        assert view.placed is None and view.seen.ground() and view.seen.planet()
