"""Labels of pictures: depth, slope, flow, sunlit, albedo, material, instance, held against OpenCV's camera model, the
height function, and the light that the renderer makes of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.engine.frame.labels import MaterialId
from planetfall.engine.space import CameraState, pixel_rays, ray_sphere_from

pytestmark = pytest.mark.gpu

SIZE = (160, 90)
LABELS = ("depth", "slope_deg", "flow", "sunlit", "albedo", "material", "instance")
PASSES = (
    *("outputs.moved", "outputs.sunlit", "outputs.albedo", "outputs.instance"),
    *("terrain.labels", "ocean.labels", "props.instance", "cover.instance"),
)
BROWN = (0.3, 0.2, 0.1)


def smooth_scene(**terrain: Any) -> pf.Scene:
    """A sphere of 500 km radius without air, of one colour."""
    scene = pf.load_scene("asteroid")
    scene.planet[pf.Planet].radius_m = 5e5
    ground = pf.Terrain(highest_m=1e-3, lowest_m=-1e-3, layers=1, craters=0.0, mountains=0.0, plants=0.0, clutter=0.0,
        grain=0.0, variation=0.0, strata=0.0, dust_law=0.0, snow_line_m=1e6, snow_line_pole_m=1e6, rock_albedo=BROWN,
        strata_albedo=BROWN, dry_albedo=BROWN, sand_albedo=BROWN, **terrain)  # fmt: skip
    scene.planet.add(ground)
    scene.sun = pf.Sun(elevation_deg=35.0, azimuth_deg=120.0, latitude_deg=10.0, longitude_deg=20.0)
    return scene


@pytest.fixture(scope="module")
def smooth():
    """Its renderer, with a box on the ground, of which two faces look north and up."""
    scene = smooth_scene()
    up = pf.direction(10.02, 20.0)
    place = up * (5e5 + 20.0)
    north = np.array([0.0, 0.0, 1.0]) - up[2] * up
    north /= np.linalg.norm(north)
    axes = np.stack([np.cross(north, up), north, up], axis=1)
    box = scene.add(
        pf.Transform(tuple(place), quaternion(axes)), pf.Shape("box", size_m=(60.0, 60.0, 40.0), color=(0.5, 0.2, 0.7))
    )
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        yield renderer, box


def quaternion(axes: NDArray[np.float64]) -> tuple[float, float, float, float]:
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(axes).as_quat()
    return float(x), float(y), float(z), float(w)


@pytest.fixture(scope="module")
def earth():
    with pf.Renderer(pf.load_scene("earth"), size=SIZE, quality="low") as renderer:
        yield renderer


def opencv_pixels(state: CameraState, points_m: NDArray[np.float64]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Pixels (N, 2) and depths (N,) of points from the camera's place, by cv2.projectPoints: x right, y down, z ahead;
    its pixel (0, 0) is the first one's middle."""
    cv2 = pytest.importorskip("cv2", reason="pip install opencv-python-headless")
    width, height = SIZE
    turn = np.stack([state.right, -state.up, state.forward])
    focal_x, focal_y = width / (state.tan_right - state.tan_left), height / (state.tan_top - state.tan_bottom)
    matrix = np.array([[focal_x, 0, width / 2 - 0.5], [0, focal_y, height / 2 - 0.5], [0, 0, 1.0]])
    vector, _ = cv2.Rodrigues(turn)
    pixels, _ = cv2.projectPoints(points_m.reshape(-1, 1, 3), vector, np.zeros(3), matrix, None)
    return pixels[:, 0] + 0.5, points_m @ state.forward


def over(latitude_deg: float, altitude_m: float, **turned: float) -> pf.Camera:
    return pf.Camera.at(latitude_deg, 20.0, altitude_m, pitch_deg=-25.0, **turned)


