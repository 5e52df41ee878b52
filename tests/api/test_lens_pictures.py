"""Pictures, arrays, pick and project obey the intrinsics; a lens that bends nothing shows what a pinhole does."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall.capture.captures import save_capture
from planetfall.capture.photos import PhotoPlan, photo_tiles
from planetfall.capture.shot import load_shot, shot_settings
from planetfall.cli.main import main
from planetfall.engine.hosts.headless import create_headless
from planetfall.render.lens_faces import faces_of
from planetfall.systems.composite.finish import finished, press, unpress
from planetfall.systems.composite.photometry import expose

SIZE = (160, 90)
CAMERA = pf.Camera.at(10.0, 10.0, 30.0, heading_deg=40.0, pitch_deg=-15.0, above="ground")
FAR = {"width": 160, "height": 90, "fx": 100.0, "fy": 104.0, "cx": 80.3, "cy": 43.9}
LENSES = {
    "pinhole": pf.Intrinsics(**FAR),
    "brown": pf.Intrinsics(**FAR, distortion=(-0.25, 0.06, 1e-3, -2e-3), model="brown"),
    "pincushion": pf.Intrinsics(**FAR, distortion=(0.25, 0.06, 1e-3, -2e-3, 0.0), model="brown"),
    "rational": pf.Intrinsics(**FAR, distortion=(1.2, 0.3, 1e-3, -5e-4, 0.02, 1.4, 0.6, 0.1), model="rational"),
    "fisheye": pf.Intrinsics(96, 96, 28.0, 28.0, 47.5, 47.5, (0.02, -0.01, 0.003, -0.001), "fisheye"),
    "panorama": pf.Intrinsics.panorama(160),
}
OUTPUTS = ("color", "radiance", "distance", "position", "normal", "surface")


@pytest.fixture(scope="module")
def renderer():
    with pf.Renderer(pf.load_scene("moon"), SIZE, quality="low") as made:
        yield made


@pytest.mark.parametrize("name", LENSES)
def test_arrays_and_pick_lie_on_the_pixels_own_rays(renderer, name):
    lens = LENSES[name]
    camera = CAMERA.with_intrinsics(lens)
    out = renderer.render(camera, outputs=OUTPUTS)
    shape = lens.height, lens.width
    assert {n: (a.shape, a.dtype) for n, a in out.items()} == {
        "color": ((*shape, 3), np.uint8), "radiance": ((*shape, 3), np.float32), "distance": (shape, np.float32),
        "position": ((*shape, 3), np.float32), "normal": ((*shape, 3), np.float32), "surface": (shape, np.uint8),
    }  # fmt: skip
    assert renderer.size == SIZE, "cameras without intrinsics go on with the renderer's size"
    hit, there = out["surface"] > 0, np.isfinite(lens.rays()[..., 0])
    assert hit.any() and not hit.all() and there[hit].all()
    assert np.array_equal(np.isnan(out["distance"]), ~there) and np.isinf(out["distance"][there & ~hit]).all()
    assert not out["color"][~there].any() and not out["radiance"][~there].any()
    assert np.isfinite(out["position"][hit]).all() and np.isnan(out["position"][~hit]).all()
    assert np.allclose(np.linalg.norm(out["position"][hit], axis=1), out["distance"][hit], rtol=1e-5)
    rows, columns = np.nonzero(hit)
    state = renderer.camera_state(camera)
    pixels, seen = renderer.project(camera, state.position_m + out["position"][hit].astype(float))
    assert seen.all()
    assert np.abs(pixels - np.stack([columns + 0.5, rows + 0.5], axis=1)).max() < 1e-2  # the promise is 0.1
    if not there.all():
        bare_row, bare_column = np.argwhere(~there)[0]
        assert renderer.pick(camera, bare_column, bare_row) is None, "no ray"
    middle = len(rows) // 2
    found, what = renderer.pick(camera, columns[middle] + 0.5, rows[middle] + 0.5)
    assert what == "terrain" and renderer.planet_at(camera, columns[middle], rows[middle]) == "moon"
    np.testing.assert_allclose(found, state.position_m + out["position"][rows[middle], columns[middle]], atol=1e-3)


@pytest.mark.parametrize("name", LENSES)
def test_things_are_seen_where_the_lens_says(name):
    """Balls around the camera: their middles are at their pixels."""
    lens, scene = LENSES[name], pf.load_scene("moon")
    camera = pf.Camera.at(10.0, 10.0, 1000.0, pitch_deg=60.0, above="ground", planet=scene.planet)
    camera = camera.with_intrinsics(lens)
    wanted = np.array([(0.15, 0.2), (0.5, 0.5), (0.8, 0.3), (0.7, 0.8)]) * lens.size
    axes = camera.resolve(scene).axes
    rays = lens.rays(wanted) * (1.0, -1.0, 1.0) @ axes
    size_m = 8.0 / lens.fx * 50.0  # some 8 pixels
    for ray in rays:
        scene.add(pf.Transform(tuple(camera.position_m + 50.0 * ray)), pf.Shape("sphere", (size_m,) * 3))
    with pf.Renderer(scene, SIZE, quality="low") as renderer:
        shown = renderer.render(camera, outputs=("surface", "distance"))
    ball = shown["surface"] == 3
    assert np.abs(shown["distance"][ball] - 50.0).max() < size_m
    rows, columns = np.nonzero(ball)
    for x, y in wanted:
        near = np.hypot(columns + 0.5 - x, rows + 0.5 - y) < 9.0
        middle = columns[near].mean() + 0.5, rows[near].mean() + 0.5
        assert np.hypot(middle[0] - x, middle[1] - y) < 0.5, (x, y, middle)


@pytest.mark.parametrize("name", ["brown", "fisheye"])
def test_distances_are_those_of_the_ground_that_is_drawn(renderer, name):
    lens = LENSES[name]
    if name == "fisheye":  # in one piece: height_drawn knows the last picture of the renderer alone
        lens = pf.Intrinsics(160, 90, 80.0, 80.0, 79.5, 44.5, (0.02, -0.01, 0.003, -0.001), "fisheye")
    camera = CAMERA.with_intrinsics(lens)
    out = renderer.render(camera, outputs=("position", "distance", "surface"))
    hit = out["surface"] > 0
    points = renderer.camera_state(camera).position_m + out["position"][hit].astype(float)
    far = np.linalg.norm(points, axis=1)
    drawn = renderer.height_drawn(points / far[:, None])
    off_px = np.abs(far - renderer.scene.planet.radius_m - drawn) / out["distance"][hit] * lens.fx
    assert np.median(off_px) < 0.01 and np.percentile(off_px, 95) < 0.5, "what is left are outlines"


def test_a_pinhole_is_drawn_as_it_is(renderer):
    """cx, cy and fx != fy are in the frustum: every position is exact, and the pixels are those of a frustum in
    degrees."""
    lens = LENSES["pinhole"]
    left, right, bottom, top = (math.degrees(math.atan(t)) for t in lens.tangents)
    same = pf.Camera.at(10.0, 10.0, 30.0, 40.0, -15.0, above="ground", frustum_deg=(left, right, bottom, top))
    found = renderer.render(CAMERA.with_intrinsics(lens), outputs=("color", "distance"))
    wanted = renderer.render(same, outputs=("color", "distance"))
    np.testing.assert_allclose(found["distance"], wanted["distance"], rtol=1e-5)
    assert np.abs(found["color"].astype(int) - wanted["color"]).max() <= 1


@pytest.mark.parametrize("antialiasing", ["temporal", "none"])
def test_a_lens_that_bends_nothing_shows_what_a_pinhole_does(antialiasing):
    """Nothing is blurred or shifted."""
    scene = pf.load_scene("moon")
    lens = pf.Intrinsics(160, 90, 120.0, 120.0, 79.5, 44.5, (1e-7, 0.0, 0.0, 0.0), "brown")
    margin = 24
    wide = pf.Intrinsics(160 + 2 * margin, 90 + 2 * margin, 120.0, 120.0, 79.5 + margin, 44.5 + margin)
    inner = slice(margin, -margin), slice(margin, -margin)
    overrides = {"composite.antialiasing": antialiasing, "composite.dither": False, "composite.bloom": 0.0}
    with pf.Renderer(scene, SIZE, quality="low", overrides=overrides) as renderer:
        found = []
        for camera in (CAMERA.with_intrinsics(wide).exposed(12.0), CAMERA.with_intrinsics(lens).exposed(12.0)):
            renderer.settle(camera)
            found.append(renderer.render(camera, outputs=("color", "radiance", "distance", "normal", "surface")))
    off = np.abs(found[0]["color"][inner].astype(int) - found[1]["color"])
    assert off.max() <= 1
    for name in ("radiance", "distance", "normal", "surface"):
        close = np.isclose(found[0][name][inner], found[1][name], rtol=1e-3, atol=1e-6)
        assert close.mean() > 0.999, name


@pytest.mark.parametrize("tone_map", ["camera", "agx"])
def test_the_last_steps_are_those_of_the_shaders(tone_map):
    """Glare, tone map and dither of finish.py, against a pinhole's picture."""
    look = {"bloom": 0.1, "tone_map": tone_map, "dither": True, "antialiasing": "temporal"}
    overrides = {f"composite.{name}": value for name, value in look.items()}
    with pf.Renderer(pf.load_scene("moon"), SIZE, quality="low", overrides=overrides) as renderer:
        camera = CAMERA.exposed(11.0)
        renderer.settle(camera)
        out = renderer.render(camera, outputs=("color", "composite.resolved", "composite.quarter"))
        quarter = expose(out["composite.quarter"][..., :3], 11.0, renderer.wavelengths_nm)
    # Row 0 is at the bottom there, which dither goes by.
    shown = finished(unpress(out["composite.resolved"][::-1, :, :3]), quarter[::-1], pf.Composite(**look))[::-1]
    off = np.abs(shown.astype(int) - out["color"])
    assert off.max() <= 1 and (off > 0).mean() < 0.02
    light = np.random.default_rng(0).uniform(0.0, 5.0, (50, 3))
    np.testing.assert_allclose(unpress(press(light)), light, rtol=1e-6)


