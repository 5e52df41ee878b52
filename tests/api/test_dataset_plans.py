"""Plans of data sets with flights, and with knobs of components that change from frame to frame."""

from __future__ import annotations

import json

import numpy as np
import pytest

import planetfall as pf
from planetfall.capture.dataset_plan import read_plan
from planetfall.capture.dataset_stage import Stage
from planetfall.cli.main import main

SMALL = 'seed = 3\ncount = 4\nsize = [64, 36]\nquality = "low"\nscene = "mars"\noutputs = ["color", "depth"]\n'
KNOBS = """
[overrides]
"terrain.edge_px" = 8.0
terrain.craters = { uniform = [0.0, 1.0] }
terrain.seed = { choice = [3, 4] }
atmosphere.mie_asymmetry = { normal = [0.6, 0.1] }
exposure.brighter_s = { log = [0.5, 2.0] }
"""


@pytest.fixture
def written(tmp_path):
    def write(text: str):
        (tmp_path / "plan.toml").write_text(text)
        return tmp_path / "plan.toml"

    return write


def sums(root):
    told = [json.loads(line) for line in (root / "frames.jsonl").read_text().splitlines()]
    return {name: file["sha256"] for each in told for name, file in each["files"].items()}, told


def test_knobs_are_drawn_by_frame_and_seed(written):
    plan = read_plan(written(SMALL.replace("count = 4", "count = 200") + KNOBS))
    assert plan.overrides == {"terrain.edge_px": 8.0} and len(plan.varied) == 4
    drawn = [plan.frame(n).knobs for n in range(200)]
    assert plan.frame(7).knobs == drawn[7] and plan.frame(7).values["terrain.seed"] in (3, 4)
    craters = np.array([each["terrain.craters"] for each in drawn])
    assert 0.0 <= craters.min() < 0.05 and 0.95 < craters.max() <= 1.0
    assert {each["terrain.seed"] for each in drawn} == {3, 4}
    haze = np.array([each["atmosphere.mie_asymmetry"] for each in drawn])
    assert abs(haze.mean() - 0.6) < 0.03 and abs(haze.std() - 0.1) < 0.02
    # Another knob leaves what the others draw.
    text = SMALL.replace("count = 4", "count = 200") + KNOBS + "terrain.hills = { uniform = [0.0, 1.0] }\n"
    more = read_plan(written(text)).frame(7).knobs
    assert {k: v for k, v in more.items() if k != "terrain.hills"} == drawn[7]


@pytest.mark.gpu
def test_frames_with_knobs_are_the_same_in_any_order(written, tmp_path):
    plan = written(SMALL + KNOBS)
    one, told = sums(pf.dataset(plan, tmp_path / "one"))
    assert len({each["drawn"]["terrain.craters"] for each in told}) == 4
    two = tmp_path / "two"
    for frames in ([3, 1], [2], [0]):
        pf.dataset(plan, two, frames=frames)
    assert sums(two)[0] == one


@pytest.mark.gpu
def test_grounds_that_change_have_their_own_rivers_and_weather(written, tmp_path):
    """In any order: the last ground's rivers are not those of the next, and no cloud stays behind."""
    earth = SMALL.replace('"mars"', '"earth.toml"').replace("count = 4", "count = 3")
    clouds = "[[clouds.layers]]\nbase_m = 1500.0\n"
    (tmp_path / "earth.toml").write_text(f'base = "earth"\n[terrain]\ndrainage_cells = 6000\n{clouds}')
    plan = written(f"{earth}[overrides]\nterrain.hills = {{ uniform = [0.0, 1.0] }}\n[camera]\naltitude_m = 200.0\n")
    one = sums(pf.dataset(plan, tmp_path / "one"))[0]
    for frames in ([2], [1, 0]):
        pf.dataset(plan, tmp_path / "two", frames=frames)
    assert sums(tmp_path / "two")[0] == one


@pytest.mark.gpu
def test_a_flight(written, tmp_path):
    with pf.load_scene("mars") as scene:
        flight = pf.path("low", scene)
        times, cameras = flight.times_s(4), [flight.camera_at(t) for t in flight.times_s(4)]
    plan = written(SMALL + 'path = "low"\n')
    one, told = sums(pf.dataset(plan, tmp_path / "one"))
    assert [each["time_s"] for each in told] == times
    for each, camera in zip(told, cameras, strict=True):
        np.testing.assert_allclose(each["camera"]["position_m"], camera.position_m, atol=1e-6)
    two = pf.dataset(plan, tmp_path / "two", frames=[2])
    assert sums(two)[0].items() <= one.items()
    assert json.loads((tmp_path / "one" / "transforms.json").read_text())["frames"]


