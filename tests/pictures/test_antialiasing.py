"""Anti-aliasing: where samples lie, what is taken over from earlier frames and what is not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, maximum_filter

import planetfall as pf
from planetfall.benchmarks.measure.antialiasing import display_light, display_values, flight, rms, supersampled
from planetfall.engine.space import CameraState
from planetfall.systems.composite.jitter import jitter_pattern
from planetfall.systems.composite.temporal import camera_motion

SIZE = (160, 90)
FRAME_S = 1.0 / 30.0


def earth(view: pf.View) -> pf.Scene:
    """Earth with the view's exposure for plain cameras too."""
    scene = pf.load_scene("earth")
    exposure = scene.environment[pf.Exposure]
    exposure.mode, exposure.ev100 = "fixed", view.ev100
    return scene


def renderer_for(view: pf.View, antialiasing: str = "temporal", size: tuple[int, int] = SIZE, **overrides: object):
    settings = {"composite.antialiasing": antialiasing, "composite.samples": 9, **overrides}
    return pf.Renderer(earth(view), size, "medium", settings)


@pytest.fixture(scope="module")
def valley() -> pf.View:
    return pf.view("valley", "earth")


@pytest.fixture(scope="module")
def temporal(valley: pf.View):
    with renderer_for(valley) as made:
        yield made


def moment(view: pf.View) -> dict[str, object]:
    return {"sun": view.sun, "time_s": view.time_s}


# -- where samples lie -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 9, 16, 33])
def test_samples_begin_in_the_centre_and_fill_the_pixel(count):
    places = jitter_pattern(count)
    assert places.shape == (count, 2) and np.abs(places).max() <= 0.5
    assert (places[0] == 0.0).all() and len(np.unique(np.round(places, 9), axis=0)) == count
    if count % 2:
        assert np.abs(places.mean(axis=0)).max() < 1e-12, "an odd number is symmetric: nothing is shifted"


def test_samples_measure_the_coverage_of_an_edge_as_a_grid_does():
    rng = np.random.default_rng(3)
    angle, offset = rng.uniform(0.0, 2.0 * np.pi, 2000), rng.uniform(-0.7, 0.7, 2000)
    normal = np.stack([np.cos(angle), np.sin(angle)])
    fine = (np.stack(np.meshgrid(*[np.arange(128)] * 2), axis=-1).reshape(-1, 2) + 0.5) / 128.0 - 0.5
    covered = (fine @ normal < offset).mean(axis=0)

    def error(places):
        return np.sqrt(np.mean(((places @ normal < offset).mean(axis=0) - covered) ** 2))

    grid = (np.stack(np.meshgrid(*[np.arange(6)] * 2), axis=-1).reshape(-1, 2) + 0.5) / 6.0 - 0.5
    random = rng.uniform(-0.5, 0.5, (33, 2))
    assert error(jitter_pattern(33)) < 1.5 * error(grid) < error(random)


@pytest.mark.parametrize("radius_m", [1e3, 6.371e6, 7e7])
def test_motion_finds_where_a_point_was_seen(radius_m):
    """In f32, as the shader has it, against projection in f64: anchors and snaps play no part."""
    rng = np.random.default_rng(5)
    for altitude in (2.0, 1e3, 1e6):
        zenith = rng.normal(size=3)
        zenith /= np.linalg.norm(zenith)
        place = zenith * (radius_m + altitude)
        ahead = np.cross(zenith, rng.normal(size=3)) - 0.2 * zenith
        then = CameraState.look(place, ahead, zenith)
        now = CameraState.look(place + 0.05 * altitude * rng.normal(size=3), ahead + 0.02 * rng.normal(size=3), zenith)
        motion = camera_motion(now, then)
        inverse_sx, inverse_sy, ox, oy = motion.before
        for distance in altitude * np.array([0.5, 3.0, 100.0]):
            slope = rng.uniform(-0.5, 0.5, 2)
            ray = np.array([*slope, 1.0])
            point = now.position_m + distance * (now.axes.T @ ray)
            local = then.axes @ (point - then.position_m)
            wanted = (local[:2] / local[2] - [ox, oy]) * [inverse_sx, inverse_sy]
            turn, shift = motion.turn.astype(np.float32), motion.shift_m.astype(np.float32)
            seen = turn @ ray.astype(np.float32) + shift * np.float32(1.0 / distance)
            found = (seen[:2] / seen[2] - [ox, oy]) * [inverse_sx, inverse_sy]
            # A hundredth of a pixel of 1080 rows is 2e-5; local itself has the rounding of a position in f64.
            assert np.abs(found - wanted).max() < 2e-6 + 4e-16 * radius_m / distance