def test_a_panorama_has_no_seams(renderer):
    """What is beside a seam between faces differs no more than elsewhere, around the back as well."""
    lens = pf.Intrinsics.panorama(256)
    camera = pf.Camera.at(10.0, 10.0, 3e5, heading_deg=40.0, pitch_deg=-40.0).with_intrinsics(lens)
    side = np.zeros(lens.width * lens.height, int)
    for k, face in enumerate(faces_of(lens).faces):
        side[face.pixels] = k
    side = side.reshape(lens.height, lens.width)
    renderer.settle(camera)
    picture = np.pad(renderer.render(camera)["color"].astype(float), ((0, 0), (2, 1), (0, 0)), mode="wrap")
    # Third differences: a step that the four pixels around don't lead up to.
    step = np.abs(picture[:, :-3] - 3 * picture[:, 1:-2] + 3 * picture[:, 2:-1] - picture[:, 3:]).mean(axis=2)
    seam = side != np.roll(side, 1, axis=1)
    beside = (np.roll(seam, 3, axis=1) | np.roll(seam, -3, axis=1)) & ~seam
    assert seam.sum() > 4 * 50
    assert step[seam].mean() < 1.25 * step[beside].mean() + 0.1
    assert step[:, 0].mean() < 1.25 * step[:, 4:8].mean() + 0.5


