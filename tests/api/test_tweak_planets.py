"""The settings window on several planets: what it remembers of companions, and what it writes. No GPU."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterator
from typing import Any

import pytest
from app_kit import app_of

import planetfall as pf
from planetfall.app.panels import SettingsWindow
from planetfall.app.tweak_store import PropParts
from planetfall.app.window import FlightApp
from planetfall.scene.companions import bodies
from planetfall.scene.presets import left_out
from planetfall.systems.tweak import Edit, FrameHistory


@pytest.fixture
def flight() -> Iterator[tuple[FlightApp, SettingsWindow]]:
    with pf.load_scene("earth_moon") as scene:
        app, _, _ = app_of(scene)
        settings = SettingsWindow(scene, FrameHistory(4))
        settings.remember(app)
        yield app, settings


def turn(settings: SettingsWindow, heading: str, field: str, value: Any) -> str:
    """What the widget of a knob does."""
    part = settings.bench.store.parts()[heading]
    before = getattr(part, field)
    setattr(part, field, value)
    wrong = settings.bench.made(heading, [(field, before, value)])
    settings.bench.history.seal()
    return wrong


def test_knobs_of_a_companion_are_turned_undone_and_reset(flight):
    app, settings = flight
    bench, moon = settings.bench, app.scene.companions["moon"]
    first = bench.copy()
    assert {"moon: Orbit", "moon: Planet", "moon: Terrain"} <= set(first)
    assert turn(settings, "moon: Terrain", "seed", 5) == ""
    assert turn(settings, "moon: Orbit", "phase_deg", 99.0) == ""
    assert moon.scene.planet[pf.Terrain].seed == 5 and moon.orbit.phase_deg == 99.0
    assert set(bench.differences()) == {"moon: Terrain", "moon: Orbit"}
    assert bench.history.undo_label == "moon: Orbit.phase_deg"
    bench.undo()
    assert moon.orbit.phase_deg == first["moon: Orbit"].phase_deg and moon.scene.planet[pf.Terrain].seed == 5
    bench.redo()
    bench.switch()
    turn(settings, "moon: Terrain", "seed", 6)
    bench.switch()
    assert moon.scene.planet[pf.Terrain].seed == 5
    assert bench.reset() == "" and bench.copy() == first


def test_an_orbit_through_the_planet_is_taken_back(flight):
    app, settings = flight
    assert "inside each other" in turn(settings, "moon: Orbit", "distance_m", 7e6)
    assert app.scene.companions["moon"].orbit.distance_m == 3.844e8


def test_a_planet_comes_and_goes_as_one_step(flight):
    app, settings = flight
    page, bench = settings.planets, settings.bench
    assert page.add(app, "mars") and page.chosen == "mars" and bench.history.undo_label == "add mars"
    assert list(app.scene.planets) == ["earth", "moon", "mars"]
    assert page.add(app, "mars") and page.chosen == "mars 2"
    found = bodies(app.scene, app.time_s)
    for k, one in enumerate(found):
        for other in found[k + 1 :]:
            assert ((one.centre_m - other.centre_m) ** 2).sum() ** 0.5 > one.reach_m + other.reach_m
    pose = app.pilot.pose
    assert (found[2].centre_m - pose.position_m) @ pose.forward > 0.0 or abs(float(pose.forward[2])) > 0.7
    companion = app.scene.companions["mars"]
    page.chosen = "mars"
    page.remove(app)
    assert "mars" not in app.scene.planets and page.chosen == "earth"
    bench.undo()
    assert app.scene.companions["mars"].scene is companion.scene  # with its objects, and what a game holds of it
    assert app.scene.companions["mars"].orbit is companion.orbit
    for _ in range(2):
        bench.undo()
    assert list(app.scene.planets) == ["earth", "moon"] and bench.differences() == {}
    bench.redo()
    assert app.scene.planets["mars"].radius_m == companion.scene.planet.radius_m


def test_a_companion_that_the_game_took_away_comes_back_when_it_is_undone(flight):
    """One that another scene has by then is made anew."""
    app, settings = flight
    page, bench, moon = settings.planets, settings.bench, app.scene.companions["moon"]
    ground = dataclasses.replace(moon.scene.planet[pf.Terrain])
    page.chosen = "moon"
    page.remove(app)
    with pf.load_scene("mars") as other:
        other.companions.add(moon.scene)
        bench.undo()
        assert app.scene.companions["moon"].scene is not moon.scene
        assert app.scene.planets["moon"][pf.Terrain] == ground
        app.scene.companions.remove("moon")
        bench.undo()  # nothing of it is left to undo: no error
        assert bench.reset() == "" and "moon" in app.scene.planets


def test_random_walks_are_undone_and_done_again(flight):
    app, settings = flight
    page, bench, draw = settings.planets, settings.bench, random.Random(3)
    states = [bench.copy()]
    for step in range(40):
        names = list(app.scene.companions)
        page.chosen = draw.choice([*names, "earth"])
        what = draw.randrange(4)
        if what == 0 and len(names) < 4:
            page.add(app, draw.choice(["moon", "asteroid", "mars"]))
        elif what == 1 and page.chosen != "earth":
            page.remove(app)
        elif what == 2 and page.chosen != "earth":
            heading = f"{page.chosen}: Terrain"
            there = heading in bench.store.parts()
            assert (bench.remove(heading) if there else bench.add(heading, pf.Terrain(seed=step))) == ""
        elif page.chosen != "earth":
            turn(settings, f"{page.chosen}: Orbit", "phase_deg", float(step))
        if bench.copy() != states[-1]:
            states.append(bench.copy())
    assert len(states) > 15 and len(bench.history) == len(states) - 1
    for state in reversed(states[:-1]):
        bench.undo()
        assert bench.copy() == state
    for state in states[1:]:
        bench.redo()
        assert bench.copy() == state


def test_what_differs_is_a_scene_file(flight, tmp_path):
    app, settings = flight
    assert settings.toml() == "# nothing differs from the preset\n"
    turn(settings, "moon: Terrain", "craters", 0.25)
    turn(settings, "moon: Orbit", "phase_deg", 12.5)
    assert settings.toml() == (
        '[[companions]]\nname = "moon"\nbase = "moon"\n\n[companions.orbit]\ninclination_deg = 23.4\nphase_deg = 12.5\n'
        "\n[companions.terrain]\ncraters = 0.25\n"
    )
    settings.planets.add(app, "asteroid")
    settings.bench.remove("asteroid: Terrain")  # which no table over a base can say
    turn(settings, "Ocean", "roughness", 0.5)
    file = tmp_path / "mine.toml"
    file.write_text('base = "earth_moon"\n' + settings.toml())
    with pf.load_scene(file) as again:
        assert list(again.companions) == ["moon", "asteroid"]
        for name, companion in app.scene.companions.items():
            assert again.companions[name].orbit == companion.orbit
            assert again.planets[name].components() == companion.scene.planet.components()
        assert again.planet[pf.Ocean].roughness == 0.5
    settings.bench.reset()
    settings.planets.chosen = "moon"
    settings.planets.remove(app)
    file.write_text('base = "earth_moon"\n' + settings.toml())
    with pf.load_scene(file) as again:
        assert not again.companions


def test_presets_bring_their_companions(flight, tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path))
    app, settings = flight
    bench = settings.bench
    turn(settings, "moon: Orbit", "phase_deg", 77.0)
    assert settings.save(app, "mine")
    assert settings.load(app, "mars_moons") and list(app.scene.planets) == ["earth", "phobos", "deimos"]
    assert bench.differences() == {} and app.scene.planet.radius_m < 4e6
    assert settings.load(app, "mine") and list(app.scene.planets) == ["earth", "moon"]
    assert app.scene.companions["moon"].orbit.phase_deg == 77.0
    assert settings.load(app, "mars") and list(app.scene.planets) == ["earth", "moon"]  # a planet alone
    for _ in range(3):
        bench.undo()
    assert app.scene.companions["moon"].orbit.phase_deg == 77.0 and app.scene.planet.radius_m > 6e6
    # A companion that is called as the scene's own planet gets another name.
    (tmp_path / "over.toml").write_text('base = "moon"\n[[companions]]\nbase = "earth"\n')
    assert settings.load(app, "over") and list(app.scene.planets) == ["earth", "earth 2"]
    # Refused as a whole: the planet would reach its moon.
    bench.undo()
    kept = bench.copy()
    (tmp_path / "huge.toml").write_text("[planet]\nradius_m = 1e8\n[[companions]]\nbase = 'moon'\n"
                                        "[companions.orbit]\ndistance_m = 5e7\n")  # fmt: skip
    assert not settings.load(app, "huge") and bench.copy() == kept


def test_what_a_preset_has_no_parts_for_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path))
    (tmp_path / "things.toml").write_text(
        'base = "earth_moon"\n[[props]]\nname = "a"\n[props.shape]\n[[props]]\nname = "b"\n[props.shape]\n'
    )
    assert left_out("earth") == left_out("earth_moon") == [] and left_out("things") == ["2 objects"]


def test_scenes_of_planets_that_were_taken_out_are_released_with_theirs():
    with pf.load_scene("earth") as scene:
        app, _, _ = app_of(scene)
        settings = SettingsWindow(scene, FrameHistory(4))
        settings.remember(app)
        settings.planets.add(app, "asteroid")
        own = scene.companions["asteroid"].scene
        settings.planets.remove(app)
        assert not own.world.closed
    assert own.world.closed


def test_objects_of_a_companion_are_undone_where_they_were(flight):
    app, settings = flight
    bench, moon = settings.bench, app.scene.companions["moon"].scene
    heading = bench.store.new_object_heading()
    parts = PropParts("hut", (pf.Transform((1.8e6, 0.0, 0.0)), pf.Shape("box")), "moon")
    assert bench.do([Edit(heading, "", None, parts)], "add hut") == ""
    (hut,) = moon.props
    assert app.scene.props == () and hut.name == "hut"
    assert bench.do([Edit(f"{heading}/Shape", "roughness", 0.8, 0.3)], "rough") == "" and hut[pf.Shape].roughness == 0.3
    settings.planets.chosen = "moon"
    settings.planets.remove(app)
    bench.undo()
    assert bench.undo() == "rough" and hut[pf.Shape].roughness == 0.8
    assert bench.undo() == "add hut" and moon.props == ()
    assert bench.redo() == "add hut" and [prop.name for prop in moon.props] == ["hut"] and app.scene.props == ()