def test_stars_are_followed_and_not_the_planet():
    now = CameraState.look((7e6, 0.0, 0.0), (0.0, 1.0, 0.2))
    angle = 0.01
    turned = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    motion = camera_motion(now, now, turned, np.eye(3))
    star = np.array([0.1, 0.9, 0.3])  # inertial
    np.testing.assert_allclose(motion.sky_turn @ (now.axes @ turned @ star), now.axes @ star, atol=1e-12)
    np.testing.assert_allclose(motion.turn, np.eye(3), atol=1e-12)


# -- a still camera --------------------------------------------------------------------------------------------------


def test_a_settled_picture_is_the_supersampled_one(valley):
    with renderer_for(valley, "none") as plain:
        plain.settle(valley)
        reference = supersampled(plain, valley, side=6, **moment(valley))
        none = rms(display_light(plain.render(valley)["color"]), reference)
    errors = []
    for samples in (1, 3, 9, 33):
        with renderer_for(valley, **{"composite.samples": samples}) as renderer:
            renderer.settle(valley)
            errors.append(rms(display_light(renderer.render(valley)["color"]), reference))
    assert errors[0] == pytest.approx(none, rel=0.02), "one sample is the pixel's middle"
    assert errors[1] < 0.5 * none and errors[2] < 0.35 * none and errors[3] < 0.25 * none
    # Half a step of 8 bits, its rounding and dither in picture and reference, is 0.4 steps rms.
    assert errors[3] < 0.8


def test_a_settled_picture_stays_as_it_is(temporal, valley):
    temporal.settle(valley)
    first = temporal.render(valley)["color"]
    with_arrays = temporal.render(valley, outputs=("color", "position", "radiance"))
    again = temporal.render(valley, dt_s=FRAME_S)["color"]
    np.testing.assert_array_equal(first, with_arrays["color"])
    np.testing.assert_array_equal(first, again)
    with renderer_for(valley) as fresh:
        fresh.settle(valley)
        np.testing.assert_array_equal(fresh.render(valley)["color"], first)


def test_a_change_of_the_scene_ends_a_settled_picture(valley):
    with renderer_for(valley) as renderer:
        renderer.settle(valley)
        before = renderer.render(valley)["color"]
        renderer.scene.planet[pf.Terrain].rock_albedo = (0.02, 0.02, 0.02)
        changed = renderer.render(valley)["color"]
        with renderer_for(valley, "edge") as fresh:
            fresh.scene.planet[pf.Terrain].rock_albedo = (0.02, 0.02, 0.02)
            fresh.settle(valley)
            np.testing.assert_array_equal(fresh.render(valley)["color"], changed)
    assert (before != changed).any()


def test_arrays_are_those_of_pixel_centres(temporal, valley):
    names = ("radiance", "distance", "position", "normal", "surface")
    cameras = flight(valley, temporal.camera_state(valley), 4, 3.0, 0.1)
    with renderer_for(valley, "none") as plain:
        plain.settle(cameras[0], **moment(valley))
        temporal.settle(cameras[0], **moment(valley))
        for camera in cameras:
            temporal.render(camera, dt_s=FRAME_S, **moment(valley))  # jittered
            plain.render(camera, dt_s=FRAME_S, **moment(valley))
            wanted = plain.render(camera, outputs=names, dt_s=FRAME_S, **moment(valley))
            found = temporal.render(camera, outputs=("color", *names), dt_s=FRAME_S, **moment(valley))
            for name in names:
                np.testing.assert_array_equal(found[name], wanted[name], err_msg=name)


# -- pictures by themselves, cuts ------------------------------------------------------------------------------------


def test_a_picture_by_itself_shows_nothing_of_earlier_ones(valley):
    state = renderer_state(valley)
    cameras = flight(valley, state, 6, 2.0, 0.3)
    with renderer_for(valley) as fresh:
        fresh.settle(cameras[-1], **moment(valley))  # the air's tables
        fresh.render(cameras[0], **moment(valley))
        wanted = fresh.render(cameras[-1], **moment(valley))["color"]
    with renderer_for(valley) as renderer:
        renderer.settle(cameras[0], **moment(valley))
        for camera in cameras:
            renderer.render(camera, dt_s=FRAME_S, **moment(valley))
        np.testing.assert_array_equal(renderer.render(cameras[-1], **moment(valley))["color"], wanted)
        np.testing.assert_array_equal(renderer.render(cameras[-1], **moment(valley))["color"], wanted)