def test_a_panorama_in_a_scene_of_several_planets_and_of_a_sequence():
    """Each face goes on with its own history and the first one's exposure."""
    lens = pf.Intrinsics.panorama(96)
    with pf.Renderer(pf.load_scene("mars_moons"), (64, 36), quality="low") as renderer:
        camera = pf.Camera.at(10.0, 10.0, 2e6, pitch_deg=-60.0).with_intrinsics(lens)
        for _ in range(3):
            out = renderer.render(camera, outputs=("color", "position", "surface"), dt_s=1 / 30)
        assert out["color"].shape == (48, 96, 3) and renderer.exposure is not None
        hit = out["surface"] > 0
        rows, columns = np.nonzero(hit)
        points = renderer.camera_state(camera).position_m + out["position"][hit].astype(float)
        pixels, _ = renderer.project(camera, points)
        assert np.abs(pixels - np.stack([columns + 0.5, rows + 0.5], axis=1)).max() < 1e-2
        with renderer.add_view((32, 18)) as view:
            assert view.render(camera)["color"].shape == (48, 96, 3)
    assert renderer.gpu.counts() == {}


def test_into_a_framebuffer_of_a_host():
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture((192, 108), 4)])
    lens = LENSES["brown"]
    with pf.Renderer(pf.load_scene("moon"), (64, 36), quality="low", ctx=ctx) as renderer:
        for name in ("pinhole", "brown"):
            camera = CAMERA.with_intrinsics(LENSES[name])
            target.clear()
            renderer.render_to(target, camera, viewport=(16, 9, lens.width, lens.height))
            assert ctx.error == "GL_NO_ERROR"
            found = np.frombuffer(target.read(components=3, viewport=(16, 9, *lens.size)), np.uint8)
            found = found.reshape(lens.height, lens.width, 3)[::-1].astype(int)
            wanted = renderer.render(camera)["color"]
            assert np.abs(found - wanted).mean() < 3.0, name  # adapted from frame to frame, and by itself
            assert not np.frombuffer(target.read(components=3, viewport=(0, 0, 192, 9)), np.uint8).any()
        with pytest.raises(
            pf.CameraError, match=r"depth: what a lens bends fits no depth buffer; .* found model 'brow"
        ):
            renderer.render_to(target, camera, depth=pf.HostDepth(0.0, 1.0))
    ctx.release()


