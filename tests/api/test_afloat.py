"""The game with a boat and buoys: buoyancy against closed forms, and waterlines against the drawn sea."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall.games.afloat import main as game
from planetfall.games.afloat import shapes
from planetfall.games.afloat.floating import STEP_S, WATER_KG_M3, Body, Flotilla, Hull, boat_hull, disc_hull
from planetfall.games.afloat.turning import axes_of, turned, upright

G = 9.81
WATERLINE_M = 0.05


def calm_sea(**ocean):
    planet = {
        pf.Planet: pf.Planet(),
        pf.Ocean: pf.Ocean(wind_speed_m_s=0.0, swell_height_m=0.0) if not ocean else pf.Ocean(**ocean),
    }
    return pf.OceanSampler(SimpleNamespace(planet=planet))


def at_sea(hull, lift_m=0.0, heading_deg=30.0):
    place = pf.direction(12.0, 34.0)
    return Body(hull, place * (6.371e6 + lift_m), upright(place, heading_deg))


def height(body):
    return float(np.linalg.norm(body.position_m)) - 6.371e6


def run(body, seconds, sampler=None):
    sea = Flotilla(sampler or calm_sea(), [body], G)
    found = []
    for _ in range(round(seconds / STEP_S)):
        sea.step()
        found.append(
            (height(body), float(axes_of(body.quaternion)[:, 2] @ body.position_m) / np.linalg.norm(body.position_m))
        )
    return np.array(found), sea


def test_turning():
    rng = np.random.default_rng(1)
    for _ in range(50):
        place = rng.normal(size=3)
        q = upright(place, rng.uniform(0.0, 360.0))
        m = axes_of(q)
        np.testing.assert_allclose(m @ m.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(m[:, 2], place / np.linalg.norm(place), atol=1e-12)
    north, east = (axes_of(upright(pf.direction(40.0, 20.0), h))[:, 0] for h in (0.0, 90.0))
    assert north[2] > 0.7 and east @ [-math.sin(math.radians(20)), math.cos(math.radians(20)), 0] == pytest.approx(1.0)
    half = turned(turned(q, np.array([0.3, 0.0, 0.0])), np.array([-0.3, 0.0, 0.0]))
    np.testing.assert_allclose(half, q, atol=1e-12)
    np.testing.assert_allclose(axes_of(turned(q, np.array([0.0, 0.0, 0.5 * np.pi])))[:, 0], m[:, 1], atol=1e-12)


def test_hulls_displace_their_shapes():
    disc = disc_hull(1.8, 0.3, 0.45, rings=3)
    assert disc.mass_kg == pytest.approx(WATER_KG_M3 * math.pi * 0.9**2 * 0.3)
    np.testing.assert_allclose(disc.columns[:, :2].T @ disc.columns[:, 2], 0.0, atol=1e-12)
    # Second moment of the waterplane, which decides whether it stands upright: pi r^4 / 4.
    assert disc.columns[:, 0] ** 2 @ disc.columns[:, 2] == pytest.approx(math.pi * 0.9**4 / 4.0, rel=0.12)
    fine, coarse = (boat_hull(shapes.hull_sections(*n), shapes.DECK_M) for n in ((61, 41), (8, 7)))
    assert coarse.mass_kg == pytest.approx(fine.mass_kg, rel=0.1)
    points, faces = shapes.hull_mesh()
    a, b, c = points[faces].swapaxes(0, 1)
    # At the bow both sides meet in the same places.
    same = np.unique(points.round(6), axis=0, return_inverse=True)[1].reshape(-1)
    welded = same[faces]
    welded = welded[(welded != np.roll(welded, 1, axis=1)).all(axis=1)]
    edges = np.sort(np.concatenate([welded[:, [0, 1]], welded[:, [1, 2]], welded[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all(), "closed"
    assert (np.cross(a, b) * c).sum() / 6.0 > fine.mass_kg / WATER_KG_M3, "outwards, and more than what is under water"


def test_a_disc_bobs_with_its_period():
    """Free heave: 2 pi sqrt(draft / g), 1.0987 s for 0.3 m; the mass is that of the draft."""
    hull = Hull(disc_hull(1.8, 0.3, 0.45).columns, 0.45, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    heights, _ = run(at_sea(hull, 0.05), 11.5)
    z = heights[:, 0]
    rising = np.flatnonzero((z[:-1] < 0.0) & (z[1:] >= 0.0))
    times = rising + z[rising] / (z[rising] - z[rising + 1])
    # A symplectic step of h changes the period by (w h)^2 / 24: 0.04 %.
    assert np.diff(times).mean() * STEP_S == pytest.approx(2.0 * math.pi * math.sqrt(0.3 / G), rel=0.002)
    assert np.abs(z).max() == pytest.approx(0.05, rel=0.05), "no energy comes from nowhere"


@pytest.mark.parametrize("hull", [disc_hull(1.8, 0.3, 0.45), boat_hull(shapes.hull_sections(8, 7), shapes.DECK_M)])
def test_they_come_to_rest_upright_at_their_waterline(hull):
    body = at_sea(hull, 0.1)
    body.quaternion = turned(body.quaternion, np.array([0.3, 0.1, 0.0]))
    heights, sea = run(body, 20.0)
    assert abs(sea.waterline_m(body)) < 0.01 and abs(heights[-1, 0]) < 0.01
    assert heights[-1, 1] > math.cos(math.radians(1.0)) and heights[0, 1] < math.cos(math.radians(15.0))
    assert np.linalg.norm(body.velocity_m_s) < 0.005


def test_a_float_goes_round_with_the_swell():
    """In long deep waves a small float moves as the water does: in circles of the amplitude, once a period."""
    wave = pf.Wave(origin=(-60.0, 20.0), amplitude_m=0.8, wavelength_m=156.13, steepness=1.0)
    sampler = calm_sea(waves=[wave])
    body = at_sea(disc_hull(1.8, 0.3, 0.45))
    place = body.position_m / np.linalg.norm(body.position_m)
    moved = sampler.displacement(place[None], 0.0)[0]
    body.position_m = place * 6.371e6 + moved
    body.velocity_m_s = (sampler.displacement(place[None], 0.01)[0] - moved) / 0.01
    sea = Flotilla(sampler, [body], G)
    apart = []
    for _ in range(round(20.0 / STEP_S)):
        sea.step()
        apart.append(body.position_m - place * 6.371e6 - sampler.displacement(place[None], sea.time_s)[0])
        assert abs(sea.waterline_m(body)) < 0.02
    # Slow drift apart; an eighth of the circle's diameter after two rounds.
    assert np.linalg.norm(apart, axis=1).max() < 0.2


@pytest.fixture(scope="module")
def afloat(tmp_path_factory):
    made = game.Game(tmp_path_factory.mktemp("afloat"))
    yield made
    made.release()


def test_buoys_and_boat_keep_their_waterlines_and_places(afloat):
    for k in range(round(12.0 / STEP_S)):
        afloat.advance(STEP_S)
        if k > 2.0 / STEP_S and k % 6 == 0:
            assert max(abs(afloat.sea.waterline_m(b)) for b in afloat.sea.bodies) < WATERLINE_M
    for body in afloat.sea.bodies[:-1]:
        away = body.position_m - body.anchored_at * np.linalg.norm(body.position_m)
        assert np.linalg.norm(away) < 5.0
    boat = afloat.boat
    assert 2.0 < np.linalg.norm(boat.velocity_m_s) < 4.5
    prop = next(p for p in afloat.scene.props if p.name == "hull")
    np.testing.assert_allclose(prop[pf.Transform].position_m, boat.position_m)


def drawn_waterline(renderer, afloat, body):
    """How far the drawn sea is above a body's waterline: a plane through the sea's pixels around it, in `position`."""
    up = body.position_m / np.linalg.norm(body.position_m)
    east, north = game.east_north(up)
    eye = body.position_m + 9.0 * east - 5.0 * north + 2.5 * up
    camera = pf.Camera(
        position_m=game.triple(eye), forward=game.triple(body.position_m - eye), up=game.triple(up), fov_y_deg=30
    )
    out = renderer.render(camera, afloat.sea.time_s, afloat.sun, outputs=("position", "surface"))
    points = eye + out["position"][out["surface"] == 2].astype(np.float64)
    off = points - body.position_m
    level = off - np.outer(off @ up, up)
    reach = 2.0 if body is not afloat.boat else 7.0
    points, level = (a[np.linalg.norm(level, axis=1) < reach] for a in (points, level))
    assert len(points) > 300
    heights = np.linalg.norm(points, axis=1)
    plane = np.column_stack([level @ east, level @ north, np.ones(len(level))])
    sampler = afloat.sea.sampler
    truth = sampler.height(points, afloat.sea.time_s) + sampler.radius_m
    return np.linalg.lstsq(plane, heights, rcond=None)[0][2] - np.linalg.norm(body.position_m), heights - truth


def float_for(folder, seconds, every_s):
    """In swell alone: a hull averages over waves as short as itself, and drawing it hides half of the sea around it."""
    afloat = game.Game(folder, wind_speed_m_s=0.0)
    try:
        with pf.Renderer(afloat.scene, (160, 100), "medium") as renderer:
            for _ in range(round(seconds / every_s)):
                for _ in range(round(every_s / STEP_S)):
                    afloat.advance(STEP_S)
                for body in (*afloat.sea.bodies[:2], afloat.boat):
                    off, apart = drawn_waterline(renderer, afloat, body)
                    assert abs(off) < WATERLINE_M, f"{100 * off:.1f} cm at {afloat.sea.time_s:.1f} s"
                    assert np.abs(apart).max() < WATERLINE_M
    finally:
        afloat.release()


@pytest.mark.gpu
def test_the_drawn_sea_meets_the_waterlines(tmp_path):
    float_for(tmp_path, 6.0, 2.0)


@pytest.mark.gpu
@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_the_drawn_sea_meets_the_waterlines_for_a_minute(tmp_path):
    float_for(tmp_path, 60.0, 1.0)


@pytest.mark.gpu
def test_the_drawn_sea_is_the_sampled_one(afloat):
    """With wind as well: what is shorter than some of the sea's vertices is a ripple of its normals only."""
    with pf.Renderer(afloat.scene, (160, 100), "medium") as renderer:
        for body in afloat.sea.bodies[:3]:
            assert np.abs(drawn_waterline(renderer, afloat, body)[1]).max() < WATERLINE_M