def renderer_state(view: pf.View) -> CameraState:
    return view.camera.resolve(pf.load_scene("earth"), SIZE[0] / SIZE[1])


def test_a_teleport_a_cut_and_another_size_begin_anew(valley):
    there = pf.view("coast", "earth")
    with renderer_for(valley) as renderer:
        renderer.settle(there, **moment(valley))
        renderer.render(valley)
        wanted = renderer.render(there, **moment(valley))["color"]
        for camera in flight(valley, renderer_state(valley), 5, 2.0):
            renderer.render(camera, dt_s=FRAME_S, **moment(valley))
        np.testing.assert_array_equal(renderer.render(there, dt_s=FRAME_S, **moment(valley))["color"], wanted)
        renderer.resize((100, 50))
        renderer.render(there, dt_s=FRAME_S, **moment(valley))
        renderer.render(there, dt_s=FRAME_S, **moment(valley))
        renderer.resize(SIZE)
        np.testing.assert_array_equal(renderer.render(there, dt_s=FRAME_S, **moment(valley))["color"], wanted)


def frames_of(renderer: pf.Renderer) -> np.ndarray:
    """Frames that each pixel's colour was gathered over, row 0 on top."""
    texture = renderer.graph.resource("composite.resolved")
    codes = np.frombuffer(texture.read(), np.float32).reshape(*texture.size[::-1], 4)[::-1, :, 3]
    return codes.astype(int) & 63


def test_history_survives_a_snap_of_the_proxy(valley):
    cameras = flight(valley, renderer_state(valley), 40, 4.0)
    with renderer_for(valley, **{"proxy.ahead_frames": 4}) as renderer:  # else there is one snap in 20 frames
        renderer.settle(cameras[0], **moment(valley))
        generations, kept = [], []
        for camera in cameras[1:]:
            renderer.render(camera, dt_s=FRAME_S, **moment(valley))
            generations.append(renderer.views[0].proxy.generation)
            kept.append((frames_of(renderer) > 1).mean())
    assert generations[-1] > generations[0] + 1, "the flight has to cross some cells"
    assert min(kept) > 0.97, "all but what comes in at the border and what was hidden"


def test_what_was_hidden_has_no_past():
    """A box before the camera goes: where it was nothing of it is left in the next frame."""
    view = pf.view("noon", "earth")
    scene = earth(view)
    state = renderer_state(view)
    place = state.position_m + 20.0 * state.forward
    with pf.Renderer(scene, SIZE, "medium", {"composite.samples": 9}) as renderer:
        body = scene.add(pf.Transform(tuple(place)), pf.Shape("box", (6.0, 6.0, 6.0), (0.9, 0.9, 0.02)))
        renderer.settle(view)
        with_body = renderer.render(view, outputs=("color", "surface"))
        renderer.render(view, dt_s=FRAME_S)
        body[pf.Transform].position_m = tuple(state.position_m - 50.0 * state.forward)
        after = renderer.render(view, dt_s=FRAME_S)["color"].astype(int)
        without = renderer.render(view)["color"].astype(int)
    was = binary_erosion(with_body["surface"] == 3)  # pixels of its outline were ground as well
    assert was.sum() > 100
    assert np.abs(with_body["color"].astype(int) - without)[was].max(axis=-1).mean() > 40
    # Redder than blue: a body, not the ground. Less is left than the least share that a frame's sample ever has.
    body, after, ground = (p[..., 0] - p[..., 2] for p in (with_body["color"].astype(int), after, without))
    assert body[was].mean() > 100
    # Fresh ground has one sample a pixel: a grain of it may be redder than the mean of all samples around it. What is
    # left of a body would be at all pixels, a sixteenth of it or more: four times what the mean may have.
    assert ((after - maximum_filter(ground, 3))[was] > body[was].mean() / 16.0).mean() < 0.02
    assert (after - ground)[was].mean() < body[was].mean() / 64.0


def test_a_moved_sun_leaves_no_trail():
    view = pf.view("limb", "earth")
    with renderer_for(view, size=(320, 180), **{"composite.bloom": 0.0}) as renderer:
        camera = pf.Camera(view.resolve(renderer.scene).position_m, view.forward, view.up, view.fov_y_deg)
        sun = view.sun
        renderer.settle(camera, sun=sun)
        first = renderer.render(camera, sun=sun)["color"].astype(int)
        moved = dataclasses.replace(sun, elevation_deg=sun.elevation_deg + 1.5)
        after = renderer.render(camera, sun=moved, dt_s=FRAME_S)["color"].astype(int)
        alone = renderer.render(camera, sun=moved)["color"].astype(int)
    gone = (first.min(axis=-1) > 250) & (alone.max(axis=-1) < 200)
    assert gone.sum() > 3, "the disc has left its pixels"
    # A sample beside the pixel's centre may show what its neighbours show, and nothing more.
    around = maximum_filter(alone, (3, 3, 1))
    assert (after - around)[gone].max() <= 3


