"""What clouds take over from the frame before: no ghosts in fast flight, after a jump or a cut."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cloud_kit import cloudy, opacity, ran, renderer_of, texture
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.systems.clouds.ours import SkyRows
from planetfall.systems.clouds.shadow import ShadowMaps
from planetfall.systems.clouds.view_march import TILE

UP = pf.Sun(elevation_deg=60.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=10.0)
SIZE = (96, 54)


def at(metres: float, altitude_m: float = 800.0, heading_deg: float = 0.0) -> pf.Camera:
    return pf.Camera.at(20.0 + metres / 111e3, 10.0, altitude_m, heading_deg=heading_deg, pitch_deg=15.0)


def full(renderer: pf.Renderer) -> NDArray[np.float64]:
    """What the last frame's clouds take of each pixel."""
    return 1.0 - texture(renderer, "clouds.full")[..., 3]


def off(found: NDArray[np.float64], truth: NDArray[np.float64], elsewhere: NDArray[np.float64]) -> float:
    """Mean difference, as a share of that to a picture that has nothing to do with it."""
    return float(np.abs(found - truth).mean() / np.abs(elsewhere - truth).mean())


def test_no_trail_in_fast_flight() -> None:
    """25 and 250 m a frame, among clouds: pixels are hardly farther from those of a picture by itself than under a
    camera that stands, whose rays differ from it as well. A trail would add what is elsewhere, which is 1."""
    found = []
    with renderer_of(cloudy(coverage=0.7), SIZE, stride=2, fine_steps=96) as renderer:
        for speed_m_s in (0.0, 500.0, 5000.0):
            for k in range(12):
                renderer.render(at(0.05 * speed_m_s * k, 3000.0), sun=UP, dt_s=0.05)
            flown = full(renderer)
            here = 0.05 * speed_m_s * 11
            still = opacity(renderer, at(here, 3000.0), sun=UP)
            found.append(off(flown, still, opacity(renderer, at(here + 40e3, 3000.0), sun=UP)))
    rest, fast, fastest = found
    assert max(fast, fastest) < 1.5 * rest, found
    assert max(found) < 0.6, found


@pytest.mark.parametrize("camera", [at(60e3), at(0.0, heading_deg=150.0), at(0.0, 9000.0)], ids=["far", "round", "up"])
def test_nothing_is_taken_over_by_a_jump(camera: pf.Camera) -> None:
    """The first frame after it is that of a picture by itself, to the bit."""
    with renderer_of(cloudy(coverage=0.7), SIZE, stride=2) as renderer:
        alone = opacity(renderer, camera, sun=UP)
        for k in range(6):
            renderer.render(at(5.0 * k), sun=UP, dt_s=0.05)
        renderer.render(camera, sun=UP, dt_s=0.05)
        np.testing.assert_array_equal(full(renderer), alone)


