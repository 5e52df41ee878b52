"""Props: where they are drawn, their light and shadows, many of them, what none of them costs; files and bad input."""

from __future__ import annotations

import builtins
import logging

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.display import reflectance
from planetfall.engine.space import CameraState
from planetfall.engine.wavelengths import GIVEN_NM, carried_sunlight
from planetfall.systems.props.instances import read_props, rotation_matrices, seen_by
from planetfall.systems.props.meshes import MeshError, box, load_mesh, mesh_of, sphere

SIZE = (96, 54)
trimesh = pytest.importorskip("trimesh")


# meshes and arrays


@pytest.mark.parametrize("level", range(5))
def test_spheres_are_closed_and_point_outwards(level):
    mesh = sphere(level)
    assert len(mesh.indices) == 20 * 4**level and len(mesh.vertices) == 10 * 4**level + 2
    positions = mesh.vertices[:, :3].astype(np.float64)
    np.testing.assert_allclose(np.linalg.norm(positions, axis=1), 0.5, atol=1e-6)
    a, b, c = positions[mesh.indices].swapaxes(0, 1)
    outward = np.cross(b - a, c - a)
    assert ((outward * (a + b + c)).sum(axis=1) > 0.0).all()
    # What the icosahedron lacks of the ball (its volume is 2.5362 r^3), about a quarter of it with each level.
    lacks = np.pi / 6.0 - (a * np.cross(b, c)).sum() / 6.0
    first = np.pi / 6.0 - 2.53615 / 8.0
    assert 0.9999 * first * 0.24**level < lacks < 1.0001 * first * 0.33**level


def test_a_box_has_six_flat_sides():
    mesh = box()
    a, b, c = mesh.vertices[:, :3].astype(np.float64)[mesh.indices].swapaxes(0, 1)
    normal = mesh.vertices[mesh.indices[:, 0], 3:]
    np.testing.assert_allclose(np.cross(b - a, c - a), normal, atol=1e-6)
    assert (a * np.cross(b, c)).sum() / 6.0 == pytest.approx(1.0)


