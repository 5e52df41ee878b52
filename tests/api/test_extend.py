"""A game's own component and system, by declaration: scene files, knobs, overrides, panel, passes, debug view."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planetfall as pf
from planetfall import extend
from planetfall.engine.settings import rules_of
from planetfall.games.new_system import ring
from planetfall.quality import resolve_quality
from planetfall.scene.kinds import KINDS
from planetfall.systems.debug import NAMED_VIEWS

FILE = Path(ring.__file__)
SPACE = pf.Camera.at(24.0, 0.0, 7.1e6, pitch_deg=-86.0, fov_y_deg=62.0)
extend.unregister(ring.Ring)  # importing it registers it, and the other tests' library is the one that is shipped


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    extend.register(
        ring.Ring, ring.RingSystem, shaders=FILE.parent / "shaders", debug_views={"ring": ("ring.density", "heat")}
    )
    yield
    extend.unregister(ring.Ring)
    assert "ring" not in NAMED_VIEWS
    assert "ring.depth" not in extend.QUALITY.component_rules


def test_it_is_short() -> None:
    assert len(FILE.read_text(encoding="utf-8").splitlines()) < 50


def test_scene_files_and_overrides_know_it(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with pf.load_scene("moon") as scene:
        scene.planet.add(ring.Ring(outer_radii=3.0))
        with caplog.at_level(logging.WARNING):
            scene.save(tmp_path / "ringed.toml")
        assert not caplog.records  # nothing was left out
        with pytest.raises(pf.SettingError, match=r"Ring.outer_radii.*from 1 to 20 radii"):
            scene.planet[ring.Ring].outer_radii = 0.5
    with pf.load_scene(tmp_path / "ringed.toml") as again:
        assert again.planet[ring.Ring] == ring.Ring(outer_radii=3.0)
    assert resolve_quality("low", {"ring.depth": 0.2})["ring.depth"] == 0.2
    with pytest.raises(pf.SettingError, match=r"ring\.depth"):
        resolve_quality("low", {"ring.dept": 0.2})
    extend.unregister(ring.Ring)
    with pytest.raises(pf.PresetError, match="ring"):
        pf.load_scene(tmp_path / "ringed.toml")


@pytest.mark.gpu
def test_pictures_panel_and_debug_view() -> None:
    fixed = {"exposure.mode": "fixed", "exposure.ev100": 14.0}
    with pf.load_scene("moon") as scene, pf.Renderer(scene, (96, 54), "low", fixed) as renderer:
        plain = renderer.render(SPACE, sun=pf.Sun(direction=(0.5, -0.6, 0.4)))["color"].astype(int)
        assert renderer.system("ring") is None
        assert "ring.draw" not in {r.name for r in renderer.passes()}
        scene.planet.add(ring.Ring(depth=3.0))
        ringed = renderer.render(SPACE, sun=pf.Sun(direction=(0.5, -0.6, 0.4)))["color"].astype(int)
        assert (np.abs(ringed - plain).max(axis=2) > 10).mean() > 0.05
        reports = {r.name: r for r in renderer.passes()}
        assert reports["ring.draw"].ran and not reports["ring.show"].ran
        assert "ring.density" not in renderer.graph.resources  # nobody looks
        density = renderer.render(SPACE, outputs=("ring.density",))["ring.density"]
        assert 0.5 < float(density.max()) <= 1.0
        scene.planet.add(pf.DebugView("ring"))
        shown = renderer.render(SPACE)["color"].astype(int)
        assert (np.abs(shown - ringed).max(axis=2) > 10).mean() > 0.05
        scene.planet.remove(pf.DebugView)
        scene.planet.remove(ring.Ring)
        again = renderer.render(SPACE, sun=pf.Sun(direction=(0.5, -0.6, 0.4)))["color"].astype(int)
        np.testing.assert_array_equal(again, plain)
        assert "ring" not in renderer.gpu.counts()


def test_the_panel_has_its_knobs() -> None:
    rules = rules_of(ring.Ring)
    assert list(rules) == ["inner_radii", "outer_radii", "depth", "albedo"]
    assert rules["depth"].knob.log and rules["albedo"].knob.widget == "color" and rules["inner_radii"].knob.help


@pytest.mark.gpu
def test_a_pass_of_the_stage_overlay_is_drawn_over_all_light() -> None:
    """A game's pass has its place among all writers without the name of any, whatever a scene has."""
    with pf.load_scene("earth") as scene:
        scene.planet.add(pf.Clouds())
        scene.planet.add(ring.Ring())
        scene.add(pf.Transform(position_m=tuple(pf.view("coast", scene.planet).position_m)), pf.Shape("box"))
        with pf.Renderer(scene, (64, 36), "low") as renderer:
            renderer.render(pf.view("coast"))  # without a stage: a GraphError of two unordered writers
            written = [r.name for r in renderer.passes() if "scene.radiance" in r.writes]
    assert written[-1] == "ring.draw"
    assert {"sky.shade", "terrain.shade", "ocean.shade", "props.shade", "clouds.composite"} <= set(written)


@dataclass
class Rain:
    amount: float = extend.knob(1.0, 0.0, 2.0, help="How much")


@pytest.mark.parametrize(
    ("how", "match"),
    [
        ({"table": "terrain"}, "belongs to Terrain"),
        ({"place": "moon"}, "'planet' or 'scene'"),
        ({"shaders": "/nowhere/at/all"}, "no folder"),
        ({"debug_views": {"rain": ("rain.drops", "sparkle")}}, "mode: expected one of"),
        ({"debug_views": {"normals": ("rain.drops", "heat")}}, "one of the library's"),
    ],
)
def test_what_cannot_be_registered_changes_nothing(how: dict[str, Any], match: str) -> None:
    with pytest.raises(pf.SettingError, match=match):
        extend.register(Rain, **how)
    assert Rain not in KINDS.values()
    assert "rain.amount" not in extend.QUALITY.component_rules


def test_a_component_of_the_scene() -> None:
    extend.register(Rain, place="scene")
    try:
        with pf.load_scene("moon") as scene:
            scene.environment.add(Rain(0.5))
            with pytest.raises(pf.SceneError, match="belongs to the scene"):
                scene.planet.add(Rain())
    finally:
        extend.unregister(Rain)
