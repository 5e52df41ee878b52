"""A host's world on a planet: its matrices and depths against pyglet's and glm's own; pictures that share a depth."""

from __future__ import annotations

import math
from collections.abc import Iterator

import moderngl
import numpy as np
import pytest
from numpy.typing import NDArray
from pyglet.math import Mat4, Vec3
from pyglm import glm

import planetfall as pf
from planetfall.engine.hosts.headless import create_headless
from planetfall.engine.space import project

SIZE = (120, 80)


@pytest.fixture(scope="module")
def earth() -> Iterator[pf.PlanetHandle]:
    with pf.load_scene("earth") as scene:
        yield scene.planet


@pytest.fixture(scope="module")
def space(earth: pf.PlanetHandle) -> pf.HostSpace:
    return pf.HostSpace.at(12.0, 34.0, 250.0, 70.0, unit_m=2.0, planet=earth)


def host_pixels(view: object, lens: object, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels as the host's own vertex shader would place them, row 0 on top."""
    world = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    clip = world @ np.asarray(view, np.float64).T @ np.asarray(lens, np.float64).T
    ndc = clip[:, :2] / clip[:, 3:]
    return np.stack([(0.5 + 0.5 * ndc[:, 0]) * SIZE[0], (0.5 - 0.5 * ndc[:, 1]) * SIZE[1]], axis=1)


def test_axes_stand_upright(space: pf.HostSpace, earth: pf.PlanetHandle) -> None:
    up = pf.direction(12.0, 34.0)
    np.testing.assert_allclose(space.to_planet((0, 0, 0)), up * (6.371e6 + 250.0), rtol=1e-12)
    np.testing.assert_allclose(space.direction_to_planet((0, 1, 0)), up, atol=1e-12)
    ahead = pf.Camera.at(12.0, 34.0, 0.0, heading_deg=70.0).forward
    np.testing.assert_allclose(space.direction_to_planet((0, 0, -1)), ahead, atol=1e-12)
    sideways = pf.HostSpace.at(12.0, 34.0, 0.0, 70.0, up="z", planet=earth)
    np.testing.assert_allclose(sideways.direction_to_planet((0, 0, 1)), up, atol=1e-12)
    np.testing.assert_allclose(sideways.direction_to_planet((0, 1, 0)), ahead, atol=1e-12)
    assert np.linalg.norm(space.to_planet((0, 3, 0)) - space.to_planet((0, 0, 0))) == pytest.approx(6.0)
    points = np.random.default_rng(1).normal(size=(50, 3)) * 1e3
    np.testing.assert_allclose(space.to_host(space.to_planet(points)), points, atol=1e-8)
    np.testing.assert_allclose(space.direction_to_host(space.direction_to_planet(points)), points, atol=1e-9)


@pytest.mark.parametrize("library", ["pyglet", "glm"])
def test_a_camera_sees_what_the_hosts_sees(space: pf.HostSpace, earth: pf.PlanetHandle, library: str) -> None:
    """Points of the host's world land on the same pixels through its matrices and through the planet's camera."""
    eye, to = (3.0, 2.0, 5.0), (0.0, 1.0, -20.0)
    if library == "pyglet":
        view = Mat4.look_at(Vec3(*eye), Vec3(*to), Vec3(0.0, 1.0, 0.0))
        lens = Mat4.perspective_projection(SIZE[0] / SIZE[1], 0.1, 500.0, 48.0)
        as_matrix = [np.asarray(m).reshape(4, 4).T for m in (view, lens)]
    else:
        view = np.array(glm.lookAt(glm.dvec3(eye), glm.dvec3(to), glm.dvec3(0, 1, 0)))
        lens = np.array(glm.frustum(-0.1, 0.25, -0.05, 0.12, 0.2, 300.0))  # off the axis
        as_matrix = [view, lens]
    points = np.random.default_rng(2).uniform((-9, -3, -40), (9, 6, -8), (200, 3))
    state = space.camera(view, lens).resolve(earth.scene)
    found, front = project(state, space.to_planet(points), SIZE)
    assert front.all()
    # pyglet's matrices and glm's frustum may be single: 1e-7 of numbers of a hundred pixels, with room.
    np.testing.assert_allclose(found, host_pixels(*as_matrix, points), atol=2e-4)
    # And back: the planet's camera as matrices for the host.
    view_again, lens_again = space.matrices(state, 0.1, 500.0)
    np.testing.assert_allclose(host_pixels(view_again, lens_again, points), found, atol=1e-6)


@pytest.mark.parametrize("far", [500.0, math.inf])
@pytest.mark.parametrize("zero_to_one", [False, True])
def test_depths_are_those_of_the_projection(far: float, zero_to_one: bool, earth: pf.PlanetHandle) -> None:
    space = pf.HostSpace.at(0.0, 0.0, unit_m=3.0, planet=earth)
    z = np.array([0.2, 1.0, 7.0, 100.0, 450.0])  # in the host's unit
    if zero_to_one:  # reversed, as a careful host has it: near / z
        lens = np.diag([1.0, 1.0, 0.0, 0.0])
        lens[2, 3], lens[3, 2] = 0.2, -1.0
        wanted, depth = 0.2 / z, space.depth(lens, zero_to_one=True)
        assert depth.reversed
    else:
        _, lens = space.matrices(pf.Camera.at(0, 0, 10.0).resolve(pf.load_scene("earth")), 0.2, far)
        clip = lens @ np.stack([z * 0, z * 0, -z, z * 0 + 1])
        wanted, depth = clip[2] / clip[3] * 0.5 + 0.5, space.depth(lens)
        assert not depth.reversed
    np.testing.assert_allclose(depth.window_depth(3.0 * z), wanted, atol=1e-12)
    assert depth.window_depth(np.inf) == pytest.approx(0.0 if depth.reversed else 1.0, abs=1e-12)


def test_bad_input_is_named(space: pf.HostSpace, earth: pf.PlanetHandle) -> None:
    lens = np.array(glm.perspective(1.0, 1.5, 0.1, 100.0))
    with pytest.raises(pf.CameraError, match="transpose"):
        space.camera(np.eye(4), lens.T)
    with pytest.raises(pf.CameraError, match="parallel projection"):
        space.camera(np.eye(4), np.eye(4))
    moved = np.array(glm.lookAt(glm.vec3(1, 2, 3), glm.vec3(0), glm.vec3(0, 1, 0)))
    with pytest.raises(pf.CameraError, match="transpose"):
        space.camera(moved.T, lens)
    with pytest.raises(pf.CameraError, match="scale into unit_m"):
        space.camera(np.diag([2.0, 2.0, 2.0, 1.0]), lens)
    with pytest.raises(pf.CameraError, match="4 x 4"):
        space.camera(np.eye(3), lens)
    with pytest.raises(pf.CameraError, match=r"planet=scene\.planet"):
        pf.HostSpace((7e6, 0.0, 0.0), np.eye(3)).on_surface([(0, 0, 0)])
    for planet in (None, "moon"):  # whose radius?
        with pytest.raises(pf.CameraError, match=r"planet: expected one of a scene.*planet=scene\.planet"):
            pf.HostSpace.at(0, 0, 10, planet=planet)  # type: ignore[arg-type]
    with pytest.raises(pf.CameraError, match="'y' or 'z'"):
        pf.HostSpace.at(0, 0, up="x", planet=earth)
    with pytest.raises(pf.CameraError, match="far"):
        space.matrices(pf.Camera.at(0, 0, 10.0).resolve(pf.load_scene("earth")), 1.0, 0.5)


def test_points_on_the_surface() -> None:
    scene = pf.load_scene("moon")
    space = pf.HostSpace.at(10.0, 20.0, 0.0, above="ground", planet=scene.planet)
    stood = space.to_planet(space.on_surface([(0, 50, 0), (400, 0, -900)], height_m=2.0))
    up = stood / np.linalg.norm(stood, axis=1, keepdims=True)
    ground = pf.TerrainSampler(scene).height(up)
    np.testing.assert_allclose(np.linalg.norm(stood, axis=1) - scene.planet.radius_m, ground + 2.0, atol=1e-6)
    np.testing.assert_allclose(space.on_surface([(0, 50, 0)]), [(0, 0, 0)], atol=1e-6)


# -- pictures ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ctx() -> Iterator[moderngl.Context]:
    made = create_headless()
    yield made
    assert made.error == "GL_NO_ERROR"
    made.release()


WALL = """#version 330 core
uniform mat4 u_lens; uniform float u_z;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    gl_Position = u_lens * vec4(corner * u_z, -u_z, 1.0);
}"""
RED = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(1.0, 0.0, 0.0, 1.0); }"