def test_a_flight_with_a_sun_a_time_and_a_lens_of_the_plans_own(written, tmp_path):
    pf.Intrinsics(64, 36, 50.0, 50.0, 31.5, 17.5).save(tmp_path / "lens.yml")
    more = 'time_s = 5.0\npath = "mine"\npaths = "mine.toml"\nintrinsics = "lens.yml"\n[sun]\nelevation_deg = 20.0\n'
    start = "latitude_deg = 0.0\nlongitude_deg = 0.0\n"
    keys = "keys = [{ time_s = 0.0, altitude_m = 1e3 }, { time_s = 9.0, altitude_m = 1e3, away_deg = 1.0 }]\n"
    (tmp_path / "mine.toml").write_text(f'[path.mine]\nkind = "keys"\n{start}{keys}')
    plan = read_plan(written(SMALL + more))
    with plan.scene("mars") as scene:
        frame = Stage(plan, scene).frame(plan.frame(3))
        assert frame.time_s == 5.0 and frame.camera.intrinsics == plan.intrinsics
        assert frame.sun is not None and frame.sun.elevation_deg == 20.0
        assert abs(frame.sun.latitude_deg) + abs(frame.sun.longitude_deg) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (
            "[overrides]\nterrain.erosoin = { uniform = [0.0, 1.0] }",
            r"terrain\.erosoin: no such knob; did you mean.*erosion",
        ),
        ("[overrides]\nterrain.erosoin = 1.0", r"terrain\.erosoin.*did you mean"),
        ("[overrides]\nterrain.edge_px = { uniform = [4.0, 8.0] }", "a knob of quality has one value"),
        (
            "[overrides]\nterrain.craters = { uniform = [0.0, 9.0] }",
            r"terrain\.craters: uniform: expected a number from",
        ),
        ("[overrides]\nterrain.craters = { uniform = [1.0, 0.0] }", "lower number first"),
        ("[overrides]\nterrain.craters = { gauss = [1.0, 0.0] }", "expected a value, or one of"),
        ("[overrides]\nterrain.seed = { uniform = [0.5, 1e12] }", r"terrain\.seed: uniform: expected a whole number"),
        ('[overrides]\nterrain.backend = { choice = ["grid", "gird"] }', "did you mean 'grid'"),
        ("[overrides]\nterrain.shadows = { uniform = [0, 1] }", "choice"),
        ("[overrides]\nocean.sea_level_m = { uniform = [0.0, 1.0] }", r"scene 'mars' has no Ocean"),
        ("[overrides]\nterrain.highest_m = { choice = [-15000.0] }", r"frame \d.*lowest_m"),
        ("[overrides]\nsun.elevation_deg = { uniform = [1.0, 9.0] }", r"sun\.elevation_deg.*of \[sun\] say"),
        ("[overrides]\nsun.direction = [1.0, 0.0, 0.0]", r"sun\.direction.*of \[sun\] say"),
        ('path = "lo"', "unknown path 'lo': did you mean 'low'"),
        ('paths = "x.toml"', "name the one to take"),
        ('path = "low"\npaths = "x.toml"', "no such file"),
        ('path = "low"\n[camera]\naltitude_m = 3.0', "brings its cameras"),
    ],
)
def test_what_is_wrong_is_told_before_any_drawing(written, tmp_path, monkeypatch, text, match):
    monkeypatch.setattr("planetfall.render.renderer.Renderer", None)
    with pytest.raises(pf.PresetError, match=match):
        pf.dataset(written(SMALL + text), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("time_s = 1e30", r"time_s: expected a number from -1e\+15 to 1e\+15"),
        (f"time_s = 1{'0' * 400}", r"time_s: expected a number from -1e\+15 to 1e\+15"),
        ("[camera]\nlatitude_deg = 200.0", "latitude_deg: expected a number from -90 to 90, found 200"),
        ("[camera]\nlatitude_deg = { area = [-200.0, 200.0] }", "latitudes from -90 to 90"),
        (
            "[camera]\nfov_y_deg = { uniform = [10.0, 200.0] }",
            "fov_y_deg: uniform: expected a number from 0.001 to 179",
        ),
        ("[camera]\naltitude_m = -500.0", r"altitude_m: expected a number from 0 to 1e\+10"),
        ("[camera]\naltitude_m = { normal = [9.0, -1.0] }", "a deviation from 0 on"),
        ("[sun]\nelevation_deg = { choice = [400.0] }", "elevation_deg: choice: expected a number from -90 to 90"),
        ('intrinsics = "lens.yml"\n[camera]\nfov_y_deg = 40.0', "the lens of intrinsics has its own"),
    ],
)
def test_numbers_out_of_range_are_told_when_the_plan_is_read(written, tmp_path, text, match):
    pf.Intrinsics(64, 36, 50.0, 50.0, 31.5, 17.5).save(tmp_path / "lens.yml")
    with pytest.raises(pf.PresetError, match=match):
        read_plan(written(SMALL + text))


