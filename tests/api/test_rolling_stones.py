"""The game of rolling stones: they stay on the ground, borders of patches don't exist for them, it makes pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import planetfall as pf

rapier = pytest.importorskip("rapier3d")
pytest.importorskip("trimesh")

from planetfall.games.rolling_stones import main as game  # noqa: E402
from planetfall.games.rolling_stones import simulation  # noqa: E402
from planetfall.games.rolling_stones.frame import LocalFrame, inverse, product, quaternion_of  # noqa: E402
from planetfall.games.rolling_stones.stones import worn_ball  # noqa: E402

DEEPEST_M = 0.01


@pytest.fixture(scope="module")
def sampler():
    scene = pf.load_scene("earth")
    yield pf.TerrainSampler(scene)
    scene.release()


def on_slope(sampler, count):
    place = pf.direction(game.LATITUDE_DEG, game.LONGITUDE_DEG)
    return simulation.on_slope(sampler, place, count, game.PUSH_M_S)


def rolled(stones, seconds, every=8):
    """Steps `seconds` and gives: way of each stone, the deepest it was, changes of velocity in a step that crosses a
    border of patches, and in the others."""
    way, deepest = np.zeros(len(stones.radii_m)), np.full(len(stones.radii_m), -np.inf)
    place, speed, cells = stones.positions_m, stones.velocities_m_s, stones.patch_of(stones.positions_m)
    across, inside = [], []
    for step in range(round(seconds / simulation.STEP_S)):
        stones.step()
        before, place = place, stones.positions_m
        way += np.linalg.norm(place - before, axis=1)
        change, speed = np.linalg.norm(stones.velocities_m_s - speed, axis=1), stones.velocities_m_s
        here = stones.patch_of(place)
        crossed, cells = (here != cells).any(axis=1), here
        across.append(change[crossed])
        inside.append(change[~crossed])
        if step % every == 0:
            deepest = np.maximum(deepest, stones.depths_m)
    return way, deepest, np.concatenate(across), np.concatenate(inside)


def test_quaternions_of_frames():
    rng = np.random.default_rng(3)
    for _ in range(20):
        frame = LocalFrame.at(rng.normal(size=3) * 6e6)
        q = frame.quaternion
        v = rng.normal(size=3)
        turned = product(product(q, np.append(v, 0.0)), inverse(q))[:3]
        np.testing.assert_allclose(turned, v @ frame.axes, atol=1e-12)
        np.testing.assert_allclose(frame.to_local(frame.to_planet(v[None]))[0], v, atol=1e-8)
    half_turn = np.diag([1.0, -1.0, -1.0])
    np.testing.assert_allclose(np.abs(quaternion_of(half_turn)), [1.0, 0.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("kind", range(4))
def test_stones_lie_within_the_ball_that_rolls(kind):
    points, faces = worn_ball(kind)
    assert np.linalg.norm(points, axis=1).min() > 0.5 and np.linalg.norm(points, axis=1).max() <= 1.0
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all(), "closed"
    a, b, c = points[faces].swapaxes(0, 1)
    assert (a * np.cross(b, c)).sum() > 0.0, "outwards"


def test_stones_roll_on_the_ground(sampler):
    """A short run of the slow test below: on the ground, over borders, in a frame that moves with them."""
    stones = on_slope(sampler, 25)
    assert np.linalg.norm(stones.positions_m, axis=1).min() > 6e6
    way, deepest, across, inside = rolled(stones, 3.0)
    assert way.min() > 40.0 and deepest.max() < DEEPEST_M
    assert (deepest > -0.01).all(), "they touched it"
    assert across.size > 20
    assert np.quantile(across, 0.9) < 1.5 * np.quantile(inside, 0.9) + 0.01


def test_a_moved_frame_changes_nothing(sampler):
    stones = on_slope(sampler, 6)
    place, speed, turn = stones.positions_m, stones.velocities_m_s, stones.orientations
    stones.move_frame()
    # Single precision of a hundred metres, and of 20 m/s.
    np.testing.assert_allclose(stones.positions_m, place, atol=1e-5)
    np.testing.assert_allclose(stones.velocities_m_s, speed, atol=4e-6)
    same = np.abs((stones.orientations * turn).sum(axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-6)


def balls(collider_meshes, starts, speeds):
    """Velocities (steps, N, 3) of balls of 1 m over ground of these meshes."""
    world = rapier.PhysicsWorld(gravity=(0.0, 0.0, -9.81))
    world.integration_parameters.dt = simulation.STEP_S
    world.integration_parameters.static_contact_softness = rapier.SpringCoefficients(240.0, 10.0)
    for points, triangles in collider_meshes:
        shape = rapier.Collider.trimesh(points, triangles, rapier.TriMeshFlags.FIX_INTERNAL_EDGES)
        world.add_collider(shape.friction(0.9).restitution(0.0))
    states = []
    for k, (start, speed) in enumerate(zip(starts, speeds, strict=True)):
        ball = rapier.Collider.ball(1.0).density(2600.0).friction(0.9).restitution(0.0)
        ball = ball.collision_groups(rapier.InteractionGroups(rapier.Group(1 << (k + 1)), rapier.Group(1)))
        body = rapier.RigidBody.dynamic().translation(tuple(start)).linvel(tuple(speed)).can_sleep(False)
        states.append(world.rigid_bodies[world.add_body(body.soft_ccd_prediction(0.1), [ball])])
    found = []
    for _ in range(round(1.2 / simulation.STEP_S)):
        world.step()
        found.append([s.linvel.to_tuple() for s in states])
    return np.array(found)


def test_a_border_of_patches_does_not_exist_for_a_ball(sampler):
    """The same balls over four patches and over one that covers them all. Balls on one bumpy ground that start a tenth
    of a millimetre aside come apart as well: four patches may do no more than that, and open edges do."""
    size, spacing = simulation.PATCH_M, simulation.SPACING_M
    place = pf.direction(game.LATITUDE_DEG, game.LONGITUDE_DEG)
    whole = sampler.patch(place, 2.0 * size, spacing, aligned=True, border=simulation.BORDER)
    count = len(whole.x_m)
    quarters = [(j, i) for j in (count // 4, -count // 4) for i in (count // 4, -count // 4)]

    def mesh(patch):
        return patch.positions_m.reshape(-1, 3).astype(np.float32), patch.triangles().astype(np.uint32)

    def four(border):
        options = {"aligned": True, "border": border, "frame": whole, "normals": False}
        parts = [
            sampler.patch(whole.to_planet(whole.positions_m[q][None])[0], size, spacing, **options) for q in quarters
        ]
        assert len({part.cell for part in parts}) == 4
        return [mesh(part) for part in parts]

    center = whole.positions_m[count // 2, count // 2]
    starts, speeds = [], []
    for k in range(24):  # towards the common corner and past it, from all sides
        angle = 2.0 * np.pi * k / 24 + 0.1
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        zenith = whole.to_planet((center - way * (2.0 + 0.03 * k))[None])[0]
        ground = zenith / np.linalg.norm(zenith) * (sampler.radius_m + sampler.height(zenith[None])[0])
        starts.append(whole.to_frame(ground[None])[0] + [0.0, 0.0, 1.02])
        speeds.append(way * (3.0 + 0.08 * k))
    one = balls([mesh(whole)], starts, speeds)

    def apart(velocities):
        """How much velocities come apart, at most, once all lie on the ground: after 60 steps, before the corner."""
        difference = np.linalg.norm(velocities - one, axis=2)
        return float((difference[60:] - difference[60]).max())

    aside = [np.array(v) * 1e-4 for v in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))]
    by_chance = max(apart(balls([mesh(whole)], [s + a for s in starts], speeds)) for a in aside)
    overlapping, open_edges = (apart(balls(four(border), starts, speeds)) for border in (simulation.BORDER, 0))
    assert overlapping < 2.0 * by_chance
    assert open_edges > 1.5 * overlapping, "or the overlap is for nothing"


@pytest.mark.slow
@pytest.mark.timeout(2400)
def test_two_hundred_stones_for_a_minute(sampler):
    stones = on_slope(sampler, 200)
    way, deepest, across, inside = rolled(stones, 60.0)
    assert way.min() > 1000.0 and deepest.max() < DEEPEST_M
    assert stones.frames_used >= 2 and across.size > 5000
    for share in (0.5, 0.9, 0.99, 0.999):
        assert np.quantile(across, share) < 1.25 * np.quantile(inside, share) + 0.01


@pytest.mark.gpu
def test_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--frames", "2", "--count", "10", "--size", "96", "54", "--quality", "low", "-o", str(tmp_path)]
    assert game.main(arguments) == 0
    assert "10 stones" in capsys.readouterr().out
    a, b = (np.asarray(Image.open(tmp_path / f"stones_000{k}.png")).astype(int) for k in (0, 1))
    assert a.shape == (54, 96, 3) and a.std() > 20 and np.abs(a - b).max() > 20


@pytest.mark.parametrize("arguments", [["--count", "0"], ["--fps", "0"], ["--frames", "-1"]])
def test_bad_options(arguments, capsys):
    with pytest.raises(SystemExit):
        game.main(arguments)
    assert "--count from 1" in capsys.readouterr().err


def test_with_a_display_a_window_opens(monkeypatch, tmp_path):
    flown = {}
    monkeypatch.setattr(pf, "has_display", lambda: True)

    def fly(scene, camera, **options):
        before = scene.props[0][pf.Transform].position_m
        options["on_frame"](0.0, 1.0 / 60.0)
        flown.update(props=len(scene.props), moved=scene.props[0][pf.Transform].position_m != before)

    monkeypatch.setattr(pf, "fly", fly)
    assert game.main(["--count", "3", "-o", str(tmp_path)]) == 0
    assert flown == {"props": 3, "moved": True}