def test_flow_and_depth_are_those_of_opencv_on_the_ground_that_is_drawn(earth):
    first, second = pf.view("valley"), pf.view("valley")
    state = earth.camera_state(first)
    moved = pf.Camera(
        position_m=tuple(state.position_m + 3.0 * state.right - 2.0 * state.forward),
        forward=tuple(state.forward + 0.02 * state.up), up=tuple(state.up + 0.01 * state.right),
        fov_y_deg=math.degrees(2.0 * math.atan(state.tan_top)),
    )  # fmt: skip
    earth.render(moved)
    out = earth.render(second, outputs=("flow", "depth", "distance", "position"))
    before = earth.camera_state(moved)
    rows, columns = np.nonzero(np.isfinite(out["distance"]))
    assert len(rows) > 3000
    point = out["position"][rows, columns].astype(np.float64)
    now, depth = opencv_pixels(state, point)
    then, _ = opencv_pixels(before, point + (state.position_m - before.position_m))
    np.testing.assert_allclose(now, np.stack([columns + 0.5, rows + 0.5], axis=1), atol=1e-3)
    flow = out["flow"][rows, columns]
    assert np.abs(flow).max() > 2.0
    np.testing.assert_allclose(flow, then - now, atol=0.01)
    np.testing.assert_allclose(out["depth"][rows, columns], depth, rtol=1e-6)
    assert np.isinf(out["depth"][~np.isfinite(out["distance"])]).all()


def test_flow_is_the_analytic_one_on_a_sphere(smooth):
    renderer, _ = smooth
    first, second = over(9.0, 4000.0, heading_deg=80.0), over(9.001, 4010.0, heading_deg=80.5)
    renderer.render(first)
    out = renderer.render(second, outputs=("flow", "surface"))
    before, now = renderer.camera_state(first), renderer.camera_state(second)
    rays = pixel_rays(now, SIZE)
    hit = ray_sphere_from(now.position_m, rays, 5e5)
    point = now.position_m + rays * np.where(hit.hit, hit.near_m, np.nan)[..., None]
    flat = (-rays @ now.direction > 0.02) & hit.hit & (out["surface"] == 1)
    assert flat.sum() > 0.5 * flat.size
    pixels, front = renderer.project(first, point[flat])
    rows, columns = np.nonzero(flat)
    wanted = pixels - np.stack([columns + 0.5, rows + 0.5], axis=1)
    assert front.all() and np.abs(wanted).max() > 1.0
    np.testing.assert_allclose(out["flow"][flat], wanted, atol=0.01)
    np.testing.assert_array_equal(before.position_m, renderer.camera_state(first).position_m)


def test_the_sky_flows_as_directions_at_infinity(smooth):
    renderer, _ = smooth
    first, second = (
        pf.Camera.at(10.0, 20.0, height, heading_deg=heading, pitch_deg=40.0)
        for height, heading in ((100.0, 0.0), (900.0, 3.0))
    )
    renderer.render(first)
    out = renderer.render(second, outputs=("flow", "surface"))
    assert (out["surface"] == 0).all()
    before, now = renderer.camera_state(first), renderer.camera_state(second)
    wanted, _ = opencv_pixels(before, pixel_rays(now, SIZE).reshape(-1, 3))
    columns, rows = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    np.testing.assert_allclose(out["flow"], wanted.reshape(*rows.shape, 2) - np.stack([columns, rows], -1), atol=0.01)
    behind = renderer.render(pf.Camera.at(10.0, 20.0, 100.0, heading_deg=180.0, pitch_deg=0.0), outputs=("flow",))
    assert np.isnan(behind["flow"]).any(), "what lay behind the camera before has no pixel there"


def test_flow_begins_with_nan_and_neither_settling_nor_picking_is_a_frame_before(smooth):
    renderer, _ = smooth
    first, second = over(9.0, 4000.0), over(9.01, 4000.0)
    view = renderer.add_view(SIZE)
    assert np.isnan(view.render(first, outputs=("flow",))["flow"]).all()
    view.settle(second)
    view.pick(second, 80.0, 80.0)
    moved = view.render(second, outputs=("flow",))["flow"]
    assert np.abs(moved[-1]).max() > 1.0
    still = view.render(second, outputs=("flow",))["flow"]
    assert np.nanmax(np.abs(still)) < 1e-3
    view.release()


