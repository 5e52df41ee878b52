"""Data sets: the same frames in any order, poses as OpenCV reads them, going on after an interruption."""

from __future__ import annotations

import hashlib
import json
import shutil

import numpy as np
import pytest

import planetfall as pf
from planetfall.capture.dataset_plan import parse_range, read_plan
from planetfall.cli.main import main
from planetfall.systems.capture import CaptureError

PLAN = """
seed = 3
count = 3
size = [64, 36]
quality = "low"
scene = "moon"
outputs = ["color", "position", "depth", "material"]
[camera]
altitude_m = { log = [50.0, 5000.0] }
pitch_deg = { uniform = [-60.0, -20.0] }
"""


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "plan.toml").write_text(PLAN)
    return tmp_path / "plan.toml"


def lines(root):
    return [json.loads(line) for line in (root / "frames.jsonl").read_text().splitlines()]


def sums(root):
    return {name: file["sha256"] for each in lines(root) for name, file in each["files"].items()}


@pytest.mark.gpu
def test_a_set_is_whole_and_the_same_in_any_order(plan, tmp_path):
    one = pf.dataset(plan, tmp_path / "one")
    told, manifest = lines(one), json.loads((one / "manifest.json").read_text())
    assert [each["frame"] for each in told] == [0, 1, 2] and manifest["frames"] == manifest["count"] == 3
    assert sums(one).items() <= manifest["files"].items() and len(sums(one)) == 6 and len(manifest["machines"]) == 1
    # All that is there has its checksum, and says what it was made of.
    assert manifest["files"] == {
        path.relative_to(one).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in one.rglob("*") if path.is_file() and path.name != "manifest.json"
    }  # fmt: skip
    assert json.loads((one / "plan.json").read_text())["made_of"]["scene moon"]["planet"]["radius_m"] > 0.0
    assert told[0]["overrides"] == {} and "none" in told[0]["materials"].values()
    # Backwards, and half of it in a folder of its own.
    two = pf.dataset(plan, tmp_path / "two", frames=[2])
    three = pf.dataset(plan, tmp_path / "three", frames=[1, 0])
    for file in (three / "frames").iterdir():
        shutil.copy(file, two / "frames")
    pf.dataset(plan, two)
    assert sums(two) == sums(one)
    # What was cut off is made again, and nothing else.
    cut, kept = one / "frames" / "000001.npz", one / "frames" / "000002.npz"
    before = kept.stat().st_mtime_ns
    cut.write_bytes(cut.read_bytes()[:-9])
    made = []
    pf.dataset(plan, one, progress=lambda done, of: made.append((done, of)))
    assert made == [(3, 3)] and sums(one) == sums(two) and kept.stat().st_mtime_ns == before
    # Poses as OpenCV has them: positions of pixels are seen in the middles of these pixels.
    cv2 = pytest.importorskip("cv2", reason="opencv-python-headless is not installed")
    for each in told:
        arrays = np.load(one / "frames" / f"{each['frame']:06d}.npz")
        turn = np.array(each["camera"]["camera_to_planet"])
        assert np.linalg.det(turn) == pytest.approx(1.0)
        there = np.isfinite(arrays["depth"])
        y, x = np.nonzero(there)
        lens = each["lens"]
        matrix = np.array([[lens["fx"], 0.0, lens["cx"]], [0.0, lens["fy"], lens["cy"]], [0.0, 0.0, 1.0]])
        vector, _ = cv2.Rodrigues(turn.T)
        pixels, _ = cv2.projectPoints(arrays["position"][there].astype(float), vector, np.zeros(3), matrix, None)
        np.testing.assert_allclose(pixels[:, 0], np.stack([x, y], axis=1), atol=0.02)
        ahead = (arrays["position"][there].astype(float) @ turn)[:, 2]
        np.testing.assert_allclose(ahead, arrays["depth"][there], rtol=1e-5)
    # transforms.json says the same of places and directions.
    found = json.loads((one / "transforms.json").read_text())
    axes, origin = np.array(found["axes"]), np.array(found["origin_m"])
    for each, pose in zip(told, found["frames"], strict=True):
        matrix = np.array(pose["transform_matrix"])
        np.testing.assert_allclose(matrix[:3, 3] @ axes + origin, each["camera"]["position_m"], atol=1e-6)
        forward = np.array(each["camera"]["camera_to_planet"])[:, 2]
        np.testing.assert_allclose(-matrix[:3, 2] @ axes, forward, atol=1e-12)
        assert (one / pose["file_path"]).is_file()