def test_photos_and_files_know_the_lens(renderer, tmp_path):
    lens = LENSES["brown"]
    camera = CAMERA.with_intrinsics(lens)
    *_, (done, count, arrays) = photo_tiles(renderer, camera, PhotoPlan(lens.size, supersample=2))
    assert (done, count) == (1, 1) and arrays["color"].shape == (90, 160, 3) and renderer.size == SIZE
    plain = renderer.snapshot(camera).array.astype(int)
    assert np.abs(plain - arrays["color"]).mean() < 6.0
    *_, (_, _, arrays) = photo_tiles(renderer, CAMERA.with_intrinsics(LENSES["pinhole"]), PhotoPlan(SIZE, 2))
    plain = renderer.snapshot(CAMERA.with_intrinsics(LENSES["pinhole"])).array.astype(int)
    assert np.abs(plain - arrays["color"]).mean() < 6.0
    state = renderer.camera_state(camera)
    told = shot_settings(renderer.scene, state, 0.0, lens.size, quality="low", intrinsics=lens)
    for file in (tmp_path / "a.png", tmp_path / "a.npz"):
        save_capture(file, {"color": arrays["color"]}, told)
        shot = load_shot(file)
        assert shot.camera.intrinsics == lens and shot.size == lens.size


def test_on_the_command_line(tmp_path, capsys):
    calibration, picture, again = (tmp_path / name for name in ("camera.yml", "a.npz", "b.png"))
    LENSES["fisheye"].save(calibration)
    place = ["--latitude-deg", "10", "--longitude-deg", "10", "--altitude-m", "5000", "--pitch-deg", "-20"]
    command = ["render", "moon", *place, "--quality", "low", "--intrinsics", str(calibration)]
    assert main([*command, "--size", "64x36", "-o", str(picture)]) == 2
    assert "--size: the intrinsics are for 96 x 96 pixels, found 64x36" in capsys.readouterr().err
    assert main([*command[:-1], str(tmp_path / "none.yml"), "-o", str(picture)]) == 2
    assert "none.yml: no such file" in capsys.readouterr().err
    assert main([*command, "-o", str(picture)]) == 0
    with np.load(picture) as arrays:
        assert arrays["distance"].shape == (96, 96) and arrays["color"].shape == (96, 96, 3)
        color = arrays["color"].astype(int)
    assert main(["render", "--like", str(picture), "-o", str(again)]) == 0
    with Image.open(again) as made:
        assert np.abs(np.asarray(made) - color).max() <= 1


def test_refused_before_any_drawing(renderer):
    camera = CAMERA.with_intrinsics(LENSES["brown"])
    renderer.render(camera)
    before, drawn = renderer.frames, renderer.graph
    renderer.project(camera, np.ones((1, 3)))
    renderer.camera_state(CAMERA)
    assert renderer.graph is drawn, "questions leave the picture as it is"
    nothing = pf.Intrinsics(160, 90, 100.0, 100.0, 1e5, 40.0, (-0.3, 0.0, 0.0, 0.0), "brown")
    with pytest.raises(pf.CameraError, match="no pixel of 160 x 90 has a ray: expected a principal point near"):
        renderer.render(CAMERA.with_intrinsics(nothing))
    with pytest.raises(pf.SizeError, match="beyond this GPU's limit"):
        renderer.render(CAMERA.with_intrinsics(pf.Intrinsics(10**6, 90, 1e5, 1e5, 5e5, 40.0)))
    with pytest.raises(ValueError, match=r"pixel \(200, 3\) is outside the picture of 160 x 90"):
        renderer.pick(CAMERA.with_intrinsics(LENSES["brown"]), 200, 3)
    with pytest.raises(pf.CameraError, match=r"camera must be a pf\.Camera or a pf\.View, found Intrinsics"):
        renderer.pick(LENSES["brown"], 1, 1)
    assert renderer.frames == before
