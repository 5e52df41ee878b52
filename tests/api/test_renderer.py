"""The renderer as a user meets it: outputs, skipping, systems that come and go, a host's context, bad input."""

from __future__ import annotations

import logging
import subprocess
import sys

import moderngl
import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.hosts.headless import create_headless

SIZE = (160, 90)


@pytest.fixture(scope="module")
def scene():
    return pf.load_scene("earth")


@pytest.fixture(scope="module")
def renderer(scene):
    with pf.Renderer(scene, size=SIZE, quality="low") as made:
        yield made


def by_name(renderer):
    return {report.name: report for report in renderer.passes()}


def test_outputs_have_the_promised_shapes(renderer):
    out = renderer.render(pf.view("near"), outputs=("color", "radiance", "distance", "position", "normal", "surface"))
    assert out["color"].shape == (90, 160, 3) and out["color"].dtype == np.uint8
    assert out["radiance"].shape == (90, 160, 3) and out["radiance"].dtype == np.float32
    assert out["surface"].shape == (90, 160) and out["surface"].dtype == np.uint8
    hit = out["surface"] > 0
    assert hit[-1].all() and not hit[0].all(), "ground below, sky above: row 0 is on top"
    assert np.isinf(out["distance"][~hit]).all() and np.isnan(out["position"][~hit]).all()
    assert (out["normal"][~hit] == 0).all()
    assert np.allclose(np.linalg.norm(out["position"][hit], axis=1), out["distance"][hit], rtol=1e-5)
    assert np.allclose(np.linalg.norm(out["normal"][hit], axis=1), 1.0, atol=1e-3)
    assert (np.isfinite(out["radiance"]) & (out["radiance"] >= 0)).all()


def test_position_lies_on_the_pixels_ray(renderer):
    view = pf.view("near")
    out = renderer.render(view, outputs=("position", "surface"))
    state = renderer.camera_state(view)
    rows, columns = np.nonzero(out["surface"] > 0)
    pixels, front = renderer.project(view, state.position_m + out["position"][rows, columns].astype(float))
    assert front.all()
    assert np.abs(pixels - np.stack([columns + 0.5, rows + 0.5], axis=1)).max() < 1e-3


def test_an_unchanged_camera_reruns_no_selection_and_no_upload(renderer):
    view = pf.view("near")
    for _ in range(3):
        renderer.render(view)
    work = renderer.gpu.work
    before = (work.uploads, work.upload_bytes)
    renderer.render(view)
    reports = by_name(renderer)
    for name in ("terrain.vertices", "terrain.cull", "ocean.vertices", "ocean.cull"):
        assert not reports[name].ran and reports[name].skipped_why, name
    assert (work.uploads, work.upload_bytes) == before


def test_a_turned_camera_culls_again_but_makes_no_vertices(renderer):
    renderer.render(pf.Camera.at(45.0, 10.0, 500.0, heading_deg=0.0, pitch_deg=-10.0, above="ground"))
    renderer.render(pf.Camera.at(45.0, 10.0, 500.0, heading_deg=40.0, pitch_deg=-10.0, above="ground"))
    reports = by_name(renderer)
    assert reports["terrain.cull"].ran and not reports["terrain.vertices"].ran


def test_nothing_of_a_planet_out_of_view_is_drawn(renderer):
    renderer.render(pf.Camera.at(0.0, 0.0, 2.0e6, pitch_deg=80.0))
    assert renderer.stats["triangles"] == 0


@pytest.mark.parametrize(("kind", "owner"), [(pf.Terrain, "terrain"), (pf.Ocean, "ocean")])
def test_removing_a_component_takes_its_passes_and_gl_objects(kind, owner):
    scene = pf.load_scene("earth")
    scene.planet.remove(pf.Cover)  # which would go with the ground
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        view = pf.Camera.at(10.0, 20.0, 3.0e5, pitch_deg=-40.0)
        renderer.render(view)
        full = renderer.gpu.counts()
        assert owner in full
        component = scene.planet.remove(kind)
        renderer.render(view)
        without = renderer.gpu.counts()
        assert owner not in without
        assert not [name for name in by_name(renderer) if name.startswith(f"{owner}.")]
        gone = (owner, "shadows") if owner == "terrain" else (owner,)  # the ground's shadows go with it
        others = {name: kinds for name, kinds in full.items() if name not in (*gone, "graph")}
        assert {n: k for n, k in without.items() if n != "graph"} == others
        scene.planet.add(component)
        renderer.render(view)
        assert renderer.gpu.counts()[owner] == full[owner]


def test_release_leaves_nothing_and_may_come_twice():
    renderer = pf.Renderer(pf.load_scene("moon"), size=SIZE, quality="low")
    renderer.render(pf.Camera.at(0.0, 0.0, 1.0e5, pitch_deg=-30.0))
    renderer.release()
    assert renderer.gpu.counts() == {}
    renderer.release()


