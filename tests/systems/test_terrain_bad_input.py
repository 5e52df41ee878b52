"""Grounds that can't be, and questions without an answer: what, where, expected, found, before any GPU work."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf

BAD_SCENES = {
    "no layers": ("[terrain]\nlayers = 0", ("terrain.layers", "from 1 to 16", "found 0", "nearest allowed value is 1")),
    "40 layers": ("[terrain]\nlayers = 40", ("terrain.layers", "found 40", "nearest allowed value is 16")),
    "a planet of 1 m": ("[planet]\nradius_m = 1.0", ("planet.radius_m", "found 1.0", "nearest allowed value is 500")),
    "relief of a radius": (
        "[planet]\nradius_m = 1000.0\n[terrain]\nhighest_m = 1000.0\nlowest_m = -100.0",
        ("Terrain.highest_m (1000)", "quarter of Planet.radius_m (1000)", "at most 250"),
    ),
    "upside down": (
        "[terrain]\nhighest_m = -100.0\nlowest_m = 100.0",
        ("Terrain.lowest_m (100)", "below highest_m (-100)"),
    ),
    "craters of 2": ("[terrain]\ncraters = 2.0", ("terrain.craters", "from 0 to 1", "found 2.0")),
    "half a range": (
        "[terrain]\nheight_map_range_m = [1.0]",
        ("terrain.height_map_range_m", "2 numbers", "such as [0.0, 1.0]"),
    ),
    "a number for a path": ("[terrain]\nheight_map = 3", ("terrain.height_map", "a text", "found 3")),
}


@pytest.mark.parametrize("name", BAD_SCENES)
def test_scenes_that_cannot_be(tmp_path, name):
    text, expected = BAD_SCENES[name]
    file = tmp_path / "world.toml"
    file.write_text(text if "[planet]" in text else f"[planet]\n{text}")
    with pytest.raises(pf.SettingError) as caught:
        pf.load_scene(file)
    for words in ("world.toml", *expected):
        assert words in str(caught.value), str(caught.value)


def test_assignment_refuses_what_files_may_not_have():
    terrain = pf.Terrain()
    for field, value in (("layers", 0), ("layers", 40), ("craters", float("nan")), ("height_map_range_m", (0.0,))):
        before = getattr(terrain, field)
        with pytest.raises(pf.SettingError, match=rf"Terrain\.{field}"):
            setattr(terrain, field, value)
        assert getattr(terrain, field) == before


@pytest.fixture(scope="module")
def moon():
    """Noise, map and craters together."""
    with pf.load_scene("moon") as scene:
        yield pf.TerrainSampler(scene)


@pytest.mark.parametrize("bad", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (np.inf, 0.0, 1.0)])
def test_questions_without_an_answer(moon, bad):
    directions = np.array([(0.0, 0.0, 1.0), bad])
    where = r"directions\[1\]: expected"
    for ask in (moon.height, moon.normal, lambda d: moon.raycast(np.full((2, 3), 2e6), d)):
        with pytest.raises(ValueError, match=where):
            ask(directions)
    with pytest.raises(ValueError, match="direction"):
        moon.patch(bad, 100.0, 10.0)
    if not np.isfinite(bad).all():
        with pytest.raises(ValueError, match=r"centers_m\[1\]: expected finite numbers"):
            moon.sphere_contact(directions, 1.0)


def test_rays_meet_craters_and_map(moon):
    """Against a march of 20 cm on the same ground, solved by halving: distances within a centimetre."""
    rng = np.random.default_rng(3)
    up = rng.normal(size=(12, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    side = np.cross(up, [0.3, 0.5, 0.81])
    side /= np.linalg.norm(side, axis=1)[:, None]
    origins = up * (moon.radius_m + moon.height(up) + 400.0)[:, None]
    rays = side - 0.35 * up
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    hit, distance = moon.raycast(origins, rays, 3000.0)
    for o, r, found, d in zip(origins, rays, hit, distance, strict=True):

        def clearance(t, o=o, r=r):
            p = o + np.atleast_1d(t)[:, None] * r
            far = np.linalg.norm(p, axis=1)
            return far - moon.radius_m - moon.height(p / far[:, None])

        steps = np.arange(0.0, 3000.0, 0.2)
        below = np.flatnonzero(clearance(steps) <= 0.0)
        assert found == bool(below.size)
        if below.size:
            low, high = steps[below[0]] - 0.2, steps[below[0]]
            for _ in range(20):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if clearance(middle)[0] > 0.0 else (low, middle)
            assert d == pytest.approx(high, abs=0.01)
