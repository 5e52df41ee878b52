"""Snaps of the proxy that are prepared over some frames: even work, the same bits, no hole, at once where needed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import descent, snaps
from planetfall.engine.frame.snapping import HeldScale, SnapAhead
from planetfall.engine.gpu import GpuScope
from planetfall.engine.gpu.cell_mesh import CellMesh
from planetfall.engine.snapped import MeshAhead
from planetfall.engine.surface.proxy import snap_proxy
from planetfall.systems.proxy.waiting import Motion, may_wait

SIZE = (96, 54)
EARTH_M = 6.371e6
BAND_M = (-11000.0, 9000.0)


def at(altitude_m: float, aside_m: float = 0.0) -> np.ndarray:
    angle = aside_m / EARTH_M
    return (EARTH_M + altitude_m) * np.array([math.cos(angle), math.sin(angle), 0.0])


def cell_at(altitude_m: float):
    return snap_proxy(at(altitude_m), EARTH_M, lambda d: np.zeros(len(d)), None)


# -- whose turn it is -----------------------------------------------------------------------------------------------


def test_phases_come_in_their_order_and_only_those_somebody_does():
    ahead = SnapAhead()
    assert not ahead.wanted and not ahead.ready and ahead.phase == ""
    ahead.take_part(True, "fade", "ground")
    ahead.begin("there", 16)
    assert ahead.wanted and ahead.phase == "ground"
    ahead.finish("sea")  # not its turn
    assert ahead.phase == "ground"
    ahead.finish("ground")
    assert ahead.phase == "fade" and not ahead.ready
    ahead.finish("fade")
    assert ahead.ready
    ahead.drop()
    assert not ahead.ready


@pytest.mark.parametrize("frames", [3, 4, 5, 6])
def test_a_maker_that_begins_early_has_a_frame_more_and_does_less_in_it(frames: int):
    ahead, spent, count = SnapAhead(), 0, 12000
    ahead.take_part(True, "ground", "sea", "fade")
    ahead.begin("there", frames)
    assert ahead.hurried
    ahead.begin_early()
    while phase := ahead.phase:
        first, other = ahead.part(phase, count, 4, True), ahead.part(phase, count, 4)
        assert first < other or phase != "ground" or other >= count
        spent += 1 + math.ceil(max(count - first, 0) / other)
        ahead.finish(phase)
    assert spent == frames + 1
    ahead.begin("there", 7)
    assert not ahead.hurried and ahead.part("ground", count, 4, True) == ahead.part("ground", count, 4)


def test_a_maker_that_leaves_ends_what_waits_for_it():
    ahead = SnapAhead()
    ahead.take_part(True, "ground", "sea")
    ahead.begin("there", 16)
    ahead.take_part(False, "sea")
    assert ahead.proxy is None and ahead.phase == ""


@pytest.mark.parametrize("frames", [1, 3, 4, 5, 6, 7, 16, 40])
@pytest.mark.parametrize("makers", [("ground",), ("ground", "fade"), ("ground", "sea", "fade")])
def test_phases_take_all_of_the_frames(frames: int, makers: tuple[str, ...]):
    ahead, spent, count = SnapAhead(), 0, 12000
    ahead.take_part(True, *makers)
    ahead.begin("there", frames)
    while phase := ahead.phase:
        spent += math.ceil(count / ahead.part(phase, count, 4))
        ahead.finish(phase)
    assert spent == max(frames, len(makers))


@pytest.mark.parametrize("frames", [1, 4, 16])
@pytest.mark.parametrize("count", [1, 37, 359, 12000])
def test_parts_are_alike_and_whole_steps(frames: int, count: int):
    ahead = SnapAhead()
    ahead.take_part(True, "ground")
    ahead.begin("there", frames)
    part = ahead.part("ground", count, 4)
    assert part % 4 == 0 and part * frames >= count
    assert part <= 4 * math.ceil(count / max(round(0.45 * frames), 1) / 4)


def test_a_zoom_asks_for_a_snap_where_it_may_wait():
    ahead, held = SnapAhead(), HeldScale()
    held.follow(ahead, 8.0, 1e-3)
    assert held.value == (8.0, 1e-3)
    ahead.possible = True
    held.follow(ahead, 8.0, 1.04e-3)
    assert held.value == (8.0, 1e-3) and not ahead.asked
    held.follow(ahead, 8.0, 1.1e-3)
    assert held.value == (8.0, 1e-3) and ahead.asked
    held.follow(ahead, 8.0, 2e-3)  # triangles would be twice too long
    assert held.value == (8.0, 2e-3)


# -- how long, and where to -----------------------------------------------------------------------------------------


def test_waits_near_its_cell_and_not_where_there_is_no_ground_or_it_is_coarse():
    cell = cell_at(1000.0)
    limits = (0.0, -math.inf, BAND_M)
    assert may_wait(cell, at(800.0), *limits)
    assert not may_wait(cell, at(300.0), *limits)  # triangles more than three times too long
    assert not may_wait(cell, at(1000.0, 3500.0), *limits)
    assert not may_wait(cell, at(3000.0), *limits)  # its horizon lies beyond what is covered
    assert not may_wait(cell, at(800.0), 600.0, -math.inf, BAND_M)  # a mountain below
    assert may_wait(cell.covering(3500.0, 0.0), at(3000.0), *limits)


def test_a_dive_into_the_sea_does_not_wait():
    cell = cell_at(10.0)
    assert may_wait(cell, at(8.0), 0.0, 0.0, BAND_M)
    assert not may_wait(cell, at(-1.0), -9.0, 0.0, BAND_M)


def flown(motion: Motion, places: list[np.ndarray], dt_s: float = 0.04) -> None:
    for place in places:
        motion.follow(place, EARTH_M, 0.0, dt_s)


def test_a_slow_camera_has_all_the_frames_and_a_fast_one_fewer():
    counts = []
    for step_m in (0.0, 1.0, 30.0, 200.0, 2000.0):
        motion = Motion()
        flown(motion, [at(1000.0, 0.0), at(1000.0, step_m)])
        counts.append(motion.frames_of(cell_at(1000.0), 16))
    assert counts[0] == counts[1] == 16 and counts == sorted(counts, reverse=True)
    assert 0 < counts[3] < 16 and counts[4] == 0


def test_a_dive_that_gets_steeper_has_fewer_frames():
    steady, steeper = Motion(), Motion()
    flown(steady, [at(1000.0), at(1000.0 * 0.9), at(1000.0 * 0.9**2)])
    flown(steeper, [at(1000.0), at(1000.0 * 0.93), at(1000.0 * 0.93 * 0.9)])
    cell = cell_at(810.0)
    assert 0 < steeper.frames_of(cell, 16) < steady.frames_of(cell, 16)


def test_foresees_a_descent_and_level_flight():
    motion = Motion()
    flown(motion, [at(1000.0), at(980.0)])
    foot, above_m = motion.foreseen(8, 16)
    # Half as long again as until the snap, which takes 2 frames besides: 15 frames, each 0.98 times lower.
    assert above_m == pytest.approx(980.0 * 0.98**15, rel=1e-6)
    np.testing.assert_allclose(foot, [1.0, 0.0, 0.0], atol=1e-12)
    motion.forget()
    flown(motion, [at(1000.0, 0.0), at(1000.0, 10.0)])
    foot, above_m = motion.foreseen(8, 16)
    assert above_m == pytest.approx(1000.0) and EARTH_M * math.atan2(foot[1], foot[0]) == pytest.approx(160.0, rel=1e-4)


def test_one_long_frame_is_no_fast_flight():
    motion, steady = Motion(), Motion()
    flown(steady, [at(1000.0, 10.0 * k) for k in range(9)])
    flown(motion, [at(1000.0, 10.0 * k) for k in range(8)])
    motion.follow(at(1000.0, 170.0), EARTH_M, 0.0, 0.4)  # ten times as long, ten times as far
    cell = cell_at(1000.0)
    there, then = motion.foreseen(8, 16)[0], steady.foreseen(8, 16)[0]
    ahead_m = [EARTH_M * math.atan2(p[1], p[0]) - x for p, x in ((there, 170.0), (then, 80.0))]
    assert ahead_m[0] == pytest.approx(ahead_m[1], rel=1e-6)
    assert motion.frames_of(cell, 16) == steady.frames_of(cell, 16)


def test_what_was_foreseen_is_covered_on_the_way_there():
    motion = Motion()
    flown(motion, [at(1000.0), at(960.0, 50.0)])
    frames = motion.frames_of(cell_at(1000.0), 16)
    foot, above_m = motion.foreseen(frames, 16)
    cell = snap_proxy(foot * (EARTH_M + above_m), EARTH_M, lambda d: np.zeros(len(d)), None)
    assert not may_wait(cell, at(960.0, 50.0), 0.0, -math.inf, BAND_M)
    cell = motion.covered(cell, frames, 16)
    for k in range(frames):
        assert may_wait(cell, at(960.0 * 0.96**k, 50.0 + 50.0 * sum(0.96**n for n in range(k))), 0.0, -math.inf, BAND_M)


# -- in pictures ----------------------------------------------------------------------------------------------------


def flight_of(scene: pf.Scene, frames: int = 60) -> descent.Flight:
    return descent.descent(scene, frames, 44.0, 44.0 + 0.06 * frames)


def systems_of(renderer: pf.Renderer):
    by_name = {system.name: system for system in renderer.systems}
    return by_name["terrain"].backend.view(renderer.views[0]), by_name["ocean"].method.view(renderer.views[0])


def ran(renderer: pf.Renderer) -> set[str]:
    return {p.name for p in renderer.passes() if p.ran}


def waits(renderer: pf.Renderer) -> bool:
    """Whether a snap was being prepared in the last frame."""
    return renderer.views[0].snap.proxy is not None


@pytest.fixture(scope="module")
def scene() -> pf.Scene:
    """The ground alone: trees that come near are a change of their own."""
    found = pf.load_scene("earth")
    found.planet.remove(pf.Cover)
    return found


@pytest.mark.gpu
def test_no_frame_of_a_flight_makes_all_vertices_and_they_have_the_bits_of_those_made_at_once(scene: pf.Scene):
    flight = flight_of(scene)
    whole, kept, swaps = {"terrain.vertices", "ocean.vertices"}, [], 0
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        number = renderer.views[0].proxy.generation
        for camera in flight.cameras[1:]:
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            assert not whole & ran(renderer)
            now = renderer.views[0].proxy.generation
            if now == number:
                continue
            number, swaps = now, swaps + 1
            views = systems_of(renderer)
            for view in views:
                kept.append((view.mesh.read_cells().tobytes(), view.mesh.read_vertices().tobytes()))
                view.made = None  # all of them once more
            renderer.render(camera, sun=flight.sun, dt_s=0.0)
            assert whole <= ran(renderer)
            for view, (cells, vertices) in zip(views, kept[-2:], strict=True):
                assert view.mesh.read_cells().tobytes() == cells
                assert view.mesh.read_vertices().tobytes() == vertices
    assert swaps >= 2


@pytest.mark.gpu
def test_the_last_dive_has_the_bits_of_vertices_made_at_once_too(scene: pf.Scene):
    """With so few frames the ground begins in that of the choice; inland the sea asks for no depths."""
    flight, early, number, swaps = descent.descent(scene, 28, 56.5, 59.2), 0, 0, 0
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        ahead = renderer.views[0].snap
        begun, generation = ahead.number, renderer.views[0].proxy.generation
        for camera in flight.cameras[1:]:
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            early += ahead.number != begun and ahead.hurried and "terrain.ahead" in ran(renderer)
            begun, number = ahead.number, renderer.views[0].proxy.generation
            if number == generation or {"terrain.vertices", "ocean.vertices"} & ran(renderer):
                generation = number
                continue
            generation, swaps = number, swaps + 1
            views = systems_of(renderer)
            kept = [view.mesh.read_vertices().tobytes() for view in views]
            for view in views:
                view.made = None
            renderer.render(camera, sun=flight.sun, dt_s=0.0)
            assert [view.mesh.read_vertices().tobytes() for view in views] == kept
    assert swaps >= 2 and early >= 1


@pytest.mark.gpu
def test_no_frame_makes_vertices_of_the_ground_and_of_the_sea(scene: pf.Scene):
    flight, made = flight_of(scene, 40), {"terrain.ahead": 0, "ocean.ahead": 0, "terrain.fade": 0}
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        structure = 0
        for camera in flight.cameras[1:]:
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            now = renderer.views[0].structure + sum(system.structure for system in renderer.systems)
            if now == structure:  # a graph that was just compiled runs every pass once
                shares = made.keys() & ran(renderer)
                assert len(shares) <= 1
                for name in shares:
                    made[name] += 1
            structure = now
    assert min(made.values()) >= 2


@pytest.mark.gpu
def test_pictures_by_themselves_and_settled_ones_do_not_wait(scene: pf.Scene):
    flight = flight_of(scene)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        cameras = iter(flight.cameras[1:])
        for single in (True, False):
            for camera in cameras:
                renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
                if waits(renderer):
                    break
            assert waits(renderer)
            if single:
                found = renderer.render(camera, sun=flight.sun)["color"]
            else:
                renderer.settle(camera, sun=flight.sun)
            assert not waits(renderer)
            position_m = renderer.camera_state(camera).position_m
            assert renderer.views[0].proxy.cell.contains(position_m)
            if single:
                with pf.Renderer(scene, SIZE, "low") as fresh:
                    fresh.settle(camera, sun=flight.sun)
                    off = np.abs(fresh.render(camera, sun=flight.sun)["color"].astype(int) - found)
                # Shadows and air of the flight have not settled.
                assert np.mean(off.max(axis=2) > 16) < 0.02


@pytest.mark.gpu
def test_a_camera_that_stops_comes_to_rest_with_a_grid_of_its_own(scene: pf.Scene):
    flight = flight_of(scene)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        for camera in itertools.islice(flight.cameras, 1, 12):
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
        assert waits(renderer)
        for _ in range(60):
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
        position_m = renderer.camera_state(camera).position_m
        assert not waits(renderer) and renderer.views[0].proxy.cell.contains(position_m)


@pytest.mark.gpu
@pytest.mark.parametrize("up", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_camera_that_waits_sees_no_hole(scene: pf.Scene, up: bool):
    flight = flight_of(scene, 40)
    cameras = flight.cameras[::-1] if up else flight.cameras
    checked = 0
    with pf.Renderer(scene, SIZE, "low") as renderer, pf.Renderer(scene, SIZE, "low") as single:
        renderer.settle(cameras[0], sun=flight.sun)
        for number, camera in enumerate(cameras[1:]):
            seen = renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s, outputs=("surface",))["surface"] > 0
            held = renderer.views[0].proxy.cell
            if number % 4 or held.contains(renderer.camera_state(camera).position_m):
                continue
            truth = single.render(camera, sun=flight.sun, outputs=("surface",))["surface"] > 0
            # Along the skyline a pixel's centre may fall to either side.
            assert (seen != truth).sum() <= SIZE[0] // 8
            checked += 1
    assert checked >= 3


@pytest.mark.gpu
def test_nothing_is_prepared_where_it_is_off(scene: pf.Scene):
    flight = flight_of(scene, 12)
    with pf.Renderer(scene, SIZE, "low", {"proxy.ahead_frames": 0}) as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        made = 0
        for camera in flight.cameras[1:]:
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            assert not waits(renderer)
            made += "terrain.vertices" in ran(renderer)
    assert made >= 2


@pytest.mark.gpu
@pytest.mark.parametrize(("view", "step_m"), [("near", 4.0), pytest.param("high", 400.0, marks=pytest.mark.slow)])
def test_the_ground_moves_little_at_a_snap_that_was_prepared(scene: pf.Scene, view: str, step_m: float):
    with pf.Renderer(scene, (192, 108), "medium") as renderer:
        path = snaps.forward_path(renderer.camera_state(pf.view(view)), step_m, 60)
        found = snaps.prepared_pops(renderer, list(path), 2)
    assert found.snaps == 2
    # As of a snap at once, in tests/pictures/test_overlay.py, although it leads several times as far.
    assert max(found.a_frame) <= 0.25
    assert snaps.Pops.quantile(found.in_all, 0.999) <= 1.0


@pytest.mark.gpu
def test_a_snap_that_was_prepared_changes_no_light_in_its_frame(scene: pf.Scene):
    flight, ratios = descent.descent(scene, 60, 44.0, 48.0), []
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        for camera in flight.cameras[1:]:
            shown = {"sun": flight.sun, "outputs": ("radiance", "surface")}
            before = renderer.render(camera, dt_s=flight.frame_s, **shown)
            if renderer.views[0].snap.ready:
                after = renderer.render(camera, dt_s=0.0, **shown)
                land = (before["surface"] == 1) & (after["surface"] == 1)
                ratios.append(np.log(after["radiance"][land].sum(axis=1) / before["radiance"][land].sum(axis=1)))
    assert len(ratios) >= 2 and min(map(len, ratios)) > 2000
    # Colours do not hang on the mesh, and the relief that its normals lack fades with them.
    assert max(np.abs(r).mean() for r in ratios) <= 0.004
    assert max(np.quantile(np.abs(r), 0.99) for r in ratios) <= 0.05


@pytest.mark.gpu
def test_vertices_that_are_prepared_change_nothing_that_is_drawn(scene: pf.Scene, monkeypatch: pytest.MonkeyPatch):
    flight = flight_of(scene, 30)

    def pictures(first_of: int = 100) -> list[np.ndarray]:
        """Up to the first snap, which never comes where nothing is made."""
        found, prepared = [], 0
        with pf.Renderer(scene, SIZE, "low") as renderer:
            renderer.settle(flight.cameras[0], sun=flight.sun)
            number = renderer.views[0].proxy.generation
            for camera in flight.cameras[1:first_of]:
                shown = renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s, outputs=("radiance",))
                if renderer.views[0].proxy.generation != number:
                    break
                found.append(shown["radiance"])
                prepared += "terrain.ahead" in ran(renderer)
        assert prepared >= 3
        return found

    made = pictures()
    monkeypatch.setattr(MeshAhead, "bind", lambda self, io: lambda: None)
    for shown, expected in zip(made, pictures(len(made) + 1), strict=True):
        np.testing.assert_array_equal(shown, expected)


@pytest.mark.gpu
def test_a_snap_to_more_cells_than_there_is_room_for_has_the_prepared_vertices(scene: pf.Scene):
    flight = flight_of(scene)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        for camera in flight.cameras[1:]:
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            if renderer.views[0].snap.ready:
                break
        views = systems_of(renderer)
        wanted = [(v.ahead.mesh.read_cells().tobytes(), v.ahead.mesh.read_vertices().tobytes()) for v in views]
        for view in views:
            view.mesh.capacity = 1  # as if there had been fewer cells so far
        renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
        found = [(v.mesh.read_cells().tobytes(), v.mesh.read_vertices().tobytes()) for v in views]
        assert found == wanted and all(v.mesh.capacity >= v.mesh.count > 1 for v in views)


@pytest.mark.gpu
def test_a_flight_makes_room_for_what_it_prepares_with_its_first_frame(monkeypatch: pytest.MonkeyPatch):
    """And not bit by bit: a graph that is compiled again takes long, and its history is lost."""
    monkeypatch.setattr(CellMesh.__init__, "__defaults__", (300,))
    with pf.Renderer(pf.load_scene("earth"), (160, 90), "medium") as renderer:
        state = renderer.camera_state(pf.view("near"))
        plans, snapped = set(), 0
        for step in range(40):
            position = state.position_m + (3.0 * state.forward + 0.4 * state.up) * step
            camera = pf.Camera(position_m=position, forward=state.forward, up=state.up)
            renderer.render(camera, dt_s=1.0 / 60.0)
            plans.add(id(renderer.graph))
            snapped += "terrain.fade" in ran(renderer)
        terrain, _ = systems_of(renderer)
        assert terrain.mesh.capacity == 600 and snapped
        assert len(plans) == 1


@pytest.mark.gpu
def test_makers_that_need_more_room_make_it_together(monkeypatch: pytest.MonkeyPatch):
    """Ground and sea have about as many cells. One by one five meshes would grow in five frames, of which each compiles
    the graph."""
    monkeypatch.setattr(CellMesh.__init__, "__defaults__", (128,))
    scene = pf.load_scene("earth")
    flight = descent.descent(scene, 100, 44.0, 50.0)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        plans, most = [], 0
        for camera in flight.cameras[1:60]:  # later waves begin to move
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            if not plans or plans[-1] is not renderer.graph:
                plans.append(renderer.graph)
            most = max(most, systems_of(renderer)[0].mesh.count)
        terrain, ocean = systems_of(renderer)
        # Room for the first snap with the first frame; for more that is prepared, at once; for more that is drawn.
        assert len(plans) == 3
        meshes = [terrain.mesh, terrain.ahead.mesh, terrain.fade.mesh, ocean.mesh, ocean.ahead.mesh]
        assert most > 266 and {mesh.capacity for mesh in meshes} == {532}


@pytest.mark.gpu
def test_room_is_made_for_what_another_maker_has_and_no_more(scope: GpuScope):
    """Twice as much at each snap is soon as much as a buffer may hold."""
    one, other = (CellMesh(scope, name, 8, 100) for name in ("one", "other"))
    assert one.reserve(150) and not one.reserve(150) and one.capacity == 150
    assert other.take(one) and other.capacity == 150
