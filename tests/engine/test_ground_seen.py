"""Whether ground is in the picture: never denied where a ray meets it, and what draws it rests where it is not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.space import CameraState, least_angle_rad, least_elevation_rad, sphere_unseen
from planetfall.engine.surface.skyline import Skyline
from planetfall.systems.proxy.system import ProxySystem
from planetfall.systems.terrain.backends.base import Backend
from planetfall.systems.terrain.backends.grid import GridBackend
from planetfall.systems.terrain.backends.paper_grid import PaperGridBackend
from planetfall.systems.terrain.backends.quadtree import QuadtreeBackend
from planetfall.systems.terrain.ground_params import ground_params
from planetfall.systems.terrain.height import TerrainField

SIZE = (96, 54)
RADIUS_M, TOP_M = 6.371e6, 9000.0
SKY = {  # altitude above what, pitch
    "100 m, straight up": (100.0, "ground", 90.0),
    "20 km": (2e4, "sphere", 86.0),
    "400 km": (4e5, "sphere", 60.0),
}
Asked = dict[type, dict[str, str]]
PRINTED: Asked = {pf.Terrain: {"method": "paper"}, pf.Ocean: {"method": "paper_2019"}}
TILES: Asked = {pf.Terrain: {"backend": "quadtree"}}
GROUND = ("terrain.gbuffer", "terrain.shade", "ocean.gbuffer", "ocean.shade", "gbuffer.classify", "ocean.displace")


def cases(count: int, seed: int) -> list[CameraState]:
    """Cameras from metres above the highest ground to far away, with pictures of any shape, on the axis and off it."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(count):
        where, ahead, up = rng.normal(size=(3, 3))
        where *= (RADIUS_M + TOP_M + 10.0 ** rng.uniform(0.0, 8.0)) / np.linalg.norm(where)
        x, y = rng.uniform(-2.0, 2.0, 2) if rng.random() < 0.5 else (0.0, 0.0)
        w, h = 10.0 ** rng.uniform(-2.0, 1.0, 2)
        angles = np.degrees(np.arctan([x - w, x + w, y - h, y + h])).tolist()
        found.append(CameraState.frustum_deg(where, ahead, up, angles))
    return found


def test_no_ray_of_a_picture_without_the_sphere_meets_it() -> None:
    cameras, steps = cases(10000, 3), np.linspace(0.0, 1.0, 9)
    top, unseen = RADIUS_M + TOP_M, 0
    for camera in cameras:
        x = camera.tan_left + (camera.tan_right - camera.tan_left) * steps
        y = camera.tan_bottom + (camera.tan_top - camera.tan_bottom) * steps
        rays = np.stack(np.broadcast_arrays(x[:, None], y, 1.0), axis=-1).reshape(-1, 3) @ camera.axes
        down = -(rays @ camera.direction) / np.linalg.norm(rays, axis=1)
        least = math.acos(min(float(down.max()), 1.0))
        angle = least_angle_rad(camera, -camera.direction)
        assert angle <= least + 1e-7
        # No ray of the picture is farther from a sampled one than half a step's diagonal, as an angle at most that.
        assert angle >= least - 0.5 * math.hypot(x[1] - x[0], y[1] - y[0]) - 1e-7
        # The sphere is met where the line passes the centre nearer than its radius, ahead of the camera.
        beyond = down > 0.0
        hits = beyond & (camera.distance_m * np.sqrt(np.maximum(1.0 - down * down, 0.0)) < top * (1.0 - 1e-9))
        if sphere_unseen(camera, top):
            unseen += 1
            assert not hits.any()
            assert not sphere_unseen(camera, camera.distance_m)
    assert 2000 < unseen < 9000


def test_a_wider_picture_is_never_farther() -> None:
    for camera in cases(500, 5):
        angles = [least_angle_rad(camera, -camera.direction, m) for m in (0.0, 0.01, 0.3)]
        assert angles == sorted(angles, reverse=True)