def test_props_flow_with_their_own_motion():
    scene = smooth_scene()
    place = pf.direction(10.0, 20.0) * (5e5 + 500.0)
    ball = scene.add(pf.Transform(tuple(place)), pf.Shape("sphere", size_m=(100.0, 100.0, 100.0)))
    camera = pf.Camera.at(9.98, 20.0, 500.0, heading_deg=0.0, pitch_deg=0.0)
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        renderer.render(camera, dt_s=0.1)
        way = 4.0 * renderer.camera_state(camera).right
        ball[pf.Transform].position_m = tuple(place + way)
        out = renderer.render(camera, outputs=("flow", "surface", "position", "depth"), dt_s=0.1)
        on = out["surface"] == 3
        assert on.sum() > 50
        position = renderer.camera_state(camera).position_m + out["position"][on].astype(np.float64)
        was, now = renderer.project(camera, position - way)[0], renderer.project(camera, position)[0]
        np.testing.assert_allclose(out["flow"][on], was - now, atol=0.02)
        assert np.nanmax(np.abs(out["flow"][out["surface"] == 1])) < 1e-3


def test_slope_is_that_of_the_height_function_and_of_faces(smooth, earth):
    renderer, _ = smooth
    camera = pf.Camera.at(10.03, 20.0, 60.0, heading_deg=180.0, pitch_deg=-12.0)
    out = renderer.render(camera, outputs=("slope_deg", "surface"))
    ground, prop = out["slope_deg"][out["surface"] == 1], out["slope_deg"][out["surface"] == 3]
    assert ground.max() < 0.05 and len(prop) > 100
    assert set(np.round(prop).astype(int)) == {0, 90}
    assert np.isnan(out["slope_deg"][out["surface"] == 0]).all()
    view = pf.view("valley")
    out = earth.render(view, outputs=("slope_deg", "normal", "position", "surface", "distance"))
    near = (out["surface"] == 1) & (out["distance"] < 3000.0)
    place = earth.camera_state(view).position_m + out["position"][near].astype(np.float64)
    up = place / np.linalg.norm(place, axis=1)[:, None]
    normals = pf.TerrainSampler(earth.scene).normal(up)
    slopes = np.degrees(np.arccos(np.clip((normals * up).sum(axis=1), -1.0, 1.0)))
    # What the triangles don't show is no part of it.
    assert near.sum() > 1000 and abs(np.median(out["slope_deg"][near] - slopes)) < 2.0
    assert np.corrcoef(out["slope_deg"][near], slopes)[0, 1] > 0.4
    drawn = np.degrees(np.arccos((out["normal"][near].astype(np.float64) * up).sum(axis=1)))
    np.testing.assert_allclose(out["slope_deg"][near], drawn, atol=0.05)


def test_sunlit_ends_at_the_terminator_and_in_shadows(smooth):
    renderer, _ = smooth
    out = renderer.render(pf.Camera.at(10.0, 20.0, 2e6, pitch_deg=-90.0), outputs=("sunlit", "normal", "surface"))
    facing = out["normal"].astype(np.float64) @ np.asarray(pf.sun_direction(renderer.scene))
    ground = out["surface"] == 1
    assert (out["sunlit"][ground & (facing > 0.05)] > 0.99).all()
    assert (out["sunlit"][ground & (facing < -0.05)] == 0.0).all()
    assert (out["sunlit"][~ground] == 0.0).all() and (ground & (facing < -0.05)).sum() > 100
    # A box of 40 m under a sun at 35 degrees from the south-east: shadow beside it.
    above = pf.Camera.at(10.02, 20.0, 300.0, pitch_deg=-90.0)
    out = renderer.render(above, outputs=("sunlit", "surface"))
    ground = out["sunlit"][out["surface"] == 1]
    assert 0.01 < (ground < 0.05).mean() < 0.3 and (ground > 0.95).mean() > 0.5
    assert out["sunlit"][out["surface"] == 3].mean() > 0.95, "its top"


def test_albedo_times_sunlight_is_the_radiance_of_matt_ground(smooth):
    renderer, _ = smooth
    outputs = ("albedo", "radiance", "normal", "surface", "sunlit", "material")
    out = renderer.render(over(9.0, 4000.0), outputs=outputs)
    ground = (out["surface"] == 1) & (out["sunlit"] > 0.99)
    facing = out["normal"].astype(np.float64) @ np.asarray(pf.sun_direction(renderer.scene))
    wanted = out["albedo"] * renderer.frame.sun.irradiance * np.maximum(facing, 1e-6)[..., None] / np.pi
    wanted[~ground] = 1.0
    assert ground.sum() > 5000
    # Light from other ground is in it, and pixels of which one in four is lit.
    assert (np.abs(out["radiance"] / wanted - 1.0)[ground] < 0.02).mean() > 0.98
    assert (out["albedo"][out["surface"] == 0] == 0.0).all() and (out["material"][out["surface"] == 0] == 0).all()


