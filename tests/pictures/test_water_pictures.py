"""Water as it is drawn: the waterline, Snell's window, mirrored ground, wet sand and what dry worlds pay."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf

pytestmark = pytest.mark.gpu

SIZE = (128, 72)
PLACE = (3.16545, 143.60915)  # 12 m of water, a beach ahead
OUTPUTS = ("radiance", "position", "surface")


@pytest.fixture(scope="module")
def scene():
    with pf.load_scene("earth") as made:
        ocean = made.planet[pf.Ocean]
        ocean.wind_speed_m_s = ocean.swell_height_m = 0.0
        made.sun.elevation_deg, made.sun.azimuth_deg = 60.0, 200.0
        made.sun.latitude_deg, made.sun.longitude_deg = PLACE
        yield made


@pytest.fixture(scope="module")
def renderer(scene):
    with pf.Renderer(scene, SIZE, "low", overrides={"composite.antialiasing": "none"}) as made:
        yield made


def camera(altitude_m: float, pitch_deg: float, fov_y_deg: float = 60.0) -> pf.Camera:
    return pf.Camera.at(*PLACE, altitude_m, heading_deg=240.0, pitch_deg=pitch_deg, fov_y_deg=fov_y_deg)


@pytest.mark.parametrize("altitude_m", [0.03, 0.012, -0.004, -0.03])
def test_the_waterline_has_no_hole(renderer, altitude_m):
    """On a calm sea the line is known: the near plane, 0.1 m away, meets it where rays have fallen by the altitude."""
    seen = camera(altitude_m, pitch_deg=0.0)
    renderer.settle(seen)
    out = renderer.render(seen, outputs=OUTPUTS)
    rows = (np.arange(SIZE[1]) + 0.5 - SIZE[1] / 2.0) / (SIZE[1] / 2.0) * np.tan(np.radians(30.0))  # downwards
    below_px = (rows * 0.1 - altitude_m) / (0.1 * 2.0 * np.tan(np.radians(30.0)) / SIZE[1])
    up = pf.direction(*PLACE)
    height = altitude_m + np.nan_to_num(out["position"] @ up)
    under, over = below_px > 3.0, below_px < -3.0
    assert under.any() and over.any()
    # Under water nothing is seen but what lies in it; over it never its bed.
    assert (height[under] < 0.05).all() and (out["surface"][under] != 0).all()
    bed = (out["surface"] == 1) & (height < -1.0)
    assert not bed[over].any(), "a hole between the water's edge and the lens"
    red, blue = out["radiance"][under][..., 0], out["radiance"][under][..., 2]
    assert (blue > 2.0 * red).all(), "seen through water"


def test_snells_window(renderer):
    seen = camera(-6.0, pitch_deg=90.0, fov_y_deg=140.0)
    renderer.settle(seen)
    out = renderer.render(seen, outputs=OUTPUTS)
    cosine = out["position"] @ pf.direction(*PLACE) / np.linalg.norm(out["position"], axis=-1)
    angle = np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
    blue = out["radiance"][..., 2]
    # The critical angle of water is 48.6 degrees: all of the sky lies inside, beyond it the water sees itself.
    inside, outside = blue[angle < 45.0], blue[(angle > 54.0) & (angle < 65.0)]
    assert np.median(inside) > 2.0 * np.median(outside)


def test_light_fades_with_depth(renderer):
    seen = []
    for depth_m in (2.0, 6.0, 12.0):
        # Out to sea, where there is water alone.
        view = pf.Camera.at(23.99927, -78.37434, -depth_m, heading_deg=240.0, fov_y_deg=3.0)
        renderer.settle(view)
        seen.append(renderer.render(view, outputs=("radiance",))["radiance"].mean(axis=(0, 1)))
    assert (seen[0] > seen[1]).all() and (seen[1] > seen[2]).all()
    lost = seen[2] / seen[0]
    assert lost[0] < lost[1] < lost[2], "red goes first, blue last"


def test_calm_water_mirrors_the_hills(scene):
    view = pf.view("beach")
    found = []
    for turns in (0, 32):
        overrides = {"ocean.reflections": turns, "composite.antialiasing": "none"}
        with pf.Renderer(scene, (160, 90), "low", overrides=overrides) as made:
            made.settle(view)
            out = made.render(view, outputs=OUTPUTS)
            found.append(out["radiance"].astype(float))
    sea = out["surface"] == 2
    changed = np.abs(found[1] - found[0]).max(axis=-1) > 0.02 * found[0].max()
    assert changed[sea].mean() > 0.1, "hills that the picture shows"
    assert not changed[~sea].any()
    # Hills are darker than the sky that stands in for them.
    assert found[1][changed].mean() < found[0][changed].mean()


def test_a_beach_is_wet_where_waves_run_up(scene):
    ocean, view = scene.planet[pf.Ocean], pf.view("shallows")
    pictures, before = [], ocean.surf_m
    try:
        with pf.Renderer(scene, (160, 90), "low", overrides={"composite.antialiasing": "none"}) as made:
            for ocean.surf_m in (0.0, 0.8):
                made.settle(view)
                out = made.render(view, outputs=OUTPUTS)
                pictures.append(out["radiance"].astype(float))
    finally:
        ocean.surf_m = before
    land = out["surface"] == 1
    changed = np.abs(pictures[1] - pictures[0]).max(axis=-1) > 0.01 * pictures[0].max()
    assert 0.0 < changed[land].mean() < 0.5, "a band along the shore"


@pytest.mark.parametrize("planet", ["mars", "earth"])
def test_without_sea_nothing_of_it_runs(planet):
    with pf.load_scene(planet) as dry:
        if pf.Ocean in dry.planet:
            dry.planet.remove(pf.Ocean)
        with pf.Renderer(dry, (64, 36), "low") as made:
            made.render(pf.view("near", planet))
            assert not [p.name for p in made.passes() if p.name.startswith("ocean")]


def test_a_dry_view_pays_for_no_water_before_the_lens(renderer):
    for _ in range(2):  # in a picture's first frame what a pass keeps is made, whoever needs it
        renderer.render(camera(500.0, pitch_deg=-10.0))
    ran = {p.name: p.ran for p in renderer.passes()}
    assert not ran["ocean.under"]
    renderer.render(camera(-1.0, pitch_deg=0.0))
    assert {p.name: p.ran for p in renderer.passes()}["ocean.under"]