@pytest.mark.parametrize("planet", ["earth", "moon", "mars"])
def test_ground_is_never_said_to_be_lower_than_it_is(planet: str) -> None:
    scene = pf.load_scene(planet)
    radius = scene.planet.radius_m
    field = TerrainField(ground_params(scene.planet[pf.Terrain], radius))
    rng, told = np.random.default_rng(7), 0
    for _ in range(25):
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        above_m = 10.0 ** rng.uniform(0.3, 3.5)
        position = up * (radius + float(field.height(up[None])[0]) + above_m)
        # Places around, log-uniform in distance.
        theta = 10.0 ** rng.uniform(math.log10(above_m / 20.0 / radius), math.log10(6e4 / radius), 4000)
        side = np.cross(up, rng.normal(size=(4000, 3)))
        side /= np.linalg.norm(side, axis=1)[:, None]
        d = np.cos(theta)[:, None] * up + np.sin(theta)[:, None] * side
        rays = d * (radius + field.height(d))[:, None] - position
        highest = float(np.arcsin((rays @ up / np.linalg.norm(rays, axis=1)).max()))
        skyline = Skyline()
        for degrees in (70.0, 40.0, 25.0, 12.0, 6.0):
            if skyline.below(field, position, radius, math.radians(degrees)):
                told += 1
                assert highest < math.radians(degrees - 2.0)
    assert told >= 25


def test_a_peak_over_the_valley_is_seen() -> None:
    """Ground right beside the camera, up to where rays that start at it still meet it."""
    scene = pf.load_scene("earth")
    state = pf.view("valley").resolve(scene, 16.0 / 9.0)
    radius = scene.planet.radius_m
    field = TerrainField(ground_params(scene.planet[pf.Terrain], radius))
    up, count = state.direction, 360
    theta = np.geomspace(20.0, 4e4, 200) / radius
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    around = np.cos(angles)[:, None] * east + np.sin(angles)[:, None] * np.cross(up, east)
    d = (np.cos(theta)[:, None, None] * up + np.sin(theta)[:, None, None] * around).reshape(-1, 3)
    rays = d * (radius + field.height(d))[:, None] - state.position_m
    elevation = np.arcsin(rays @ up / np.linalg.norm(rays, axis=1))
    peak = int(elevation.argmax())
    assert elevation[peak] > math.radians(3.0), "a mountain beside the camera"
    # A picture whose lowest rays just show it, by pitch; and one far above it.
    toward = around[peak % count]
    pitch = elevation[peak] + math.radians(29.9)
    for aim, below in ((pitch, False), (math.radians(90.0), True)):
        ahead = math.cos(aim) * toward + math.sin(aim) * up
        camera = CameraState.look(state.position_m, ahead, toward if below else up, 60.0, 1.0)
        lowest = least_elevation_rad(camera, 0.01)
        assert Skyline().below(field, camera.position_m, radius, lowest) is below


def test_nothing_of_the_ground_runs_and_the_sky_is_the_same(monkeypatch: Any) -> None:
    scene = pf.load_scene("earth")
    scene.planet.add(pf.Clouds(coverage=0.6))
    cameras = {
        name: pf.Camera.at(45.0, 10.0, altitude, pitch_deg=pitch, above=above)
        for name, (altitude, above, pitch) in SKY.items()
    }

    def pictures() -> dict[str, tuple[Any, set[str], bool]]:
        found = {}
        with pf.Renderer(scene, SIZE, "low") as renderer:
            for name, camera in cameras.items():
                renderer.render(camera)
                picture = renderer.render(camera)  # what is made once has been made
                ran = {p.name for p in renderer.passes() if p.ran}
                seen = renderer.views[0].seen
                assert seen.planet(), "there is air in the picture"
                found[name] = np.array(picture["color"]), ran, seen.ground()
        return found

    ours = pictures()
    monkeypatch.setattr(ProxySystem, "ground_seen", lambda *_: True)
    always = pictures()
    for name in SKY:
        picture, ran, seen = ours[name]
        other, drew, _ = always[name]
        assert not seen, name
        assert not ran & set(GROUND), name
        assert {"terrain.gbuffer", "gbuffer.classify"} <= drew, name
        np.testing.assert_array_equal(picture, other, err_msg=name)


@pytest.mark.parametrize(("altitude_m", "step_m", "frames"), [(100.0, 6.0, 110), (2e4, 0.0, 12)])
def test_ground_that_comes_back_is_as_if_nobody_had_looked_away(
    monkeypatch: Any, altitude_m: float, step_m: float, frames: int
) -> None:
    """A flight over a coast that looks up, with snaps and fades before it stops, and down again."""
    returns(monkeypatch, GridBackend, {}, altitude_m, step_m, frames)