def test_tiles_without_cloud_are_not_marched_and_classes_are_those_of_the_picture() -> None:
    """No tile that isn't listed shows any cloud, and from far away most of the picture is not listed."""
    camera = pf.Camera.at(20.0, 10.0, 3e7, pitch_deg=-90.0)
    with renderer_of(cloudy(), (128, 64)) as renderer:
        found = opacity(renderer, camera, sun=UP)
        assert "clouds.march" in ran(renderer)
        flags = renderer.graph.resource("clouds.tile_flags")
        tiles = renderer.graph.resource("clouds.tiles")
        with renderer.current():
            kinds = np.frombuffer(flags.read(), np.uint32).reshape(64 // TILE[1], 128 // TILE[0])
            listed = int(np.frombuffer(tiles.read(), np.uint32)[0])
    most = found.reshape(64 // TILE[1], TILE[1], 128 // TILE[0], TILE[0]).max(axis=(1, 3))
    assert listed == int((kinds == 2).sum())
    assert most[kinds == 2].max() > 0.5
    assert most[kinds != 2].max(initial=0.0) == 0.0
    assert 0 < listed < 0.5 * kinds.size


# -- what was hidden --------------------------------------------------------------------------------------------------


def wall_scene() -> tuple[pf.Scene, object, NDArray[np.float64]]:
    """Overcast, and a box of a mountain's size in front of the camera `at(0)`; the box, and the way to its right."""
    scene = cloudy(coverage=0.9)
    camera = at(0.0).resolve(scene, SIZE[0] / SIZE[1])
    place = camera.position_m + 2500.0 * camera.forward
    wall = scene.add(pf.Transform(tuple(place)), pf.Shape("box", (900.0, 900.0, 900.0)))
    return scene, wall, camera.right


@pytest.mark.parametrize("frames", [1, 6], ids=["at once", "six frames"])
@pytest.mark.parametrize("turned", [False, True], ids=["still", "turning"])
def test_no_ghost_where_a_mountain_was(frames: int, turned: bool) -> None:
    """It moves away, and what it hid is as overcast as the sky beside it, from the first frame on: the mean there is
    off by less than a tenth of what the mountain's ghost would be, with a camera at rest and with one that turns."""
    scene, wall, right = wall_scene()
    with renderer_of(scene, SIZE, stride=2) as renderer:

        def heading(k: int) -> pf.Camera:
            return at(0.0, heading_deg=0.05 * k if turned else 0.0)

        for k in range(12):
            renderer.render(heading(k), sun=UP, dt_s=0.05)
        before = full(renderer)
        wall[pf.Transform].position_m = tuple(np.asarray(wall[pf.Transform].position_m) + 2e4 * right)
        for k in range(12, 12 + frames):
            renderer.render(heading(k), sun=UP, dt_s=0.05)
        after = full(renderer)
        truth = opacity(renderer, heading(11 + frames), sun=UP)
    hidden = (before < 0.05) & (truth > 0.5)
    assert hidden.sum() > 0.05 * hidden.size
    assert abs(after[hidden].mean() - truth[hidden].mean()) < 0.1 * (truth - before)[hidden].mean()


@pytest.mark.parametrize("frames", [1, 6], ids=["at once", "six frames"])
def test_clouds_behind_a_mountain_that_comes_are_gone(frames: int) -> None:
    scene, wall, right = wall_scene()
    here = np.asarray(wall[pf.Transform].position_m)
    wall[pf.Transform].position_m = tuple(here + 2e4 * right)
    with renderer_of(scene, SIZE, stride=2) as renderer:
        for _ in range(12):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
        before = full(renderer)
        wall[pf.Transform].position_m = tuple(here)
        for _ in range(frames):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
        after = full(renderer)
        truth = opacity(renderer, at(0.0), sun=UP)
    covered = (before > 0.5) & (truth < 0.05)
    assert covered.sum() > 0.05 * covered.size
    assert after[covered].mean() < 0.1 * before[covered].mean()


def test_a_sun_that_jumps_leaves_no_light_behind() -> None:
    """From high to low: the first frame has the low sun's light, to the noise of single rays; not what was."""
    low = pf.Sun(elevation_deg=8.0, azimuth_deg=20.0, latitude_deg=20.0, longitude_deg=10.0)

    def light(renderer: pf.Renderer) -> float:
        return float(texture(renderer, "clouds.full")[..., 1].mean())

    with renderer_of(cloudy(coverage=0.8), SIZE, stride=2) as renderer:
        renderer.render(at(0.0), sun=low)
        truth = light(renderer)
        for _ in range(6):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
        before = light(renderer)
        renderer.render(at(0.0), sun=low, dt_s=0.05)
        after = light(renderer)
    assert abs(after - truth) < 0.1 * abs(before - truth)


def test_maps_of_the_shadow_come_one_a_frame() -> None:
    """The widest first, which stands for the others; in the end the light is that of as many frames with all maps."""
    with renderer_of(cloudy(coverage=0.8), SIZE, stride=2, shadow_frames=1) as renderer:
        renderer.render(at(0.0), sun=UP)
        for _ in range(40):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
        truth = float(texture(renderer, "clouds.full")[..., 1].mean())
        renderer.render(at(0.0), sun=UP)
        system: Any = renderer.system("clouds").method
        shadow = system.shadow.of(renderer.views[0])
        shadow.maps.forget()
        drawn = []
        for _ in range(40):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
            drawn.append(tuple(shadow.due))
            if len(drawn) == 1:
                assert "cloud shadows" in renderer.refining
        maps = len(shadow.maps.maps)
        assert drawn[:maps] == [(maps - 1,), *((number,) for number in range(maps - 1))]
        assert not any(drawn[maps:]) and "cloud shadows" not in renderer.refining
        assert float(texture(renderer, "clouds.full")[..., 1].mean()) == pytest.approx(truth, rel=0.01)


def test_a_map_of_the_shadow_is_drawn_in_strips_while_the_last_one_is_shown() -> None:
    """The widest at once, the others in strips, one a frame; in the end they have the texels of maps drawn at once."""
    names = ("clouds.shadow", "clouds.sun")
    scene, first, then = cloudy(coverage=0.8), at(0.0), at(3000.0)
    with renderer_of(scene, SIZE, stride=2, shadow_frames=1) as renderer:
        renderer.render(at(-9000.0), sun=UP)  # the weather is whole, and all maps are of another place
        for camera in (first, then):
            for _ in range(20):
                renderer.render(camera, sun=UP, dt_s=0.05)
        truth = [texture(renderer, name) for name in names]
        lit = float(texture(renderer, "clouds.full")[..., 1].mean())
    with renderer_of(scene, SIZE, stride=2, shadow_frames=4) as renderer:
        renderer.render(at(-9000.0), sun=UP)
        strips = 0
        for camera in (first, then):
            for number in range(40):
                before = None if number == 0 else texture(renderer, "clouds.shadow")
                renderer.render(camera, sun=UP, dt_s=0.05)
                system: Any = renderer.system("clouds").method
                shadow = system.shadow.of(renderer.views[0])
                # While the weather is coarse the widest, and where the camera leaps, one.
                assert len(shadow.due) <= (number < 5)
                if (
                    before is not None and not shadow.due and shadow.finished is None
                ):  # what is shown does not change in between
                    np.testing.assert_array_equal(texture(renderer, "clouds.shadow")[:6], before[:6])
                strips += shadow.maps.making is not None
                assert renderer.ctx.error == "GL_NO_ERROR"
                assert not (shadow.busy and system.settled(renderer.views[0]))
            assert not shadow.busy and all(shadow.drawn)
        assert strips >= 16
        maps = len(shadow.maps.maps)
        for name, expected in zip(names, truth, strict=True):
            shown = maps * len(expected) // (7 if name == "clouds.shadow" else 6)  # the last one was being made
            np.testing.assert_array_equal(texture(renderer, name)[:shown], expected[:shown])
        flags = np.frombuffer(renderer.graph.resource("clouds.shaded").read(), np.uint32)
        assert flags[:maps].all()
        assert float(texture(renderer, "clouds.full")[..., 1].mean()) == pytest.approx(lit, rel=0.02)


def test_maps_that_would_be_out_of_date_are_drawn_at_once() -> None:
    """A camera, a sun or a wind that are too fast for strips; another light, of all maps together."""
    radius, foot, sun = 6.36e6, np.array([1.0, 0.0, 0.0]), np.array([0.6, 0.8, 0.0])
    maps = ShadowMaps(128)
    maps.place(radius, 2000.0)

    def frames(way_m: float = 0.0, turn_rad: float = 0.0, passed_s: float = 0.0) -> int:
        maps.follow(foot, sun, 0.0)
        maps.follow(foot + np.array([0.0, way_m / radius, 0.0]), sun + np.array([turn_rad, 0.0, 0.0]), passed_s)
        return maps.frames_for(0, 8, 10.0, radius)

    assert frames() == frames(way_m=5.0) == frames(turn_rad=1e-6) == frames(passed_s=0.05) == 8
    assert 1 < frames(way_m=1500.0) < 8
    assert frames(way_m=5000.0) == frames(turn_rad=1e-3) == frames(passed_s=60.0) == 1
    with renderer_of(cloudy(coverage=0.8), SIZE, stride=2) as renderer:
        low = pf.Sun(elevation_deg=8.0, azimuth_deg=20.0, latitude_deg=20.0, longitude_deg=10.0)
        for _ in range(4):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
        system: Any = renderer.system("clouds").method
        shadow = system.shadow.of(renderer.views[0])
        assert shadow.maps.making is not None
        renderer.render(at(0.0), sun=low, dt_s=0.05)
        assert len(shadow.due) == len(shadow.maps.maps) and shadow.maps.making is None


def test_maps_that_the_camera_outruns_are_let_go_of() -> None:
    """Those that it leaves sooner than they are drawn, but never the widest, and not for one leap."""
    radius, sun = 6.36e6, np.array([0.0, 0.0, 1.0])
    frames = [20, 5, 4, 4, 4]

    def finest(steps_m: list[float]) -> int:
        maps = ShadowMaps(128)
        maps.place(radius, 2000.0)
        at_m = 0.0
        maps.follow(np.array([1.0, 0.0, 0.0]), sun, 0.0)
        for step_m in steps_m:
            at_m += step_m
            maps.follow(np.array([1.0, at_m / radius, 0.0]), sun, 0.0)
        for held in maps.maps:
            held.stamp = "weather"
        maps.need(0.0)
        maps.outrun(frames[: len(maps.maps)] + [4] * (len(maps.maps) - len(frames)), radius)
        assert [held.stamp for held in maps.maps].count(None) == maps.finest < len(maps.maps)
        return maps.finest

    half_m = 8000.0
    assert finest([0.04 * half_m] * 8) == 0 and finest([0.06 * half_m] * 8) == 1
    assert finest([1.2 * half_m] * 8) == 2
    assert finest([40.0 * half_m]) == finest([*[0.0] * 7, 40.0 * half_m]) == 0
    assert finest([1e8] * 8) >= 3


def test_maps_of_a_stand_in_are_due_and_stay() -> None:
    """Weather that is not what the time asks for makes no map due; when it is, those that were drawn meanwhile are."""
    radius, sun, foot = 6.36e6, np.array([0.6, 0.8, 0.0]), np.array([1.0, 0.0, 0.0])
    maps = ShadowMaps(128)
    maps.place(radius, 2000.0)
    here = (foot, sun, 0.0, 10.0, "weather", radius)
    maps.follow(foot, sun, 0.0, steady=True)
    for number in range(len(maps.maps)):
        maps.move(number, foot, sun, 0.0, "weather", radius)
    assert maps.due(*here) == []
    maps.follow(foot, sun, 0.0, steady=False)
    assert maps.due(*here) == []
    maps.move(0, foot, sun, 0.0, "weather", radius, alone=True)
    maps.begin(1, 4, foot, sun, 0.0, "weather", radius)
    maps.follow(foot, sun, 0.0, steady=True)
    assert maps.finish() == 1 and maps.due(*here) == [0, 1]
    assert all(held.stamp == "weather" for held in maps.maps)


def test_strips_cost_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fine map, with several times the steps of the others, has as many more of the frames. Their sum stays under a
    high sun; a low one, whose rays take up to eight times the steps, has up to the root of that as many."""
    with renderer_of(cloudy(coverage=0.8), SIZE, stride=2, shadow_frames=8) as renderer:
        strips: dict[int, list[int]] = {}
        for _ in range(60):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
            system: Any = renderer.system("clouds").method
            own = system.shadow.of(renderer.views[0])
            making, rows = own.maps.making, own.rows
            if making is not None and rows[1] > rows[0]:
                strips.setdefault(making.number, []).append(rows[1] - rows[0])
        shadow = renderer.system("clouds").method.shadow
        maps = own.maps
        assert len(strips) > 2 and all(max(rows) - min(rows) <= 8 for rows in strips.values())
        assert max(shadow.frames_of_maps(maps, 0.05)) == shadow.texels // 8, "no strip is narrower than a work group"
        monkeypatch.setattr("planetfall.systems.clouds.shadow_pass.GROUP", 1)
        sums = []
        for rise in (1.0, 0.5, 0.05):
            shares = shadow.frames_of_maps(maps, rise)
            assert shares == sorted(shares, reverse=True) and min(shares) >= 1
            sums.append(sum(shares))
        assert sums[0] == pytest.approx(8 * len(maps.maps), abs=len(maps.maps))
        assert sums == sorted(sums) and 1.2 * sums[0] < sums[2] <= 8.0**0.5 * sums[0] + len(maps.maps)
        assert shadow.frames_of_maps(maps, 0.5)[0] >= 2 * shadow.frames_of_maps(maps, 0.5)[-1]
        maps.finest = len(maps.maps) - 2
        assert shadow.frames_of_maps(maps, 1.0)[-2:] == [8, 8]


def test_a_map_that_follows_the_camera_keeps_its_texels() -> None:
    """A new map's texels lie on those of the old one, so that shadows are sampled where they were."""
    radius, sun, stamp = 6.36e6, np.array([0.6, 0.8, 0.0]), "weather"
    maps = ShadowMaps(128)
    maps.place(radius, 2000.0)
    foot = np.array([0.96, 0.28, 0.0])
    before = maps.move(0, foot, sun, 0.0, stamp, radius)
    assert (before.middle == foot * radius).all()
    texel_m = 2.0 * before.half_m / 128
    foot = foot + np.array([0.0, 0.0, 777.7 / radius]) + 333.3 / radius * before.u
    foot /= np.linalg.norm(foot)
    after = maps.move(0, foot, sun, 0.0, stamp, radius)
    away = after.middle - before.middle
    for axis, wide_m in ((before.u, texel_m * before.longer), (before.v, texel_m)):
        texels = float(away @ axis) / wide_m
        assert abs(texels) > 1.0 and texels == pytest.approx(round(texels), abs=2e-3)
    assert np.linalg.norm(after.middle - foot * radius) < texel_m * before.longer
    for leap in (np.array([0.8, 0.0, 0.6]), -foot):
        assert (maps.move(0, leap, sun, 0.0, stamp, radius).middle == leap * radius).all(), "a leap has nothing to keep"
    alone = maps.move(0, foot, sun, 0.0, stamp, radius, alone=True)
    assert (alone.middle == foot * radius).all(), "a picture by itself hangs on none before it"


def test_a_frame_graph_that_is_compiled_anew_keeps_the_maps_of_the_shadow() -> None:
    """Other outputs are another graph. Without its maps a frame shows the widest one's coarse shadow."""
    with renderer_of(cloudy(coverage=0.8), SIZE, stride=2) as renderer:
        for _ in range(60):
            renderer.render(at(0.0), sun=UP, dt_s=0.05)
        system: Any = renderer.system("clouds").method
        shadow, before = system.shadow.of(renderer.views[0]), texture(renderer, "clouds.shadow")
        assert all(shadow.drawn) and not shadow.busy
        renderer.render(at(0.0), sun=UP, dt_s=0.05, outputs=("color", "distance"))
        assert all(shadow.drawn) and not shadow.busy
        np.testing.assert_array_equal(texture(renderer, "clouds.shadow")[:6], before[:6])
        renderer.resize((SIZE[0] + 2, SIZE[1]))
        renderer.render(at(0.0), sun=UP, dt_s=0.05)
        assert all(shadow.drawn)


def test_the_map_of_the_sky_is_drawn_in_rows() -> None:
    """Each row once in eight frames after a change, all of it at once in a picture by itself, none at rest."""
    sky = SkyRows()
    sky.begin(("here",), True)
    assert sky.rows == (0, 1)
    sky.begin(("here",), True)
    assert sky.rows == (0, 0)
    found = []
    for frame in range(12):
        sky.begin(("there",) if frame < 3 else ("elsewhere",), False)
        found.append(sky.rows)
    assert found[:3] == [(0, 8), (1, 8), (2, 8)]
    assert found[3:11] == [(row % 8, 8) for row in range(3, 11)] and found[11] == (0, 0)


def test_a_first_start_shows_the_same_as_a_second(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without anything on disk the air's first tables are small ones; a settled picture has no trace of them."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))
    scene = preset_scene("earth", True)
    pictures = []
    for _ in range(2):
        with pf.Renderer(scene, (160, 90), "low") as renderer:
            view = pf.view("fair", scene.planet)
            renderer.settle(view)
            pictures.append(renderer.render(view)["color"])
    assert len(list(tmp_path.rglob("*.npz"))) >= 2
    np.testing.assert_array_equal(*pictures)


def test_flying_up_to_clouds_shows_neither_blocks_nor_dots() -> None:
    """7 % nearer with every frame, one ray for sixteen pixels: what is shown is no farther from the smoothed
    picture of a camera that stands (what such rays can tell) than at 1 %. Pixels held at what older, coarser frames
    showed, beside those that have just had their ray, are (1.2 times as far, and at 1 % as well)."""
    found = {}
    with renderer_of(cloudy(coverage=0.6), (128, 72), stride=4, fine_steps=24) as renderer:
        for rate in (0.01, 0.07):
            apart = []
            for altitude_m in (6e3, 15e3, 60e3):
                for k in reversed(range(24)):
                    camera = pf.Camera.at(21.0, 12.5, altitude_m * (1.0 + rate) ** k, pitch_deg=-35.0)
                    renderer.render(camera, sun=UP, dt_s=0.05)
                flown = full(renderer)
                renderer.settle(camera, sun=UP)
                apart.append(float(np.abs(flown - uniform_filter(full(renderer), 4)).mean()))
            found[rate] = float(np.mean(apart))
    assert found[0.07] < found[0.01], found


def test_maps_finer_than_pixels_are_let_go_of() -> None:
    """From space no map is drawn that the next one is fine enough for; near the clouds all are."""
    maps = ShadowMaps(256)
    maps.place(6.36e6, 3000.0)
    for held in maps.maps:
        held.stamp = "here"
    finest = []
    for height_m in (0.0, 1e3, 1e5, 1e6, 3.6e7):
        pixel_m = 3e-3 * height_m
        maps.need(pixel_m)
        finest.append(maps.finest)
        kept = maps.maps[maps.finest]
        # The next would be too coarse, and the one before is fine enough without those that were left out.
        assert maps.finest == 0 or 2.0 * kept.half_m / 256 <= 0.5 * pixel_m
        if maps.finest + 1 < len(maps.maps):
            assert 2.0 * maps.maps[maps.finest + 1].half_m / 256 > 0.5 * pixel_m
        assert all(held.stamp is None for held in maps.maps[: maps.finest])
        due = maps.due(np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 10.0, "other", 6.36e6)
        assert due == list(range(maps.finest, len(maps.maps)))
    assert finest == sorted(finest) and finest[0] == 0 and finest[-1] >= 3


def test_a_map_at_a_pace_is_still_drawn_in_parts() -> None:
    """As long as the camera stays well within it until it is whole; a whole map in one frame is a hitch."""
    maps = ShadowMaps(256)
    maps.place(6.36e6, 3000.0)
    half_m, foot, sun = maps.maps[0].half_m, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    for step, least, most in ((0.01, 8, 8), (0.1, 4, 5), (0.2, 2, 3), (0.6, 1, 1)):
        maps.follow(foot, sun, 0.0)
        maps.follow(foot + np.array([step * half_m / 6.36e6, 0.0, 0.0]), sun, 0.0)
        frames = maps.frames_for(0, 8, 10.0, 6.36e6)
        assert least <= frames <= most and (frames == 1 or frames * step <= 0.51)