def test_frames_are_drawn_one_by_one(plan):
    read = read_plan(plan)
    frames = [read.frame(n) for n in range(3)]
    assert len({frame.values["camera.altitude_m"] for frame in frames}) == 3
    assert read.frame(1).values == frames[1].values
    # A key more leaves the others' numbers as they are.
    plan.write_text(PLAN + "[sun]\nelevation_deg = { uniform = [5.0, 60.0] }\n")
    other = read_plan(plan).frame(1).values
    assert {k: v for k, v in other.items() if k != "sun.elevation_deg"} == {
        k: v for k, v in frames[1].values.items() if k != "sun.elevation_deg"
    }


def test_distributions(plan):
    plan.write_text(PLAN.replace("count = 3", "count = 2000") + "heading_deg = { choice = [0.0, 90.0] }\n")
    read = read_plan(plan)
    drawn = [read.frame(n).values for n in range(2000)]
    altitude = np.log([each["camera.altitude_m"] for each in drawn])
    assert np.log(50.0) <= altitude.min() and altitude.max() <= np.log(5000.0)
    assert abs(altitude.mean() - np.log(500.0)) < 4.0 * altitude.std() / np.sqrt(2000)
    sines = np.sin(np.radians([each["camera.latitude_deg"] for each in drawn]))
    assert abs(sines.mean()) < 0.05 and abs(sines.std() - np.sin(np.radians(70.0)) / np.sqrt(3.0)) < 0.03
    assert {each["camera.heading_deg"] for each in drawn} == {0.0, 90.0}


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (("seed = 3", "sed = 3"), "sed: no such key; did you mean"),
        (("seed = 3", 'seed = "a"'), "seed: found"),
        (("count = 3", "count = 0"), "at least 1 frame"),
        (("[64, 36]", "[64]"), "size: expected"),
        (('"low"', '"low"\nformat = "gif"'), "format"),
        (("[64, 36]", "[true, 36]"), "size: expected"),
        (('"depth"', '"flow"'), "leave it out"),
        (('"depth"', '["depth"]'), r"no output \['depth'\]"),
        (('"depth"', "{ depth = 1 }"), "no output {'depth': 1}"),
        (('"color", "position", "depth", "material"', ""), "at least one of color"),
        (("altitude_m", "altitude"), r"camera\.altitude: no such key"),
        (("log = [50.0", "log = [-50.0"), "above 0"),
        (("uniform = [-60.0, -20.0]", "uniform = [-20.0, -60.0]"), "lower number first"),
        (("uniform = [-60.0, -20.0]", "uniform = [-20.0]"), "two numbers"),
        (("{ uniform", "{ gauss"), "expected a number from -90 to 90, or one of"),
    ],
)
def test_a_plan_that_is_wrong_is_told_why(plan, change, match):
    plan.write_text(PLAN.replace(*change))
    with pytest.raises(pf.PresetError, match=match):
        read_plan(plan)


def test_numbers_of_frames_that_are_not_there(plan, tmp_path):
    for frames, match in (([3], "from 0 to 2, found 3"), ([-1], "found -1"), ("0:2", "whole numbers"), (5, "whole")):
        with pytest.raises(pf.SettingError, match=match):
            pf.dataset(plan, tmp_path / "out", frames=frames)
    assert not (tmp_path / "out").exists()


def test_folders_with_something_in_the_way(plan, tmp_path):
    for file, content in (("frames", ""), ("plan.json", "{"), ("plan.json", "3")):
        out = tmp_path / "out"
        out.mkdir(exist_ok=True)
        (out / file).write_text(content)
        with pytest.raises(CaptureError, match=r"cannot be made|another plan"):
            pf.dataset(plan, out, frames=[0])
        shutil.rmtree(out)


def test_ranges():
    assert list(parse_range("2:4", 6)) == [2, 3] and list(parse_range(":", 2)) == [0, 1]
    for wrong in ("4", "5:5", "a:b", "9:12"):
        with pytest.raises(pf.SettingError, match="expected A:B"):
            parse_range(wrong, 6)


@pytest.mark.gpu
def test_command_and_other_plans(plan, tmp_path, capsys):
    out = tmp_path / "set"
    assert main(["dataset", str(plan), "-o", str(out), "--frames", "0:1"]) in (0, None)
    assert str(out / "frames.jsonl") in capsys.readouterr().out and len(lines(out)) == 1
    plan.write_text(PLAN.replace("seed = 3", "seed = 4"))
    assert main(["dataset", str(plan), "-o", str(out)]) == 2
    assert "another plan" in capsys.readouterr().err
