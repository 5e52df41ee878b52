"""Spray of waterfalls: which falls have some, where it hangs, and that it is nothing elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from river_kit import walks

import planetfall as pf
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.rivers.bends import bend_amplitudes_m, bend_lattice
from planetfall.systems.terrain.rivers.fall_list import FallList, Falls
from planetfall.systems.terrain.rivers.falls import with_falls
from planetfall.systems.terrain.rivers.table import river_table
from planetfall.systems.terrain.spray import MOST, bow_angles, spray_rows

EARTH = TerrainParams(mountains=0.4)


def test_bow_is_where_rainbows_are() -> None:
    """Red at 42.4 degrees and violet at 40.6 (Lee and Fraser 2001, for 656 and 405 nm)."""
    red, green, violet = np.degrees(bow_angles((656.0, 550.0, 405.0)))
    assert red == pytest.approx(42.4, abs=0.15)
    assert violet == pytest.approx(40.6, abs=0.15)
    assert red > green > violet


def test_list_has_the_falls_that_nodes_got() -> None:
    plain = walks(EARTH, 60)
    nodes = with_falls(plain, EARTH.radius_m)
    count = (len(nodes) - len(plain)) // 2
    assert count > 0
    table = river_table(nodes, EARTH.radius_m, EARTH.seed)
    found = FallList(table)
    falls = found.around(np.zeros(3), 1e9, 1e-9)
    assert len(found) == len(falls) == count
    lip, foot = len(plain) + np.arange(count), len(plain) + count + np.arange(count)
    assert falls.height_m == pytest.approx(nodes.level_m[lip] - nodes.level_m[foot], abs=1e-3)
    up = falls.foot_m / np.linalg.norm(falls.foot_m, axis=1)[:, None]
    assert np.abs((falls.way * up).sum(axis=1)).max() < 1e-9
    assert np.linalg.norm(falls.foot_m, axis=1) == pytest.approx(
        EARTH.radius_m + nodes.level_m[foot].astype(float), abs=1e-2
    )
    # The warp moves feet to their nodes, but for what turns its part along the vertical, which is up to a kilometre.
    ground = (up * EARTH.radius_m).T
    moves = bend_amplitudes_m(table.cell_m)[:, None]
    moved = ground + (moves * bend_lattice(table.cell_m, table.seed).cells(ground).vector()).sum(axis=1)
    moved /= np.linalg.norm(moved, axis=0)
    apart_m = np.linalg.norm(moved.T - nodes.direction[foot], axis=1) * EARTH.radius_m
    assert apart_m.max() < 0.2
    # Who asks near one alone finds the same.
    alone = found.around(falls.foot_m[3], 100.0, 0.1)
    nearest = np.argmin(np.linalg.norm(alone.foot_m - falls.foot_m[3], axis=1))
    assert np.array_equal(alone.foot_m[nearest], falls.foot_m[3]) and len(alone) < count
    # Falls beyond the latitude of ice are frozen.
    sine = np.abs(up[:, 2])
    assert len(found.around(np.zeros(3), 1e9, 1e-9, float(np.median(sine)))) == np.count_nonzero(sine < np.median(sine))


def some_falls(distances_m: list[float], height_m: float = 40.0) -> Falls:
    """In a row to the north, each that far from (EARTH's radius, 0, 0)."""
    n = len(distances_m)
    foot = np.stack([np.full(n, EARTH.radius_m), np.zeros(n), np.array(distances_m)], axis=1)
    return Falls(foot, np.tile([0.0, 1.0, 0.0], (n, 1)), np.full(n, height_m), np.full(n, 10.0), np.arange(n))


def test_spray_is_of_falls_that_a_picture_shows() -> None:
    falls = some_falls([float(d) for d in range(100, 5100, 100)])
    camera_m, pixel_rad = np.array([EARTH.radius_m, 0.0, 0.0]), 2e-3
    rows = spray_rows(falls, camera_m, pixel_rad, 1.0)
    assert rows.shape == (MOST, 17)
    assert np.allclose(rows[:, 2], 100.0 * np.arange(MOST, 0, -1))  # the nearest, last
    assert len(spray_rows(falls, camera_m, pixel_rad, 0.0)) == 0
    assert spray_rows(falls, camera_m, pixel_rad, 2.0)[:, 3] == pytest.approx(2.0 * rows[:, 3])
    # Puffs rise at any time.
    for time_s in (0.0, 12.5, -3.0, 1e8, 1e9):
        one = spray_rows(falls, camera_m, pixel_rad, 1.0, time_s)[-1].astype(np.float64)
        later = spray_rows(falls, camera_m, pixel_rad, 1.0, time_s + 7.0)[-1].astype(np.float64)
        assert ((one[[14, 16]] >= 0.0) & (one[[14, 16]] < 1.0)).all()
        risen = (later[[13, 15]] - one[[13, 15]]) + (later[[14, 16]] - one[[14, 16]])
        assert np.mod(risen, 2.0**20) == pytest.approx([1.6 * 7.0 / 18.0, 3.1 * 1.6 * 7.0 / 18.0], abs=1e-3)
    # It comes by and by: no step where a fall begins to have some.
    far = [spray_rows(some_falls([d]), camera_m, pixel_rad, 1.0) for d in np.linspace(2000.0, 7000.0, 500)]
    depth = np.array([float(one[0, 3]) if len(one) else 0.0 for one in far])
    assert depth[0] > 0.0 and depth[-1] == 0.0
    assert np.abs(np.diff(depth)).max() < 0.02 * depth[0]
    # Nor where others take its place: nine falls side by side, of which the last becomes the highest.
    sums = []
    for share in np.linspace(0.0, 1.0, 400):
        heights_m = np.r_[np.full(MOST, 30.0) + np.arange(MOST), 20.0 + 30.0 * share]
        nine = replace(some_falls([500.0] * (MOST + 1)), height_m=heights_m)
        sums.append(np.sort(spray_rows(nine, camera_m, pixel_rad, 1.0)[:, 3]).sum())
    assert np.abs(np.diff(sums)).max() < 0.05 * np.max(sums)


@pytest.mark.gpu
def test_depth_along_rays_is_that_of_many_samples(run_compute) -> None:
    """The closed form against quadrature in float64, from inside the spray to 20 km away, up to any end."""
    half_m, density, n = 15.0, 0.05, 300  # of a fall 40 m high
    rng = np.random.default_rng(4)
    away_m = 10.0 ** rng.uniform(0.0, np.log10(2e4), n)
    going = rng.normal(size=(n, 3))
    going /= np.linalg.norm(going, axis=1)[:, None]
    # Past a place in the spray, of which each is so far away.
    eye = rng.normal(size=(n, 3)) * (20.0, 20.0, 15.0) + (10.0, 0.0, 10.0) - going * away_m[:, None]
    end = away_m + rng.uniform(-60.0, 200.0, n)
    end = np.maximum(end, 1.0)
    found = run_compute(
        "Spray s = Spray(vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), 40.0, 15.0, 0.05, 0.0); float mean;"
        " depth = spray_depth(s, eye, going, end, mean);",
        {"eye": eye.astype(np.float32), "going": going.astype(np.float32), "end": end.astype(np.float32)},
        {"depth": "float"},
        header='#include "terrain/spray.glsl"',
    )["depth"]
    # From where spray begins to the end, and 3 deviations around, beyond which nothing is counted.
    t = np.linspace(0.0, 1.0, 8001)[:, None]
    begin = np.maximum(away_m - 300.0, 0.0)
    last = np.clip(end, begin, away_m + 300.0)
    at = eye + (begin + t * (last - begin))[..., None] * going
    clouds = (
        ((16.0, 0.0, 4.8), (20.0, 0.6 * half_m + 10.0, 13.6), density),
        ((3.2, 0.0, 16.0), (8.0, 0.6 * half_m, 16.0), 0.22 * density),
    )
    true = np.zeros(n)
    for middle, deviation, most in clouds:
        x = (at - middle) / deviation
        along = going / deviation
        start = (eye - middle) / deviation
        beside = start - along * ((start * along).sum(axis=1) / (along * along).sum(axis=1))[:, None]
        nearest = np.exp(-0.5 * (beside * beside).sum(axis=1))
        seen = np.maximum(nearest - np.exp(-4.5), 0.0) / nearest  # fades out at 3 deviations
        true += seen * most * np.trapezoid(np.exp(-0.5 * (x * x).sum(axis=2)), t, axis=0) * (last - begin)
    assert true.max() > 1.5 and (true > 0.1).sum() > 100
    # erf to 5e-4 at either end, of at most 2.5 for each cloud; and float32 at 20 km.
    assert np.abs(found - true).max() < 5e-3


@pytest.mark.gpu
def test_spray_hangs_about_the_foot_and_nowhere_else() -> None:
    pictures, ran = {}, {}
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (320, 180), "medium") as renderer:
        for spray in (0.0, 1.0, 3.0):
            scene.planet[pf.Terrain].spray = spray
            renderer.settle(pf.view("waterfall", "earth"))
            pictures[spray] = renderer.render(pf.view("waterfall", "earth"), outputs=("radiance",))
            ran[spray] = {p.name for p in renderer.passes() if p.ran}
        renderer.render(pf.view("near", "earth"))
        ran["near"] = {p.name for p in renderer.passes() if p.ran}
    assert {name for name, found in ran.items() if "terrain.spray" in found} == {1.0, 3.0}
    changed = np.abs(pictures[1.0]["radiance"] / pictures[0.0]["radiance"] - 1.0).max(axis=2) > 0.02
    assert 0.05 < changed.mean() < 0.6
    # Nothing in the corners of the picture: neither in the sky nor on the water at one's feet.
    for corner in (changed[:20, :40], changed[:20, -40:], changed[-20:, :40], changed[-20:, -40:]):
        assert not corner.any()
    more = np.abs(pictures[3.0]["radiance"] - pictures[0.0]["radiance"]).mean()
    assert more > 1.2 * np.abs(pictures[1.0]["radiance"] - pictures[0.0]["radiance"]).mean()


@pytest.mark.gpu
def test_light_is_finite_inside_of_spray() -> None:
    """From the foot, from within the falling water, from above it and from below the pool's surface, every way."""
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
        there = renderer.camera_state(pf.view("waterfall", "earth"))
        up = there.position_m / np.linalg.norm(there.position_m)
        ran = 0
        for along_m, above_m in ((60.0, 20.0), (110.0, 20.0), (125.0, 20.0), (200.0, 20.0), (80.0, -6.0)):
            place = there.position_m + along_m * there.forward + above_m * up
            for forward in (there.forward, -there.forward, up + 0.01 * there.forward, 0.01 * there.forward - up):
                camera = pf.Camera(position_m=place, forward=forward, up=np.cross(there.right, forward))
                light = renderer.render(camera, outputs=("radiance",))["radiance"]
                ran += any(p.name == "terrain.spray" and p.ran for p in renderer.passes())
                assert np.isfinite(light).all() and (light >= 0.0).all()
        assert ran > 10
