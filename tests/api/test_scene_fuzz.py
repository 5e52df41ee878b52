"""Scenes as files: whatever there can be in a scene comes back, to the bit."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_fuzz import TEXT, component, scenes, told, value_of

import planetfall as pf
from planetfall.camera.kept import Place, Places
from planetfall.capture.shot import load_shot, shot_settings
from planetfall.engine.settings import plain_table
from planetfall.quality import QUALITY, qualities, resolve_quality
from planetfall.systems.capture import write_png

MANY = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large, HealthCheck.large_base_example]


def comes_back(scene: pf.Scene) -> None:
    with scene, tempfile.TemporaryDirectory() as folder:
        path, shared = Path(folder) / "scene.toml", Path(folder) / "scene.planetfall"
        scene.save(path)
        first = path.read_bytes()
        with pf.load_scene(path) as again:
            assert told(again) == told(scene)
            again.save(path)
            assert path.read_bytes() == first
        scene.share(shared)


@settings(max_examples=25, suppress_health_check=MANY)
@given(scenes())
def test_what_is_saved_comes_back(scene):
    comes_back(scene)


@pytest.mark.slow
@settings(max_examples=1500, suppress_health_check=MANY)
@given(scenes())
def test_what_is_saved_comes_back_from_long_runs(scene):
    comes_back(scene)


def test_masks_are_left_out_with_a_warning(tmp_path, caplog):
    with pf.load_scene("earth") as scene:
        scene.planet.add(pf.Cover(felled=((1, 2, 3, 4, 5),), mask=pf.clearing((6.371e6, 0.0, 0.0), 100.0)))
        scene.save(tmp_path / "scene.toml")
    assert "Cover.mask; assign it again" in caplog.text
    with pf.load_scene(tmp_path / "scene.toml") as again:
        cover = again.planet[pf.Cover]
        assert cover.mask is None and cover.felled == ((1, 2, 3, 4, 5),)


def test_objects_of_companions_and_their_meshes_travel(tmp_path):
    pytest.importorskip("trimesh", reason="the extra props is not installed")
    mesh = tmp_path / "here" / "rover.obj"
    mesh.parent.mkdir()
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
    with pf.load_scene("earth_moon") as scene:
        scene.add(pf.Transform((7e6, 0.0, 0.0)), pf.Shape(str(mesh)), name="satellite")
        moon = scene.companions["moon"].scene
        moon.add(pf.Transform((1.8e6, 0.0, 0.0), planet="moon"), pf.Shape(str(mesh)), name="rover")
        scene.share(tmp_path / "both.planetfall")
    mesh.unlink()
    with pf.load_scene(tmp_path / "both.planetfall") as again:
        assert [p.name for p in again.props] == ["satellite"]
        (rover,) = again.companions["moon"].scene.props
        assert rover.name == "rover" and rover[pf.Shape].form.endswith("0-rover.obj")
    # In a file of one's own a mesh lies beside the file, and a companion has its base's objects or its own.
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "hut.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
    hut = '[[{}]]\nname = "hut"\ntransform = {{ position_m = [1.8e6, 0.0, 0.0] }}\nshape = {{ form = "hut.obj" }}\n'
    (tmp_path / "there" / "base.toml").write_text('base = "moon"\n' + hut.format("props"))
    text = '[[companions]]\nname = "{}"\nbase = "base.toml"\n[companions.orbit]\ndistance_m = {}\n'
    own = hut.format("companions.props").replace('"hut"\n', '"own"\n')
    (tmp_path / "there" / "all.toml").write_text(
        'base = "earth"\n' + text.format("a", 3e8) + text.format("b", 6e8) + own
    )
    with pf.load_scene(tmp_path / "there" / "all.toml") as scene:
        assert [[p.name for p in c.scene.props] for c in scene.companions.values()] == [["hut"], ["own"]]


@settings(max_examples=25, suppress_health_check=MANY)
@given(st.lists(st.tuples(TEXT.filter(str.strip), component(pf.Sun), st.floats(-1e9, 1e9)), max_size=4), st.data())
def test_places_come_back(kept, data):
    angle = st.floats(-180.0, 180.0)
    with tempfile.TemporaryDirectory() as folder:
        places, wanted = Places(Path(folder) / "places.toml"), {}
        for name, sun, time_s in kept:
            at = pf.direction(data.draw(st.floats(-90.0, 90.0)), data.draw(angle))
            camera = pf.Camera(7e6 * at, np.roll(at, 1), at, data.draw(st.floats(1.0, 170.0)))
            mode = data.draw(st.sampled_from(["ship", "walk", "orbit"]))
            wanted[name] = Place(name, data.draw(TEXT), camera, sun, time_s, mode)
            places.keep(wanted[name])
        again = Places(Path(folder) / "places.toml")
        assert again.names() == list(wanted) and not again.problem
        for name, place in wanted.items():
            found = again[name]
            assert (found.scene, found.time_s, found.mode) == (place.scene, place.time_s, place.mode)
            assert plain_table(found.sun) == plain_table(place.sun)
            assert found.camera.fov_y_deg == place.camera.fov_y_deg
            for part in ("position_m", "forward", "up"):
                np.testing.assert_allclose(getattr(found.camera, part), getattr(place.camera, part), rtol=0, atol=1e-8)


KNOBS = st.fixed_dictionaries({}, optional={key: value_of(rule) for key, rule in QUALITY.rules.items()})


@settings(max_examples=25, suppress_health_check=MANY)
@given(scenes(), st.sampled_from(qualities()), KNOBS)
def test_what_a_picture_was_made_of_comes_back(scene, quality, overrides):
    camera = pf.Camera((7e6, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    with scene, tempfile.TemporaryDirectory() as folder:
        made = shot_settings(scene, camera, 3.5, (640, 360), quality=quality, overrides=overrides)
        path = write_png(Path(folder) / "picture.png", np.zeros((2, 2, 3), np.uint8), made)
        shot = load_shot(path)
        with shot.scene:
            assert told(shot.scene) == {**told(scene), "about": ""}
            assert resolve_quality(shot.quality, shot.overrides) == resolve_quality(quality, overrides)