# -- moving ----------------------------------------------------------------------------------------------------------


def test_a_turning_camera_shimmers_less_and_is_nearer_to_the_truth():
    view = pf.view("near", "earth")
    cameras = flight(view, renderer_state(view), 22, 0.0, 0.23)
    with renderer_for(view, "none") as plain:
        plain.settle(cameras[0], **moment(view))
        truth = [display_values(supersampled(plain, c, 4, **moment(view))) for c in cameras[10:]]
    errors = {}
    for name, kind, every in (("none", "none", 1), ("temporal", "temporal", 1), ("checkered", "temporal", 2)):
        with renderer_for(view, kind, **{"composite.samples": 17, "terrain.shade_every": every}) as renderer:
            renderer.settle(cameras[0], **moment(view))
            seen = [renderer.render(c, dt_s=FRAME_S, **moment(view))["color"] / 255.0 for c in cameras][10:]
        errors[name] = np.stack(seen) - np.stack(truth)
    assert errors["temporal"].var(axis=0).mean() < 0.6 * errors["none"].var(axis=0).mean()
    assert np.square(errors["temporal"]).mean() < 0.35 * np.square(errors["none"]).mean()
    # With light of its own in every second pixel, what is as fine as that is missed; still it is the better picture.
    assert errors["checkered"].var(axis=0).mean() < 0.6 * errors["none"].var(axis=0).mean()
    assert np.square(errors["checkered"]).mean() < 0.7 * np.square(errors["none"]).mean()


# -- switched off ----------------------------------------------------------------------------------------------------


def test_without_it_there_is_no_pass_and_no_memory(valley):
    sizes = {}
    with renderer_for(valley) as renderer:
        for kind in ("none", "edge", "temporal", "none"):
            renderer.settings["composite.antialiasing"] = kind
            renderer.render(valley)
            names = {p.name for p in renderer.passes()}
            assert ("composite.resolve" in names) == (kind != "none")
            sizes[kind] = renderer.graph.bytes_of("composite.resolved")
    width, height = SIZE
    assert sizes == {"none": 0, "edge": 16 * width * height, "temporal": 2 * 16 * width * height}


def test_a_single_frame_has_smoother_outlines(valley):
    view = pf.view("space", "earth")
    with renderer_for(view, "none") as plain:
        plain.settle(view)
        truth = supersampled(plain, view, side=6, **moment(view))
        none = rms(display_light(plain.render(view)["color"]), truth)
    with renderer_for(view, "edge") as edge:
        edge.settle(view)
        found = rms(display_light(edge.render(view)["color"]), truth)
    with renderer_for(view) as temporal:
        temporal.settle(pf.view("coast", "earth"))
        temporal.settle(view)
        temporal.render(pf.view("coast", "earth"))
        alone = temporal.render(view)["color"]
    assert found < 0.9 * none
    assert rms(display_light(alone), truth) < 0.9 * none


def test_stars_keep_their_light_while_the_camera_turns():
    view = pf.view("night", "earth")
    state = renderer_state(view)
    upwards = 0.5 * state.forward + 0.8 * state.direction
    seen = pf.Camera(position_m=state.position_m, forward=upwards, up=state.up, fov_y_deg=60.0)
    cameras = flight(seen, seen.resolve(pf.load_scene("earth"), 16 / 9), 16, 0.0, 0.05)
    with renderer_for(view, size=(320, 180)) as renderer:
        light = {}
        for name in ("settled", "moving"):
            if name == "settled":
                renderer.settle(cameras[-1], **moment(view))
                renderer.render(cameras[-1], **moment(view))
            else:
                renderer.settle(cameras[0], **moment(view))
                for camera in cameras:
                    renderer.render(camera, dt_s=FRAME_S, **moment(view))
            texture = renderer.graph.resource("composite.resolved")
            pressed = np.frombuffer(texture.read(), np.float32).reshape(180, 320, 4)[..., 1].astype(float)
            light[name] = pressed - np.median(pressed)
    # Pressed light is light for all but the brightest.
    assert light["settled"].max() > 0.05, "there are stars"
    assert light["moving"].sum() == pytest.approx(light["settled"].sum(), rel=0.1)