def test_a_camera_inside_the_ground_is_lifted_with_one_warning(caplog):
    with pf.Renderer(pf.load_scene("moon"), size=SIZE, quality="low") as renderer:
        direction = pf.direction(10.0, 10.0)
        camera = pf.Camera(position_m=direction * 1.70e6, forward=np.cross(direction, (0, 0, 1)), up=direction)
        with caplog.at_level(logging.WARNING, "planetfall"):
            for _ in range(3):
                renderer.render(camera)
        said = [r for r in caplog.records if "inside the ground" in r.getMessage()]
        assert len(said) == 1
        state = renderer.camera_state(camera)
        height = float(pf.TerrainSampler(renderer.scene).height(direction[None])[0])
        assert np.linalg.norm(state.position_m) > renderer.scene.planet.radius_m + height


def test_pick_and_height_drawn_agree_with_the_sampler(renderer, scene):
    camera = pf.Camera.at(45.0, 10.0, 3000.0, pitch_deg=-50.0, above="ground")
    found = renderer.pick(camera, 80, 60)
    assert found is not None
    position, what = found
    assert what in ("terrain", "sea")
    direction = position / np.linalg.norm(position)
    drawn = renderer.height_drawn(direction[None])[0]
    if what == "terrain":
        assert abs(np.linalg.norm(position) - scene.planet.radius_m - drawn) < 0.5
    truth = float(pf.TerrainSampler(scene).height(direction[None])[0])
    assert abs(truth - drawn) < 60.0
    assert renderer.pick(pf.Camera.at(0, 0, 1e6, pitch_deg=80.0), 1, 1) is None


def test_a_guest_leaves_the_hosts_state_alone():
    ctx = create_headless()
    scene = pf.load_scene("moon")
    target = ctx.framebuffer([ctx.texture((96, 54), 4)])
    with pf.Renderer(scene, size=(96, 54), quality="low", ctx=ctx) as renderer:
        target.use()
        ctx.enable(moderngl.BLEND)
        target.viewport = (3, 4, 50, 40)
        renderer.render_to(target, pf.Camera.at(0.0, 0.0, 2e6, pitch_deg=-60.0))
        assert ctx.error == "GL_NO_ERROR"
        assert ctx.fbo is target and target.viewport == (3, 4, 50, 40)
        picture = np.frombuffer(target.read(components=3, viewport=(0, 0, 96, 54)), np.uint8)
        assert picture.max() > 30
    ctx.release()


def test_what_saves_no_picture_needs_no_pillow():
    code = "import sys, planetfall.render.renderer, planetfall.app.window; sys.exit('PIL' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_snapshot_shows_itself(renderer):
    snapshot = renderer.snapshot(pf.view("orbit"))
    assert snapshot._repr_png_()[:4] == b"\x89PNG"


@pytest.mark.parametrize("size", [(0, 10), (10, -1), "320x180", (10,), (1.5, 2)])
def test_a_size_that_cannot_be_is_refused_before_any_gpu_work(scene, size):
    with pytest.raises(pf.errors.SizeError, match="pixels"):
        pf.Renderer(scene, size=size)


def test_a_size_beyond_the_gpu_is_refused(scene):
    with pytest.raises(pf.errors.SizeError, match=r"beyond this GPU's limit of \d+"):
        pf.Renderer(scene, size=(10**6, 10))


def test_unknown_outputs_and_qualities_are_named(renderer, scene):
    with pytest.raises(pf.errors.SettingError, match=r"unknown output 'colour'.*color"):
        renderer.render(pf.view("near"), outputs=("colour",))
    with pytest.raises(pf.errors.SettingError, match="high"):
        pf.Renderer(scene, size=SIZE, quality="hihg")


def test_rendering_after_release_says_so():
    renderer = pf.Renderer(pf.load_scene("moon"), size=SIZE, quality="low")
    renderer.release()
    with pytest.raises(pf.errors.SettingError, match="released"):
        renderer.render(pf.Camera.at(0, 0, 1e6))


def test_from_under_water_the_surface_has_no_hole(scene):
    with pf.Renderer(scene, size=SIZE, quality="medium") as renderer:
        view = pf.view("under", scene.planet)
        surface = renderer.render(view, outputs=("surface",))["surface"]
        assert set(np.unique(surface)) == {1, 2}, "bed below, the sea's underside above, nothing between"
        latitude, longitude = (float(np.ravel(a)[0]) for a in pf.latitude_longitude(view.position_m[None]))
        up = pf.Camera.at(latitude, longitude, -5.0, heading_deg=80.0, pitch_deg=40.0)
        assert (renderer.render(up, outputs=("surface",))["surface"] == 2).all()