def test_materials_have_names(earth):
    names = earth.materials
    assert names[0] == "none" and names[1] == "water" and len(set(names.values())) == len(names)
    out = earth.render(pf.view("coast"), outputs=("material", "surface", "albedo"))
    assert (out["material"][out["surface"] == 2] == 1).all()
    shown = {names[int(n)] for n in np.unique(out["material"][out["surface"] == 1])}
    assert {"beach", "leaves"} <= shown and not shown & {"none", "water", "props"}
    water, beach = (out["albedo"][out["material"] == n].mean() for n in (1, {v: k for k, v in names.items()}["beach"]))
    assert 0.0 < water < 0.1 < beach < 0.6
    ice = earth.render(pf.Camera.at(89.0, 0.0, 5000.0, pitch_deg=-50.0), outputs=("material", "albedo"))
    shown = {names[int(n)] for n in np.unique(ice["material"])}
    assert shown & {"ice", "snow"} and ice["albedo"].max() > 0.5


def test_a_games_material_has_a_number():
    from planetfall import extend

    extend.register_material("red_moss", (0.5, 0.05, 0.02), "1.0")
    try:
        with pf.Renderer(smooth_scene(), size=SIZE, quality="low") as renderer:
            out = renderer.render(over(9.0, 4000.0), outputs=("material", "surface"))
            found = {renderer.materials[int(n)] for n in np.unique(out["material"][out["surface"] == 1])}
            assert found == {"red_moss"}
    finally:
        extend.unregister_material("red_moss")
    assert "red_moss" not in renderer.materials.values()


def test_instances_of_props_are_their_entities(smooth):
    renderer, box = smooth
    camera = pf.Camera.at(10.03, 20.0, 60.0, heading_deg=180.0, pitch_deg=-12.0)
    out = renderer.render(camera, outputs=("instance", "surface"))
    assert (out["instance"][out["surface"] == 3] == box.entity).all() and (out["surface"] == 3).sum() > 100
    assert (out["instance"][out["surface"] != 3] == 0).all()


def test_instances_of_trees_are_those_that_the_sampler_names():
    scene = pf.load_scene("woods")
    view = pf.view("near", scene.planet)
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        renderer.settle(view)
        out = renderer.render(view, outputs=("instance", "surface", "material", "albedo"))
        place = renderer.camera_state(view).position_m
    tree = out["surface"] == 4
    assert tree.sum() > 80
    assert (out["instance"][tree] > 2**31).all() and (out["instance"][~tree] == 0).all()
    plants = pf.CoverSampler(scene).within(place / np.linalg.norm(place), 2000.0)
    assert len(np.unique(plants.instances)) > 0.999 * len(plants)
    shown = np.unique(out["instance"][tree])
    assert len(shown) > 15 and np.isin(shown, plants.instances).all()
    assert {renderer.materials[int(n)] for n in np.unique(out["material"][tree])} <= {"leaves", "wood"}
    assert 0.01 < out["albedo"][tree].mean() < 0.2


@pytest.mark.parametrize("override", [{"terrain.method": "paper"}, {"terrain.backend": "icosphere"}])
def test_other_grounds_have_labels_too(override):
    with pf.Renderer(pf.load_scene("earth"), size=SIZE, quality="low", overrides=override) as renderer:
        out = renderer.render(pf.view("coast"), outputs=(*LABELS, "surface"))
    ground = out["surface"] == 1
    material = out["material"][ground]
    assert ((material >= 16) | (material == MaterialId.LEAVES)).all()  # forests far away are leaves
    assert (out["albedo"][ground].max(axis=1) > 0.0).mean() > 0.99


def test_what_nobody_asks_for_is_culled():
    scene = pf.load_scene("woods")
    scene.add(pf.Transform((6.4e6, 0.0, 0.0)), pf.Shape("box"))
    with pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
        view = pf.view("near", scene.planet)
        renderer.render(view, outputs=("color", "radiance", "distance", "normal"))
        plan, memory = renderer.graph, renderer.memory_bytes
        assert set(PASSES) <= set(plan.culled)
        renderer.render(view, outputs=("depth", "slope_deg"))
        assert set(PASSES) <= set(renderer.graph.culled), "both follow from the position"
        renderer.render(view, outputs=("instance",))
        assert set(PASSES) - set(renderer.graph.culled) == {"outputs.instance", "props.instance", "cover.instance"}
        renderer.render(view, outputs=("material",))
        assert set(PASSES) - set(renderer.graph.culled) == {"outputs.albedo", "terrain.labels", "ocean.labels"}
        renderer.render(view, outputs=("color", "radiance", "distance", "normal"))
        assert renderer.memory_bytes["graph"] == memory["graph"]