@pytest.mark.parametrize(
    ("kind", "asked", "altitude_m", "step_m"),
    [(PaperGridBackend, PRINTED, 2e4, 1200.0), (QuadtreeBackend, TILES, 100.0, 6.0)],
)
def test_other_grounds_come_back_so_too(
    monkeypatch: Any, kind: type[Backend], asked: Asked, altitude_m: float, step_m: float
) -> None:
    returns(monkeypatch, kind, asked, altitude_m, step_m, 60)


def returns(monkeypatch: Any, kind: type[Backend], asked: Asked, altitude_m: float, step_m: float, to: int) -> None:
    """A flight that looks up from frame 8 to `to`, with and without rest: the pictures in which ground is seen."""
    scene = pf.load_scene("earth")
    scene.planet.remove(pf.Cover)
    for component, values in asked.items():
        for name, value in values.items():
            setattr(scene.planet[component], name, value)
    start = pf.view("coast").resolve(scene)
    up, ahead = start.direction, np.cross(start.direction, (0.0, 0.0, 1.0))
    ahead /= np.linalg.norm(ahead)
    base = up * (scene.planet.radius_m + max(float(scene.planet.surface_height_m(up)[0]), 0.0) + altitude_m)
    scene.sun = pf.Sun(direction=tuple((up + 0.5 * ahead).tolist()))
    updates: list[int] = []
    update = kind.update
    monkeypatch.setattr(kind, "update", lambda *arguments: (updates.append(1), update(*arguments))[1])

    def flown() -> tuple[list[bytes], int, bool]:
        found, unseen = [], False
        # Time for all tiles that are wanted, whatever they take.
        with pf.Renderer(scene, SIZE, "low", {"terrain.budget_ms": 1000.0}) as renderer:
            target = renderer.ctx.simple_framebuffer(SIZE)
            renderer.settle(pf.Camera(base, 0.6 * ahead - up, ahead))  # with all of the air's tables
            updates.clear()
            for k in range(to + 20):
                place, away = base + min(k, 20) * step_m * ahead, 8 <= k < to
                camera = pf.Camera(place, up if away else 0.6 * ahead - up, ahead)
                renderer.render_to(target, camera, k / 60.0, dt_s=1.0 / 60.0)
                unseen |= not renderer.views[0].seen.ground()
                if not away:
                    found.append(target.read())
            renderer.gpu.leave(target)
            target.release()
        return found, len(updates), unseen

    ours, ran, unseen = flown()
    monkeypatch.setattr(ProxySystem, "ground_seen", lambda *_: True)
    always, ran_always, _ = flown()
    assert unseen and ran < ran_always == to + 20
    assert [k for k, (one, other) in enumerate(zip(ours, always, strict=True)) if one != other] == []
    assert len(set(ours)) > 10, "the waves move"


def test_objects_in_the_sky_are_drawn_and_others_cost_nothing(monkeypatch: Any) -> None:
    scene = pf.load_scene("earth")
    scene.planet.remove(pf.Cover)
    camera = pf.Camera.at(45.0, 10.0, 100.0, pitch_deg=90.0, above="ground")
    place = camera.resolve(scene).position_m
    up = place / np.linalg.norm(place)
    prop = scene.add(pf.Transform(tuple(place + 60.0 * up)), pf.Shape("box", (10.0, 10.0, 10.0)))

    def pictures() -> list[tuple[Any, set[str]]]:
        found = []
        with pf.Renderer(scene, SIZE, "low") as renderer:
            for above_m in (60.0, -60.0):
                prop[pf.Transform].position_m = tuple(place + above_m * up)
                renderer.render(camera)
                picture = np.array(renderer.render(camera)["color"])
                found.append(
                    (picture, {p.name for p in renderer.passes() if p.ran and p.system in ("props", "terrain")})
                )
        return found

    (above, drew), (below, rested) = pictures()
    monkeypatch.setattr(ProxySystem, "ground_seen", lambda *_: True)
    (above_too, _), (below_too, _) = pictures()
    assert (above != below).any() and "terrain.shade" not in drew
    assert drew - rested == {"props.shadow", "props.tiles", "props.shade"}
    np.testing.assert_array_equal(above, above_too)
    np.testing.assert_array_equal(below, below_too)
