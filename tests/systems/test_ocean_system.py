"""The sea in the renderer: what runs where, no hole, heights as in float64, pictures of moving water."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.waves import at_directions, displacement, waves_of

pytestmark = pytest.mark.gpu

SIZE = (160, 90)
SEA = 2
OPEN = (24.0, -78.4)


@pytest.fixture(scope="module")
def earth():
    scene = pf.load_scene("earth")
    sun = scene.sun
    sun.elevation_deg, sun.azimuth_deg = 35.0, 230.0
    sun.latitude_deg, sun.longitude_deg = OPEN
    with pf.Renderer(scene, size=SIZE, quality="medium") as made:
        yield made


def over_the_sea(altitude_m, heading_deg=250.0, pitch_deg=-10.0, roll_deg=0.0):
    over = pf.load_scene("earth").planet
    camera = pf.Camera.at(*OPEN, altitude_m, heading_deg=heading_deg, pitch_deg=pitch_deg, planet=over)
    right, up = np.cross(camera.forward, camera.up), np.asarray(camera.up)
    roll = np.radians(roll_deg)
    return pf.Camera(camera.position_m, camera.forward, np.cos(roll) * up + np.sin(roll) * right)


def ran(renderer):
    return {p.name for p in renderer.passes() if p.system == "ocean" and p.ran}


def declared(renderer):
    return {p.name for p in renderer.passes() if p.system == "ocean"}


def test_a_dry_world_has_no_pass_of_the_sea():
    with pf.Renderer(pf.load_scene("moon"), size=SIZE, quality="low") as renderer:
        renderer.render(pf.view("near", "moon"))
        assert not declared(renderer)


def test_waves_are_displaced_where_they_can_be_seen(earth):
    earth.render(over_the_sea(5.0))
    assert "ocean.displace" in ran(earth)
    earth.render(over_the_sea(5.0), time_s=1.0)
    assert "ocean.displace" in ran(earth) and "ocean.vertices" not in ran(earth), "the calm sea stays for a moment"
    earth.render(over_the_sea(5.0), time_s=1.0)
    assert "ocean.displace" not in ran(earth), "nothing has moved"
    earth.render(over_the_sea(400e3, pitch_deg=-40.0), time_s=2.0)
    assert "ocean.displace" not in declared(earth), "no displacement is a quarter of a pixel"
    assert "ocean.surface" in ran(earth)


def test_a_smooth_sea_is_not_displaced():
    scene = pf.load_scene("earth")
    scene.planet[pf.Ocean].wind_speed_m_s = scene.planet[pf.Ocean].swell_height_m = 0.0
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        renderer.render(over_the_sea(5.0))
        assert "ocean.displace" not in declared(renderer)


def test_only_what_can_be_seen_is_displaced(earth):
    earth.render(over_the_sea(5.0), time_s=3.0)
    found = earth.stats
    assert 0 < found["cells"] < 0.6 * found["cells_selected"]


@pytest.mark.parametrize("altitude_m", [1.5, 5.0, 60.0, 3000.0])
def test_no_hole(earth, altitude_m):
    """Below the horizon each pixel shows something, in waves, at any roll and moment."""
    rng = np.random.default_rng(int(altitude_m * 10))
    for _ in range(6):
        camera = over_the_sea(altitude_m, rng.uniform(0, 360), rng.uniform(-60, 5), rng.uniform(-60, 60))
        shown = earth.render(camera, time_s=float(rng.uniform(0, 1e6)), outputs=("surface",))["surface"]
        state = earth.camera_state(camera)
        x = np.linspace(state.tan_left, state.tan_right, SIZE[0] + 1)
        y = np.linspace(state.tan_top, state.tan_bottom, SIZE[1] + 1)
        x, y = 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1])
        rays = state.forward + x[None, :, None] * np.cross(state.forward, state.up) + y[:, None, None] * state.up
        rays /= np.linalg.norm(rays, axis=2, keepdims=True)
        distance = np.linalg.norm(state.position_m)
        zenith = state.position_m / distance
        # Troughs and the curve of chords: half a pixel and the waves' height lower than the horizon of the calm sea.
        radius = distance - altitude_m - 6.0
        dip = np.arccos(min(radius / distance, 1.0)) + 0.5 * (y[0] - y[1])
        below = rays @ zenith < -np.sin(dip)
        assert not np.any(below & (shown == 0))


def f64_error(renderer, camera, time_s, reach_m):
    """Metres between drawn points of the sea within reach, and the nearest height of the float64 sea there."""
    out = renderer.render(camera, time_s=time_s, outputs=("position", "surface"))
    near = (out["surface"] == SEA) & (np.linalg.norm(out["position"], axis=2) < reach_m)
    points = renderer.camera_state(camera).position_m + out["position"][near].astype(np.float64)
    waves = renderer.system("ocean").method.view(renderer.views[0]).waves.waves
    distance = np.linalg.norm(points, axis=1)
    calm, _, moved = at_directions(waves, points / distance[:, None], np.full(len(points), time_s))
    true = np.linalg.norm(calm * waves.radius_m + moved, axis=1)
    return distance - true, near.sum()


def test_the_sea_is_drawn_where_float64_has_it(earth):
    """Near the camera only waves shorter than the mesh shows are missing: centimetres."""
    for time_s in (0.0, 1e5, 1e8):
        off, count = f64_error(earth, over_the_sea(4.0, pitch_deg=-35.0), time_s, 12.0)
        assert count > 2000
        assert np.abs(off).max() < 0.05
        assert np.sqrt(np.mean(off**2)) < 0.02


def test_cells_agree_on_the_vertices_that_they_share(earth):
    """To the last bit, in waves: or there would be cracks between them."""
    earth.render(over_the_sea(5.0), time_s=12345.0)
    system = next(s for s in earth.systems if s.name == "ocean")
    sea = system.method.view(earth.views[0])
    rows = sea.mesh.read_visible()
    calm = sea.mesh.read_vertices()[rows]["position_m"]
    size = sea.mesh.count * sea.mesh.vertices_per_cell
    kind = np.dtype([("position_m", "f4", 3), ("moved", "u4"), ("normal", "u4"), ("attributes", "u4")])
    wavy = np.frombuffer(earth.graph.resource("ocean.displaced").read(size * kind.itemsize), kind)
    wavy = wavy.reshape(sea.mesh.count, -1)[rows]["position_m"]
    cells = sea.mesh.read_cells()[rows]
    skips = cells["variant"] >> 1
    side = sea.mesh.quads + 1
    b, a = np.divmod(np.arange(side * side), side)
    used = (a % (1 << (skips // 4))[:, None] == 0) & (b % (1 << (skips % 4))[:, None] == 0)
    _, first, shared = np.unique(calm[used], axis=0, return_index=True, return_inverse=True)
    assert len(first) < used.sum() - 500, "hundreds of vertices are shared"
    assert np.array_equal(wavy[used], wavy[used][first][shared.reshape(-1)])


def test_a_still_picture_of_a_moment_and_the_next_moment(earth):
    """Settled water is held; a moment later it is another picture."""
    camera = over_the_sea(5.0)
    earth.settle(camera, time_s=5.0)
    held = earth.render(camera, time_s=5.0)["color"]
    assert np.array_equal(held, earth.render(camera, time_s=5.0)["color"])
    later = earth.render(camera, time_s=6.0)["color"]
    assert np.abs(held.astype(int) - later.astype(int)).max() > 30
    earth.settle(camera, time_s=5.0)
    assert np.array_equal(held, earth.render(camera, time_s=5.0)["color"])


def test_moving_water_is_not_smeared(earth):
    """Frames of a sequence, temporally anti-aliased, show the water of now: much nearer to the settled picture of this
    moment than the water of a tenth of a second ago is."""
    camera = over_the_sea(5.0)

    def settled(time_s):
        earth.settle(camera, time_s=time_s)
        return earth.render(camera, time_s=time_s)["color"].astype(float)

    now, before = settled(20.0), settled(19.9)
    for k in range(12):
        shown = earth.render(camera, time_s=20.0 - (11 - k) / 30.0, dt_s=1.0 / 30.0)["color"].astype(float)
    sea = earth.render(camera, time_s=20.0, outputs=("surface",))["surface"] == SEA
    off, lag = (np.sqrt(np.mean((picture[sea] - now[sea]) ** 2)) for picture in (shown, before))
    assert off < 0.35 * lag


@pytest.mark.parametrize("method", ["paper_2018", "paper_2019"])
def test_the_printed_sea(method):
    """Rings around an origin, straight crests a quarter turn away; every pixel is covered."""
    scene = pf.load_scene("earth")
    sea = scene.planet[pf.Ocean]
    sea.method = method
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        out = renderer.render(over_the_sea(5.0, pitch_deg=-30.0), time_s=3.0, outputs=("surface", "normal"))
        assert "ocean.surface" not in declared(renderer)
        assert np.all(out["surface"][SIZE[1] // 2 :] == SEA)
        tilt = np.degrees(np.arccos(np.clip(out["normal"] @ pf.direction(*OPEN), -1, 1)))[SIZE[1] // 2 :]
        assert 1.0 < tilt.max() < 40.0


def test_no_wave_where_there_is_no_depth():
    """At the shore the sea stands at its level: the coast line is where terrain.coast draws it."""
    waves = waves_of(pf.Ocean(), 6.371e6)
    v = pf.direction(*OPEN)[None]
    assert np.abs(displacement(waves, v, 5.0, np.zeros(1))).max() == 0.0