@pytest.mark.gpu
def test_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--frames", "2", "--fps", "2", "--buoys", "2", "--size", "96", "54", "--quality", "low"]
    assert game.main([*arguments, "-o", str(tmp_path)]) == 0
    assert "2 buoys and a boat, 2.5 s: the sea was at most" in capsys.readouterr().out
    a, b = (np.asarray(Image.open(tmp_path / f"afloat_000{k}.png")).astype(int) for k in (0, 1))
    assert a.shape == (54, 96, 3) and a.std() > 20 and np.abs(a - b).max() > 20


@pytest.mark.parametrize("arguments", [["--buoys", "-1"], ["--fps", "0"], ["--frames", "-1"]])
def test_bad_options(arguments, capsys):
    with pytest.raises(SystemExit):
        game.main(arguments)
    assert "--fps above 0" in capsys.readouterr().err


def test_a_wind_that_cannot_be(tmp_path, capsys):
    assert game.main(["--wind", "-3", "-o", str(tmp_path)]) == 2
    assert "Ocean.wind_speed_m_s: expected a number from 0 to 60" in capsys.readouterr().err


def test_with_a_display_a_window_opens(monkeypatch, tmp_path):
    flown = {}
    monkeypatch.setattr(pf, "has_display", lambda: True)

    def fly(scene, camera, **options):
        before = scene.props[0][pf.Transform].position_m
        options["on_frame"](100.0, 1.0 / 60.0)
        flown.update(props=len(scene.props), moved=scene.props[0][pf.Transform].position_m != before)

    monkeypatch.setattr(pf, "fly", fly)
    assert game.main(["--buoys", "1", "-o", str(tmp_path)]) == 0
    assert flown == {"props": 8, "moved": True}