def test_what_cannot_be_is_said(renderer):
    view = pf.view("near")
    with pytest.raises(pf.errors.SettingError, match=r"sun must be a pf\.Sun, found \(1, 0, 0\)"):
        renderer.render(view, sun=(1, 0, 0))
    with pytest.raises(pf.errors.SettingError, match="time_s must be a finite number"):
        renderer.render(view, time_s=float("nan"))
    with pytest.raises(pf.errors.SettingError, match=r"write \('color',\)"):
        renderer.render(view, outputs="color")
    with pytest.raises(pf.errors.CameraError, match=r"must be a pf\.Camera"):
        renderer.render("near")
    with pytest.raises(pf.errors.SizeError, match="whole pixels"):
        renderer.resize((1.5, 2))
    for scale in (0.0, -1.0, 7.0, float("nan")):
        with pytest.raises(pf.errors.SettingError, match=r"render_scale: expected a number from 0\.05 to 4"):
            renderer.render_scale = scale
    assert renderer.render_scale == 1.0


def test_ground_that_cannot_be_names_the_planet():
    scene = pf.load_scene("moon")
    with pf.Renderer(scene, size=SIZE, quality="low") as made:
        scene.planet[pf.Terrain].lowest_m = 9000.0
        scene.planet[pf.Terrain].highest_m = -9000.0
        with pytest.raises(pf.errors.SettingError, match="Terrain on a planet"):
            made.render(pf.Camera.at(0.0, 0.0, 1e6))
    with pytest.raises(pf.errors.SettingError, match=r"planet 'moon': Terrain\.lowest_m"):
        pf.Renderer(scene, size=SIZE, quality="low")


def test_settling_after_a_frame_without_colours() -> None:
    """The exposure's buffer goes with the plan that had it."""
    scene = pf.load_scene("asteroid")
    camera = pf.Camera.at(0.0, 0.0, 300.0)
    with pf.Renderer(scene, size=(32, 18), quality="low") as renderer:
        renderer.settle(camera)
        assert renderer.exposure is not None
        for _ in range(2):
            renderer.render(camera, outputs=("radiance",))
            assert renderer.exposure is None
            renderer.settle(camera)
        renderer.render(camera)
        assert renderer.exposure is not None


def test_renderers_of_one_scene_do_not_meet():
    """Ground, proxy and contracts are each renderer's own, and stay when another one goes."""
    scene = pf.load_scene("moon")
    low = pf.Camera.at(0.0, 0.0, 300.0, above="ground")
    high = pf.Camera.at(40.0, 50.0, 5000.0, pitch_deg=-20.0, above="ground")
    with pf.Renderer(scene, size=(64, 36), quality="low") as alone:
        wanted = alone.render(low, outputs=("radiance",))["radiance"]
    first, second = (pf.Renderer(scene, size=(64, 36), quality="low") for _ in range(2))
    for k in range(3):
        np.testing.assert_array_equal(first.render(low, outputs=("radiance",))["radiance"], wanted)
        second.render(high)
        assert second.pick(high, 32.0, 30.0) is not None
        first.resize((50 + k, 36))
        first.render(low)
        first.resize((64, 36))
    second.release()
    first.resize((50, 36))
    first.render(low)
    first.resize((64, 36))
    np.testing.assert_array_equal(first.render(low, outputs=("radiance",))["radiance"], wanted)
    first.release()


def test_renderers_of_one_scene_publish_to_their_own_world():
    """Alternating, each finds what its own systems published, also while it is the other's turn; the scene's world
    holds none of it, and what a host puts there reaches both."""
    scene = pf.load_scene("moon")
    camera = pf.Camera.at(0.0, 0.0, 300.0, above="ground")
    published = {"height_field", "surface_height"}
    with (
        pf.Renderer(scene, size=(64, 36), quality="low") as first,
        pf.Renderer(scene, size=(64, 36), quality="low") as second,
    ):
        first.render(camera)
        own = dict(first.world.resources)
        assert published <= own.keys()
        assert not published & second.world.resources.keys(), "it has drawn nothing yet"
        second.render(camera)
        others = dict(second.world.resources)
        for key in published:
            assert own[key] is not others[key], key
        for _ in range(2):
            for renderer in (first, second):
                renderer.render(camera)
                assert dict(first.world.resources) == own and dict(second.world.resources) == others
        assert not scene.world.resources
        scene.world.set_resource("game.weather", "fog")
        assert {r.world.resource("game.weather") for r in (first, second)} == {"fog"}
        second.release()
        assert all(first.world.resource(key) is own[key] for key in published)
    assert dict(scene.world.resources) == {"game.weather": "fog"}