@pytest.mark.gpu
@pytest.mark.parametrize("before", [True, False])
def test_a_wall_hides_what_is_behind_it_and_nothing_else(ctx: moderngl.Context, before: bool) -> None:
    """A wall across the view, drawn before the planet or after it: the same picture, red where the planet's own
    distance is larger and the planet elsewhere."""
    scene = pf.load_scene("moon")
    camera = pf.Camera.at(10.0, 20.0, 30.0, 0.0, -20.0, above="ground")
    target = ctx.framebuffer([ctx.texture(SIZE, 4)], ctx.depth_renderbuffer(SIZE))
    program = ctx.program(vertex_shader=WALL, fragment_shader=RED)
    wall = ctx.vertex_array(program, [])
    space = pf.HostSpace.at(10.0, 20.0, planet=scene.planet)
    with pf.Renderer(scene, SIZE, "low", {"composite.antialiasing": "none"}, ctx=ctx) as renderer:
        state = renderer.camera_state(camera)
        out = renderer.render(camera, outputs=("color", "position"))
        z = np.nan_to_num(out["position"] @ state.forward.astype(np.float32), nan=np.inf)
        wall_m = float(np.median(z[np.isfinite(z)]))
        _, lens = space.matrices(state, 0.5, 5e3)
        program["u_lens"], program["u_z"] = lens.T.ravel(), wall_m

        def draw_wall() -> None:
            target.use()
            ctx.enable_only(moderngl.DEPTH_TEST)
            wall.render(moderngl.TRIANGLE_STRIP, 4)

        target.clear(depth=1.0)
        if before:
            draw_wall()
        renderer.render_to(target, camera, depth=space.depth(lens))
        if not before:
            draw_wall()
        assert ctx.error == "GL_NO_ERROR"
    picture = np.frombuffer(target.read(components=3), np.uint8).reshape(SIZE[1], SIZE[0], 3)[::-1].astype(int)
    red = (picture[..., 0] > 200) & (picture[..., 1] < 20)
    # 24 bits from 0.5 m on resolve 1e-7 z^2 / 0.5 m: pixels nearer to the wall than that may go either way.
    sure = np.abs(z - wall_m) > 0.1
    assert red.sum() > 500 and (~red).sum() > 500
    np.testing.assert_array_equal(red[sure], (z > wall_m)[sure])
    np.testing.assert_allclose(picture[~red & sure], out["color"][~red & sure], atol=1)
    target.release()


@pytest.mark.gpu
def test_the_sun_of_a_host(ctx: moderngl.Context) -> None:
    scene = pf.load_scene("earth")
    scene.sun = pf.Sun(direction=(0.0, 0.0, 2.0))
    np.testing.assert_allclose(pf.sun_direction(scene), (0, 0, 1))
    own = pf.sun_direction(scene, camera=pf.view("valley"))
    up = pf.direction(2.83187, 146.012)
    assert math.degrees(math.asin(own @ up)) == pytest.approx(25.0, abs=1e-6)
    with pytest.raises(pf.SettingError):
        pf.sun_direction(scene, math.nan)