def test_quaternions_turn():
    half = np.sqrt(0.5)
    quarter = rotation_matrices(np.array([[0.0, 0.0, half, half], [0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 0.0, 5.0]]))
    np.testing.assert_allclose(quarter[0] @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(quarter[1], quarter[0], atol=1e-12)
    np.testing.assert_allclose(quarter[2], np.eye(3))


def test_normals_are_smooth_within_creases_only():
    ball = trimesh.creation.icosphere(subdivisions=3)
    mesh = mesh_of(np.asarray(ball.vertices), np.asarray(ball.faces))
    assert len(mesh.vertices) == len(ball.vertices)
    out = mesh.vertices[:, :3] / np.linalg.norm(mesh.vertices[:, :3], axis=1)[:, None]
    assert (out * mesh.vertices[:, 3:]).sum(axis=1).min() > 0.999
    cube = trimesh.creation.box()
    assert len(mesh_of(np.asarray(cube.vertices), np.asarray(cube.faces)).vertices) == 24


def test_thousands_are_arrays_and_what_is_small_or_aside_is_left_out():
    rng = np.random.default_rng(4)
    count = 3000
    found = [
        (k, (pf.Transform(tuple(p)), pf.Shape(form)))
        for k, (p, form) in enumerate(
            zip(rng.normal(size=(count, 3)) * 500.0 + [6.371e6, 0, 0], ["sphere", "box"] * (count // 2), strict=True)
        )
    ]
    props = read_props(found, load_mesh, GIVEN_NM)
    camera = CameraState.look((6.371e6, 0, 0), (0, 1, 0), (1, 0, 0), fov_y_deg=50)
    seen = seen_by(props, camera, 270, 90.0)
    assert 0 < len(seen.instances) < count and sum(d[3] for d in seen.draws) == len(seen.instances)
    assert len(seen.draws) <= 7
    # By hand: in the pyramid, and its size.
    away = props.positions_m - camera.position_m
    z = away @ camera.forward
    inside = (
        (z > 0) & (np.abs(away @ camera.right) < z * camera.tan_right) & (np.abs(away @ camera.up) < z * camera.tan_top)
    )
    large = 0.5 / np.linalg.norm(away, axis=1) > 0.3 * 2.0 * camera.tan_top / 270
    wanted = {tuple(np.float32(v)) for v in away[inside & large]}
    assert wanted <= {tuple(row["place_m"]) for row in seen.instances}


# in the scene


@pytest.fixture
def scene():
    made = pf.load_scene("moon")
    yield made
    made.release()


def standing(scene, above_m=2.0, pitch_deg=-5.0, latitude=10.0, longitude=20.0):
    return pf.Camera.at(latitude, longitude, above_m, heading_deg=0.0, pitch_deg=pitch_deg, above="ground",
                        planet=scene.planet)  # fmt: skip


def test_handles(scene):
    stone = scene.add(pf.Transform((1.0, 2.0, 3.0)), pf.Shape("box", color=(0.6, 0.2, 0.1)), name="stone")
    assert stone.name == "stone" and scene.props == (stone,)
    assert stone[pf.Shape].form == "box" and pf.Transform in stone
    other = scene.add(pf.Transform())
    positions = np.arange(6.0).reshape(2, 3)
    scene.move(scene.props, positions, [[0, 0, 0, 1], [0, 1, 0, 0]])
    assert stone[pf.Transform].position_m == (0.0, 1.0, 2.0)
    assert other[pf.Transform].orientation == (0.0, 1.0, 0.0, 0.0)
    scene.remove(other)
    assert scene.props == (stone,)
    with pytest.raises(pf.MissingError, match="not in scene"):
        scene.remove(other)


def test_scene_files_keep_props(scene, tmp_path, caplog):
    scene.add(pf.Transform((1.0, 2.0, 3e6), (0.0, 0.0, 1.0, 1.0)), pf.Shape("box", (1.0, 2.0, 3.0)), name="hut")
    scene.save(tmp_path / "a.toml")
    again = pf.load_scene(tmp_path / "a.toml")
    (hut,) = again.props
    assert hut.name == "hut" and hut[pf.Shape] == scene.props[0][pf.Shape]
    assert hut[pf.Transform] == scene.props[0][pf.Transform]
    again.release()
    for text, message in (
        ("props = 3", r"props: expected tables, found 3. Write \[\[props\]\]"),
        ("[[props]]\nshape = {form = 'box', colour = 1}", r"props\[0\].*shape.colour: unknown key.*color"),
        ("[[props]]\nshape = {form = 'hut.obj'}", r"hut.obj: no such mesh file"),
        ("[[props]]\ntransform = {planet = 'venus'}", r"no planet 'venus'"),
    ):
        (tmp_path / "b.toml").write_text(f'base = "moon"\n{text}\n')
        with pytest.raises(pf.SettingError, match=message):
            pf.load_scene(tmp_path / "b.toml")

    class Health:
        pass

    scene.props[0].add(Health())
    with caplog.at_level(logging.WARNING):
        scene.save(tmp_path / "c.toml")
    assert "Health" in caplog.text


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.add(pf.Ocean()), "Ocean belongs to no object of a game's; add it with scene.planet.add"),
        (lambda s: s.planet.add(pf.Shape()), r"Shape belongs to an object of its own: scene\.add"),
        (lambda s: s.add(pf.Transform(planet="venus")), "no planet 'venus'"),
        (lambda s: s.add(pf.Shape("spere")), r"expected 'sphere', 'box' or a mesh file, found 'spere'"),
        (lambda s: s.add(pf.Shape("no/such.obj")), "no such mesh file"),
        (lambda _: pf.Shape(size_m=(1.0, 0.0, 1.0)), r"Shape\.size_m: expected 3 numbers from 0\.0001"),
        (lambda _: pf.Transform((1.0, float("nan"), 0.0)), r"Transform\.position_m: .* Give finite numbers"),
        (lambda _: pf.Transform(orientation=(0.0, 0.0, 0.0, 0.0)), "not all zero"),
        (lambda s: s.move([s.add(pf.Transform())], [[1, 2]]), r"positions_m: expected shape \(1, 3\), found \(1, 2\)"),
        (lambda s: s.move([s.add(pf.Transform())], [[1, 2, np.nan]]), r"positions_m\[0\]: expected finite"),
        (lambda s: s.move([s.add(pf.Transform())], [[1, 2, 3]], [[0, 0, 0, 0]]), r"orientations\[0\] is all zero"),
    ],
)
def test_bad_input_says_what(scene, call, message):
    with pytest.raises(pf.SettingError, match=message):
        call(scene)


