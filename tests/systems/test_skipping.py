"""What a scene doesn't need costs nothing: passes, calls, GL objects and imports of scenes that lack something."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import planetfall as pf
from planetfall.benchmarks.measure.skipping import (
    BARE,
    FULL,
    LIGHT_SYSTEMS,
    STAGES,
    Counts,
    RunningCase,
    counts,
    imports_of,
    running_case,
    timed_together,
)
from planetfall.render.system_list import SYSTEMS

pytestmark = pytest.mark.gpu

SIZE = (96, 54)
BY_NAME = {stage.name: stage for stage in STAGES}
PLANET_SYSTEMS = ("terrain", "shadows", "ocean", "atmosphere", "clouds")


@pytest.fixture(scope="module")
def full() -> Iterator[RunningCase]:
    with running_case(FULL, SIZE, "low") as shown:
        yield shown


@pytest.fixture(scope="module")
def all_of_it(full: RunningCase) -> Counts:
    return counts(full)


def of(name: str) -> Counts:
    with running_case(BY_NAME[name], SIZE, "low") as shown:
        return counts(shown)


def test_entries_say_what_their_classes_say():
    for entry in SYSTEMS:
        kind = entry.load()
        assert (kind.name, kind.needs, kind.__name__) == (entry.name, entry.needs, entry.kind)


def test_the_moon_has_terrain_light_and_composite_alone():
    moon = of("airless moon")
    assert set(moon.ran.values()) <= set(LIGHT_SYSTEMS)
    for absent in ("ocean", "atmosphere", "clouds", "props", "debug"):
        assert absent not in moon.objects and absent not in moon.systems


@pytest.mark.slow
def test_the_moon_runs_no_more_than_earth_does_of_the_same(all_of_it: Counts):
    with running_case(BY_NAME["airless moon"], SIZE, "low") as shown:
        moon = counts(shown)
    ours = [name for name, system in all_of_it.ran.items() if system in LIGHT_SYSTEMS]
    assert len(moon.ran) <= len(ours)
    assert moon.programs < all_of_it.programs and moon.gl_objects < all_of_it.gl_objects


@pytest.mark.slow
def test_what_is_absent_has_no_object_and_no_program(all_of_it: Counts):
    for name, absent in (("dry world", "ocean"), ("cloudless", "clouds")):
        found = of(name)
        assert absent in all_of_it.objects and absent not in found.objects
        assert absent not in found.ran.values()
        assert found.programs < all_of_it.programs


@pytest.mark.slow
def test_a_paused_scene_copies_its_picture(full: RunningCase):
    with running_case(BY_NAME["paused, still camera"], SIZE, "low") as shown:
        found = counts(shown)
        both = timed_together({"full": full.frame, "paused": shown.frame}, 5)
    assert list(found.ran) == ["outputs.present"]
    assert (found.draws, found.dispatches, found.uploads, found.programs_built) == (1, 0, 0, 0)
    # Promised are 5 % at 640 x 360; the copy's fixed cost weighs more in a small picture.
    assert both["paused"].cpu_ms <= 0.2 * both["full"].cpu_ms


@pytest.mark.parametrize("name", ["planet behind the camera", pytest.param("deep space", marks=pytest.mark.slow)])
def test_of_a_planet_that_nobody_sees_nothing_is_drawn(name: str):
    with running_case(BARE, SIZE, "low") as bare:
        least = counts(bare)
    found = of(name)
    assert not set(found.ran.values()) & set(PLANET_SYSTEMS)
    assert found.draws <= least.draws and found.dispatches <= least.dispatches
    assert found.programs_built == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["planet of 3 px", "night side", "under water"])
def test_other_views_run_no_more_than_the_full_scene(name: str, all_of_it: Counts):
    found = of(name)
    assert found.programs_built == 0
    assert len(found.ran) <= len(all_of_it.ran)
    if name == "under water":
        assert not [p for p in found.ran if p.startswith("clouds.") and p not in ("clouds.shadow", "clouds.sky")]


def test_a_bare_world_imports_no_system_that_it_lacks():
    found = imports_of("moon", bare=True)
    for folder in ("atmosphere", "clouds", "ocean", "props"):
        assert not [name for name in found if f".systems.{folder}" in name], folder
    lacks = {"imgui_bundle", "glfw", "pyglet", "moderngl_window", "scipy"}
    # The compiler of loops, where it is installed, imports scipy if that is.
    assert not found & (lacks - {"scipy"} if "numba" in found else lacks)


def test_a_part_that_is_added_later_is_found():
    with pf.load_scene("moon") as scene, pf.Renderer(scene, (16, 9), "low") as renderer:
        renderer.render(pf.view("near", scene.planet))
        assert renderer.system("debug") is None
        scene.environment.add(pf.DebugView())
        renderer.render(pf.view("near", scene.planet))
        assert renderer.system("debug") is not None
        names = [system.name for system in renderer.systems]
        order = [entry.name for entry in SYSTEMS]
        assert names == sorted(names, key=order.index)