def test_normal_numbers_stay_in_range_and_a_lens_has_no_angle(written, tmp_path):
    camera = "[camera]\naltitude_m = { normal = [10.0, 500.0] }\npitch_deg = { normal = [-80.0, 20.0] }\n"
    plan = read_plan(written(SMALL.replace("count = 4", "count = 200") + camera))
    drawn = [plan.frame(n).values for n in range(200)]
    assert min(each["camera.altitude_m"] for each in drawn) == 0.0
    assert min(each["camera.pitch_deg"] for each in drawn) == -90.0
    pf.Intrinsics(64, 36, 50.0, 50.0, 31.5, 17.5).save(tmp_path / "lens.yml")
    with_lens = read_plan(written(SMALL + 'intrinsics = "lens.yml"\n'))
    assert "camera.fov_y_deg" in drawn[0] and "camera.fov_y_deg" not in with_lens.frame(0).values


@pytest.mark.parametrize("camera", ["", 'path = "mine"\npaths = "mine.toml"\n'])
def test_suns_have_the_light_of_the_scene_and_of_the_plan(written, tmp_path, camera):
    """Strength and disc are the scene's, or what the plan overrides them with, wherever the sun stands."""
    (tmp_path / "far.toml").write_text('base = "mars"\n[sun]\nirradiance = [0.1, 0.2, 0.3]\nelevation_deg = 1.0\n')
    keys = "keys = [{ time_s = 0.0, altitude_m = 1e3 }, { time_s = 9.0, altitude_m = 1e3, away_deg = 1.0 }]\n"
    place = "latitude_deg = 0.0\nlongitude_deg = 0.0\nsun = { elevation_deg = 30.0 }\n"
    (tmp_path / "mine.toml").write_text(f'[path.mine]\nkind = "keys"\n{place}{keys}')
    for own in ("", "[sun]\nelevation_deg = 20.0\n"):
        knobs = "[overrides]\nsun.angular_radius_rad = 0.01\nterrain.craters = { uniform = [0.0, 1.0] }\n"
        plan = read_plan(written(SMALL.replace('"mars"', '"far.toml"') + camera + knobs + own))
        with plan.scene("far.toml") as scene:
            sun = Stage(plan, scene).frame(plan.frame(3)).sun
        assert sun is not None and sun.irradiance == (0.1, 0.2, 0.3) and sun.angular_radius_rad == 0.01
        assert sun.elevation_deg == (20.0 if own else 30.0 if camera else 40.0)
    varied = "[overrides]\nsun.irradiance = { choice = [[3.0, 2.0, 1.0]] }\nplanet.radius_m = 2e6\n"
    plan = read_plan(written(SMALL + camera + varied))
    with plan.scene("mars") as scene:
        sun = Stage(plan, scene).frame(plan.frame(3)).sun
        assert sun is not None and sun.irradiance == (3.0, 2.0, 1.0) and scene.planet.radius_m == 2e6


def test_other_words_of_a_plan(written, tmp_path, capsys):
    for change, match in (
        (('"mars"', '"mras"'), "mras"),
        (('"depth"', '"dpeth"'), "did you mean 'depth'"),
        (('"low"', '"lwo"'), "did you mean 'low'"),
    ):
        assert main(["dataset", str(written(SMALL.replace(*change))), "-o", str(tmp_path / "out")]) == 2
        assert match in capsys.readouterr().err
    with pytest.raises(pf.PresetError, match="EXR's floats"):
        read_plan(written(SMALL.replace('"depth"]', '"instance"]\nformat = "exr"')))