def test_mesh_files(tmp_path, monkeypatch):
    for ending in ("obj", "stl", "ply", "glb"):
        trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / f"box.{ending}")
        mesh = load_mesh(str(tmp_path / f"box.{ending}"))
        np.testing.assert_allclose(mesh.high - mesh.low, [1.0, 2.0, 3.0], atol=1e-6)
        assert load_mesh(str(tmp_path / f"box.{ending}")) is mesh
    for name, content, message in (
        ("broken.glb", b"glTF\x02\x00\x00\x00garbage", "can't be read as a mesh"),
        ("noise.ply", bytes(range(256)), "can't be read as a mesh"),
        ("empty.obj", b"# nothing\n", r"can't be read as a mesh|no triangles"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", r"can't be read as a mesh|no triangles"),
        ("nan.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", r"vertex 1 is not finite"),
        ("line.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", r"line.obj: its triangles are all without area"),
        ("what.xyzw", b"123", "can't be read as a mesh"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(MeshError, match=message) as found:
            load_mesh(str(tmp_path / name))
        assert name in str(found.value)
    real_import = builtins.__import__

    def without(name, *rest):
        if name == "trimesh":
            raise ImportError(name)
        return real_import(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    trimesh.creation.box().export(tmp_path / "late.obj")
    with pytest.raises(MeshError, match=r"pip install 'planetfall\[props\]'"):
        load_mesh(str(tmp_path / "late.obj"))


# pictures


@pytest.fixture
def renderer(scene):
    # Edges of shadows are held against rays pixel by pixel.
    with pf.Renderer(scene, SIZE, quality="low", overrides={"terrain.shade_every": 1}) as made:
        yield made


@pytest.mark.gpu
def test_no_props_no_pass_no_object(scene, renderer):
    camera = standing(scene)
    renderer.render(camera)
    assert not any(p.name.startswith("props.") for p in renderer.passes())
    assert "props" not in renderer.gpu.counts()
    stone = scene.add(pf.Transform(tuple(renderer.camera_state(camera).position_m)), pf.Shape())
    renderer.render(camera)
    assert {p.name for p in renderer.passes() if p.name.startswith("props.")} == {
        "props.gbuffer", "props.shadow", "props.tiles", "props.shade", "props.instance",
    }  # fmt: skip
    scene.remove(stone)
    renderer.render(camera)
    assert not any(p.name.startswith("props.") for p in renderer.passes())
    assert renderer.system("props") is None
    assert "props" not in renderer.gpu.counts()


def ahead(renderer, camera, distance_m, aside_m=0.0, above_m=0.0):
    state = renderer.camera_state(camera)
    return state.position_m + state.forward * distance_m + state.right * aside_m + state.up * above_m


@pytest.mark.gpu
@pytest.mark.parametrize("distance_m", [5.0, 2000.0])
def test_a_sphere_is_where_it_says(scene, renderer, distance_m):
    """Against rays and a sphere in numpy; at 2000 m as well as near, so no f32 place on a planet is in it."""
    camera = standing(scene, above_m=900.0, pitch_deg=0.0)
    radius = 0.2 * distance_m
    place = ahead(renderer, camera, distance_m, 0.05 * distance_m)
    scene.add(pf.Transform(tuple(place)), pf.Shape("sphere", (2.0 * radius,) * 3))
    out = renderer.render(camera, outputs=("distance", "normal", "surface", "position"))
    state = renderer.camera_state(camera)
    x = ((np.arange(SIZE[0]) + 0.5) / SIZE[0]) * (state.tan_right - state.tan_left) + state.tan_left
    y = state.tan_top - ((np.arange(SIZE[1]) + 0.5) / SIZE[1]) * (state.tan_top - state.tan_bottom)
    rays = state.forward + x[None, :, None] * state.right + y[:, None, None] * state.up
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    center = place - state.position_m
    b = rays @ center
    d = b * b - (center @ center - radius * radius)
    hit, distance = d > 0.0, b - np.sqrt(np.maximum(d, 0.0))
    drawn = out["surface"] == 3
    pixel = (state.tan_top - state.tan_bottom) / SIZE[1]
    edge = np.abs(d) < (3.0 * pixel * distance_m) * 2.0 * radius  # within some pixels of the outline
    np.testing.assert_array_equal(drawn[~edge], hit[~edge])
    inner = drawn & hit & ~edge
    assert inner.sum() > 100
    # The mesh is off by up to a third of a pixel from the ball; slanting faces show that along the ray.
    np.testing.assert_allclose(out["distance"][inner], distance[inner], atol=2.0 * pixel * distance_m)
    normal = (rays * distance[..., None] - center) / radius
    cosine = (normal * out["normal"]).sum(axis=-1)
    assert cosine[inner].min() > np.cos(np.radians(4.0)), "vertex normals, interpolated and normalised"
    j, i = (int(v) for v in np.argwhere(inner)[len(np.argwhere(inner)) // 2])
    found = renderer.pick(camera, i + 0.5, j + 0.5)
    assert found is not None and found[1] == "props"
    assert np.linalg.norm(found[0] - place) == pytest.approx(radius, rel=0.03)


@pytest.mark.gpu
def test_a_dull_box_has_lamberts_light(scene, renderer):
    """Airless, sun behind the camera: reflectance x irradiance x cosine / pi, less what the surface's gloss takes."""
    camera = standing(scene, above_m=900.0, pitch_deg=0.0)
    state = renderer.camera_state(camera)
    sun = pf.Sun(direction=tuple(-state.forward * 0.8 + state.position_m / np.linalg.norm(state.position_m) * 0.6))
    axes = np.stack([state.right, state.up, -state.forward], axis=1)
    w = 0.5 * np.sqrt(1.0 + np.trace(axes))
    q = np.array([axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]]) / (4.0 * w)
    color = np.array([0.5, 0.3, 0.1])
    scene.add(
        pf.Transform(tuple(ahead(renderer, camera, 10.0)), (*q, w)),
        pf.Shape("box", (4.0, 4.0, 1.0), color=tuple(color), roughness=1.0),
    )
    out = renderer.render(camera, sun=sun, outputs=("radiance", "surface", "normal"))
    j, i = SIZE[1] // 2, SIZE[0] // 2
    assert out["surface"][j, i] == 3
    np.testing.assert_allclose(out["normal"][j, i], -state.forward, atol=1e-3)
    # By hand, for a pixel at the middle: n = v = -forward.
    n_l = float(-state.forward @ np.asarray(sun.direction) / np.linalg.norm(sun.direction))
    half_cosine = np.sqrt(0.5 * (1.0 + n_l))
    fresnel = 0.04 + 0.96 * (1.0 - half_cosine) ** 5
    gloss = fresnel / np.pi * 0.5 / (n_l + 1.0)
    light = reflectance(color, renderer.wavelengths_nm)
    irradiance = carried_sunlight(scene.sun.irradiance, renderer.wavelengths_nm)
    wanted = (light * (1.0 - fresnel) / np.pi + gloss) * n_l * irradiance
    # 8 bits of the colour's square root: 0.8 % at 0.1; light from the ground below comes on top, none from a sky.
    around = 0.2 * 0.6 * 0.5 * light / np.pi * irradiance
    np.testing.assert_allclose(out["radiance"][j, i], wanted + around, rtol=0.02)


def level_place(scene):
    """(latitude, longitude) in degrees with even ground for 20 m to the north."""
    sampler, rng = pf.TerrainSampler(scene), np.random.default_rng(5)
    places = np.stack([rng.uniform(-60.0, 60.0, 400), rng.uniform(-180.0, 180.0, 400)], axis=1)
    north = np.degrees(20.0 / sampler.radius_m) * np.linspace(0.0, 1.0, 9)
    ways = np.array([[pf.direction(a + n, b) for n in north] for a, b in places])
    heights = sampler.height(ways.reshape(-1, 3)).reshape(len(places), -1)
    return places[np.ptp(heights, axis=1).argmin()]


@pytest.mark.gpu
def test_shadows_lie_where_rays_to_the_sun_meet_the_sphere(scene, renderer):
    latitude, longitude = level_place(scene)
    camera = standing(scene, above_m=6.0, pitch_deg=-25.0, latitude=latitude, longitude=longitude)
    state = renderer.camera_state(camera)
    zenith = state.position_m / np.linalg.norm(state.position_m)
    sun = pf.Sun(direction=tuple(0.5 * zenith + 0.85 * state.right))
    toward = np.asarray(sun.direction) / np.linalg.norm(sun.direction)
    bare = renderer.render(camera, sun=sun, outputs=("radiance", "position", "surface"))
    middle = bare["position"][SIZE[1] // 2, SIZE[0] // 2].astype(np.float64)
    center, radius = middle + zenith * 1.0, 1.0
    scene.add(pf.Transform(tuple(state.position_m + center)), pf.Shape("sphere", (2.0 * radius,) * 3))
    out = renderer.render(camera, sun=sun, outputs=("radiance", "position", "surface"))
    ground = (out["surface"] == 1) & (bare["radiance"].sum(axis=-1) > 1e-3 * bare["radiance"].max())
    points = out["position"].astype(np.float64)
    along = (center - points) @ toward
    miss = np.linalg.norm(points + along[..., None] * toward - center, axis=-1)
    share = out["radiance"].sum(axis=-1) / np.maximum(bare["radiance"].sum(axis=-1), 1e-12)
    deep = ground & (along > 0.0) & (miss < 0.8 * radius)
    clear = ground & ((along < 0.0) | (miss > 1.3 * radius)) & (np.linalg.norm(points - center, axis=-1) > 3.2 * radius)
    assert deep.sum() > 15 and clear.sum() > 500
    # No air: what is left is light from around, a few percent.
    assert np.median(share[deep]) < 0.1 and share[deep].max() < 0.5
    np.testing.assert_allclose(share[clear], 1.0, atol=0.01)
    around = ground & (along < 0.0) & (np.linalg.norm(points - center, axis=-1) < 1.5 * radius)
    assert around.sum() == 0 or share[around].max() <= 1.001


@pytest.mark.gpu
def test_props_move_and_still_frames_upload_nothing(scene, renderer):
    camera = standing(scene, above_m=900.0, pitch_deg=0.0)
    stones = [scene.add(pf.Transform(tuple(ahead(renderer, camera, 20.0, k - 5.0))), pf.Shape()) for k in range(10)]
    first = renderer.render(camera, outputs=("surface",))["surface"]
    assert (first == 3).any()
    system = renderer.system("props")
    seen = renderer.views[0].found(system).visible
    assert len(seen.draws) == 1 and seen.draws[0][3] == 10, "one draw for all spheres of a size"
    renderer.render(camera, outputs=("surface",))
    assert renderer.views[0].found(system).visible is seen, "nothing was packed again"
    moved = np.array([ahead(renderer, camera, 20.0, k - 5.0, 3.0) for k in range(10)])
    scene.move(stones, moved)
    second = renderer.render(camera, outputs=("surface",))["surface"]
    rows = [np.argwhere(s == 3)[:, 0].mean() for s in (first, second)]
    assert rows[1] < rows[0] - 3.0


@pytest.mark.gpu
def test_files_are_drawn_and_watched(scene, renderer, tmp_path):
    path = tmp_path / "thing.obj"
    trimesh.creation.box((2.0, 2.0, 2.0)).export(path)
    camera = standing(scene, above_m=900.0, pitch_deg=0.0)
    prop = scene.add(pf.Transform(tuple(ahead(renderer, camera, 10.0))), pf.Shape(str(path)))
    small = (renderer.render(camera, outputs=("surface",))["surface"] == 3).sum()
    trimesh.creation.box((4.0, 4.0, 4.0)).export(path)
    prop[pf.Transform].position_m = tuple(ahead(renderer, camera, 10.0, 0.01))
    large = (renderer.render(camera, outputs=("surface",))["surface"] == 3).sum()
    assert small > 20 and large > 2.5 * small


def test_motion_says_where_each_point_was_a_frame_ago(scene):
    """A box that moves and turns: the texture against its own two poses, in float64."""
    view = standing(scene, 3.0)
    state = CameraState.look(view.position_m, view.forward, view.up, fov_y_deg=view.fov_y_deg)
    middle = state.position_m + 12.0 * state.forward
    shift = 0.3 * state.right + 0.1 * state.up
    turned = (0.0, 0.0, np.sin(0.02), np.cos(0.02))
    before, now = (rotation_matrices(np.array([q]))[0] for q in ((0.0, 0.0, 0.0, 1.0), turned))
    box_ = scene.add(pf.Transform(tuple(middle)), pf.Shape("box", (3.0, 4.0, 5.0)))
    with pf.Renderer(scene, SIZE, "medium", {"composite.antialiasing": "temporal"}) as renderer:
        renderer.settle(view)
        box_[pf.Transform].position_m = tuple(middle + shift)
        box_[pf.Transform].orientation = turned
        out = renderer.render(view, dt_s=0.03, outputs=("position", "surface", "props.motion"))
        shown = out["surface"] == 3
        assert shown.sum() > 300
        from_middle = out["position"][shown].astype(float) + state.position_m - middle - shift
        wanted = from_middle @ (before @ now.T).T - from_middle - shift
        found = out["props.motion"][shown].astype(float)
        assert (found[:, 3] > 0.99).all()
        # Half floats: 2^-11 of 0.5 m; positions: as far off as a float's depth.
        assert np.abs(found[:, :3] - wanted).max() < 0.0005
        # It rests: nothing has moved. Another one comes: it was nowhere.
        still = renderer.render(view, dt_s=0.03, outputs=("surface", "props.motion"))
        assert np.abs(still["props.motion"][still["surface"] == 3][:, :3]).max() == 0.0
        scene.add(pf.Transform(tuple(middle - 4.0 * state.forward)), pf.Shape("sphere", (2.0, 2.0, 2.0)))
        seen = renderer.render(view, dt_s=0.03, outputs=("surface", "props.motion"))
        known = seen["props.motion"][seen["surface"] == 3][:, 3]
        assert (known < 0.01).sum() > 50 and (known > 0.99).sum() > 100