def id_colors(numbers: NDArray[Any]) -> NDArray[np.float64]:
    """(H, W, 3): colours of numbers in debug views, as debug/view.frag has them."""
    number = numbers.astype(np.int64)
    hue = ((number * 2654435769 % 2**32) / 2**32)[..., None]
    wheel = np.clip(np.abs(np.mod(hue + np.array([0.0, 2.0 / 3.0, 1.0 / 3.0]), 1.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0)
    color = (0.28 + 0.72 * wheel) * np.where(number % 2, 0.95, 0.72)[..., None]
    return np.where(number[..., None] == 0, 0.04, color)


def test_debug_views_show_the_labels():
    scene = pf.load_scene("woods")
    shown = scene.environment.add(pf.DebugView())
    view = pf.view("near", scene.planet)
    wanted = ("color", "slope_deg", "sunlit", "albedo", "material", "instance", "depth")
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        ahead = renderer.camera_state(view)
        place = tuple(ahead.position_m + 12.0 * np.asarray(ahead.forward))
        scene.add(pf.Transform(place), pf.Shape("box", size_m=(2.0, 2.0, 2.0)))
        for name, passes in (
            ("slope", ()),
            ("sunlit", ("outputs.sunlit",)),
            ("albedo", ("outputs.albedo", "terrain.labels")),
            ("material", ("outputs.albedo", "terrain.labels")),
            ("instance", ("outputs.instance", "props.instance")),
        ):
            shown.view = name
            renderer.render(view)
            culled = set(PASSES) & set(renderer.graph.culled)
            assert not culled & set(passes) and culled >= {"outputs.moved"}
            out = renderer.render(view, outputs=wanted)
            color, there = out["color"] / 255.0, np.isfinite(out["depth"])
            if name == "slope":
                level, steep = there & (out["slope_deg"] < 2.0), there & (out["slope_deg"] > 80.0)
                assert color[level].max() < 0.3 and color[steep][:, 0].min() > 0.9
                np.testing.assert_allclose(color[~there], 0.3, atol=0.01)
                continue
            expected = {
                "sunlit": lambda o=out: np.repeat(o["sunlit"][..., None], 3, axis=2),
                "albedo": lambda o=out: np.where(
                    o["albedo"] <= 0.0031308,
                    12.92 * o["albedo"],
                    1.055 * np.maximum(o["albedo"], 0) ** (1 / 2.4) - 0.055,
                ),
                "material": lambda o=out: id_colors(o["material"]),
                "instance": lambda o=out: id_colors(o["instance"]),
            }[name]()
            near = np.abs(color - np.clip(expected, 0.0, 1.0)).max(axis=-1) < 0.02
            assert near.all(), (name, (~near).sum())
        shown.view = "off"
        renderer.render(view)
        assert set(PASSES) <= set(renderer.graph.culled)


def test_a_name_that_is_none_is_refused_before_anything_is_drawn(earth):
    frames = earth.frames
    for outputs, words in ((("slope",), "slope_deg"), ((3,), "names such as"), ("depth", "write"), ((), "sequence")):
        with pytest.raises(pf.SettingError, match=words):
            earth.render(pf.view("coast"), outputs=outputs)
    assert earth.frames == frames


def test_labels_are_saved_with_the_others(earth, tmp_path):
    out = earth.render(pf.view("coast"), outputs=("depth", "flow", "instance", "material"))
    pf.save_capture(tmp_path / "labels.npz", out)
    with np.load(tmp_path / "labels.npz") as found:
        np.testing.assert_array_equal(found["instance"], out["instance"])
    with pytest.raises(pf.OutputError, match="npz"):
        pf.save_capture(tmp_path / "labels.exr", out)
    del out["instance"]
    pf.save_capture(tmp_path / "labels.exr", out)
