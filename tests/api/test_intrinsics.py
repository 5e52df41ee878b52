"""Lens models against OpenCV, their inverses, the YAML of OpenCV and ROS, and refused input. No GPU."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

import planetfall as pf

COUNT = 100_000
WIDTH, HEIGHT = 640, 360
SIDES = {"width": WIDTH, "height": HEIGHT, "cx": 322.3, "cy": 171.8}
FAR = {**SIDES, "fx": 500.0, "fy": 510.0}
WIDE = {**SIDES, "fx": 150.0, "fy": 155.0}
LENSES = {
    "pinhole": pf.Intrinsics(**FAR),
    "brown, 4": pf.Intrinsics(**FAR, distortion=(-0.28, 0.09, 1e-3, -2e-3), model="brown"),
    "brown, 5": pf.Intrinsics(**FAR, distortion=(0.12, 0.05, 1e-3, -2e-3, 0.01), model="brown"),
    "brown, folding": pf.Intrinsics(**WIDE, distortion=(-0.3, 0.05, 1e-3, -2e-3, 0.0), model="brown"),
    "rational, 8": pf.Intrinsics(**FAR, distortion=(1.2, 0.3, 1e-3, -5e-4, 0.02, 1.4, 0.6, 0.1), model="rational"),
    "rational, 12": pf.Intrinsics(
        **FAR, distortion=(-0.3, 0.1, 1e-3, -2e-3, 0.01, 0.02, 0.03, 0.01, 1e-3, -2e-3, 5e-4, 1e-3), model="rational"
    ),
    "rational, 14": pf.Intrinsics(
        **FAR,
        distortion=(-0.3, 0.1, 1e-3, -2e-3, 0.01, 0.02, 0.03, 0.01, 1e-3, -2e-3, 5e-4, 1e-3, 0.02, -0.03),
        model="rational",
    ),
    "fisheye": pf.Intrinsics(**WIDE, distortion=(0.02, -0.01, 0.003, -0.001), model="fisheye"),
    "panorama": pf.Intrinsics.panorama(WIDTH),
}


def seen_points(lens: pf.Intrinsics) -> tuple[np.ndarray, np.ndarray]:
    """Points (COUNT, 3) at random distances whose pixels (COUNT, 2) are all over the picture."""
    pixels = np.random.default_rng(1).uniform((0.0, 0.0), (lens.width, lens.height), (2 * COUNT, 2))
    rays = lens.rays(pixels)
    there = np.isfinite(rays[:, 0])
    if lens.model == "fisheye":
        there &= rays[:, 2] > 1e-3  # OpenCV's own stops at 90 degrees
    distances = np.random.default_rng(2).uniform(0.1, 1e4, (2 * COUNT, 1))
    return (rays * distances)[there][:COUNT], pixels[there][:COUNT]


def opencv(lens: pf.Intrinsics, points: np.ndarray) -> np.ndarray:
    zero = np.zeros(3)
    coefficients = np.array(lens.distortion or (0.0,) * 4)
    if lens.model == "equirectangular":
        x, y, z = points.T
        longitude, latitude = np.arctan2(x, z), np.arcsin(y / np.linalg.norm(points, axis=1))
        return np.stack([lens.fx * longitude + lens.cx, lens.fy * latitude + lens.cy], axis=1)
    if lens.model == "fisheye":
        return cv2.fisheye.projectPoints(points[:, None], zero, zero, lens.matrix, coefficients)[0][:, 0]
    return cv2.projectPoints(points, zero, zero, lens.matrix, coefficients)[0][:, 0]


@pytest.mark.parametrize("name", LENSES)
def test_pixels_are_those_of_opencv_and_lead_back(name):
    lens = LENSES[name]
    points, pixels = seen_points(lens)
    assert len(points) > 0.9 * COUNT
    found, seen = lens.project(points)
    assert seen.all()
    assert np.abs(found - (opencv(lens, points) + 0.5)).max() < 1e-6  # the promise is 0.01
    assert np.abs(found - pixels).max() < 1e-6


def test_what_a_lens_does_not_see():
    far = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [np.nan, 0.0, 1.0]])
    for name, lens in LENSES.items():
        pixels, seen = lens.project(far)
        assert np.isnan(pixels[~seen]).all() and not seen[1:].any()
        assert seen[0] == (name == "panorama")
    # 1 + 3 k1 r^2 = 0: beyond it OpenCV folds the picture back over itself.
    lens = pf.Intrinsics(**WIDE, distortion=(-0.3, 0.0, 0.0, 0.0), model="brown")
    fold = 1.0 / math.sqrt(0.9)
    _, seen = lens.project([[fold - 1e-6, 0.0, 1.0], [fold + 1e-6, 0.0, 1.0]])
    assert seen.tolist() == [True, False]
    rays = lens.rays()
    assert 0.05 < np.isnan(rays[..., 0]).mean() < 0.9
    assert np.isfinite(rays[171, 322]).all() and np.isnan(rays[0, 0]).all()


def test_a_fisheye_looks_behind_and_a_panorama_all_around():
    lens = pf.Intrinsics(400, 400, 60.0, 60.0, 199.5, 199.5, (), "fisheye")
    rays = lens.rays()
    angles = np.degrees(np.arccos(rays[..., 2]))
    rows, columns = np.indices((400, 400)) - 199.5
    circle = np.hypot(rows, columns) <= 60.0 * math.pi
    assert np.array_equal(np.isfinite(angles), circle) and np.nanmax(angles) > 179.0
    panorama = pf.Intrinsics.panorama(64)
    directions = np.random.default_rng(3).normal(size=(1000, 3))
    pixels, seen = panorama.project(directions)
    assert seen.all() and (pixels >= 0.0).all() and (pixels <= (64.0, 32.0)).all()
    np.testing.assert_allclose(panorama.project([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])[0], [[32, 16], [48, 16]])
    shifted = pf.Intrinsics(64, 32, 64 / (2 * math.pi), 32 / math.pi, -0.5, 15.5, (), "equirectangular")
    np.testing.assert_allclose(shifted.project([[-1.0, 0.0, 0.0]])[0], [[48.0, 16.0]])  # 270 degrees, not -90


def test_a_scaled_lens_sees_the_same():
    lens = LENSES["rational, 8"]
    points, pixels = seen_points(lens)
    found, _ = lens.scaled(3).project(points[:100])
    np.testing.assert_allclose(found, 3.0 * pixels[:100], atol=1e-6)


@pytest.mark.parametrize("name", LENSES)
def test_its_yaml_is_opencvs(name, tmp_path):
    lens, file = LENSES[name], tmp_path / "camera.yml"
    lens.save(file)
    assert pf.Intrinsics.load(file) == lens
    read = cv2.FileStorage(str(file), cv2.FILE_STORAGE_READ)
    np.testing.assert_array_equal(read.getNode("camera_matrix").mat(), lens.matrix)
    assert (read.getNode("image_width").real(), read.getNode("image_height").real()) == lens.size
    if lens.distortion:
        np.testing.assert_array_equal(read.getNode("distortion_coefficients").mat().ravel(), lens.distortion)
    read.release()


@pytest.mark.parametrize("count", [0, 4, 5, 8, 12, 14])
def test_what_opencv_writes_is_read(count, tmp_path):
    matrix = np.array([[500.1, 0.0, 320.3], [0.0, 510.0, 180.0], [0.0, 0.0, 1.0]])
    coefficients = np.random.default_rng(count).normal(0.0, 0.01, (1, count))
    file = cv2.FileStorage(str(tmp_path / "camera.yml"), cv2.FILE_STORAGE_WRITE)
    file.write("calibration_time", "Fri 27 Nov 2026 04:00:00 PM")
    file.write("image_width", 640)
    file.write("image_height", 360)
    file.write("camera_matrix", matrix)
    if count:
        file.write("distortion_coefficients", coefficients)
    file.write("per_view_errors", np.ones((20, 1)))
    file.release()
    lens = pf.Intrinsics.load(tmp_path / "camera.yml")
    np.testing.assert_array_equal(lens.matrix, matrix)
    np.testing.assert_array_equal(lens.distortion, coefficients.ravel())
    assert lens.model == {0: "pinhole", 4: "brown", 5: "brown"}.get(count, "rational") and lens.size == (640, 360)


ROS = """\
image_width: 640
image_height: 480
camera_name: narrow_stereo  # as camera_calibration names it
camera_matrix:
  rows: 3
  cols: 3
  data: [438.8, 0, 305.6,
         0, 437.3, 243.7,
         0, 0, 1]
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: {count}
  data: [{data}]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
"""


def test_yaml_in_braces_and_lists_line_by_line_are_read(tmp_path):
    """As rosparam and people write it."""
    rows = [[120.0, 0.0, 79.0], [0.0, 121.5, 44.0], [0.0, 0.0, 1.0]]
    numbers, bent = [n for row in rows for n in row], [-0.28, 0.09, 0.0, 0.0, 0.0]
    size = "image_width: 160\nimage_height: 90\n"
    braces = "".join(f"{name}: {{rows: 3, cols: 3,\n  data: {data}}}\n"
                     for name, data in (("camera_matrix", numbers), ("distortion_coefficients", bent)))  # fmt: skip
    block = "".join(f"{name}:\n  rows: 3\n  data:\n" + "".join(f"  - {n}\n" for n in data)
                    for name, data in (("camera_matrix", numbers), ("distortion_coefficients", bent)))  # fmt: skip
    for text in (size + braces, size + block, block + size):
        (tmp_path / "camera.yaml").write_text(text)
        lens = pf.Intrinsics.load(tmp_path / "camera.yaml")
        assert (lens.fx, lens.fy, lens.cx, lens.cy) == (120.0, 121.5, 79.0, 44.0)
        assert lens.model == "brown" and lens.distortion == tuple(bent) and lens.size == (160, 90)
    (tmp_path / "camera.yaml").write_text(size + "camera_matrix: {rows: 3,\n")
    with pytest.raises(pf.CameraError, match=r"line 3: camera_matrix: .* no end, expected }"):
        pf.Intrinsics.load(tmp_path / "camera.yaml")


@pytest.mark.parametrize(
    ("told", "model", "data"),
    [
        ("plumb_bob", "brown", (-0.36, 0.11, 1.2e-3, -5e-4, 0.0)),
        ("rational_polynomial", "rational", (0.1, 0.2, 0.0, 0.0, 0.3, 0.4, 0.5, 0.6)),
        ("equidistant", "fisheye", (0.1, 0.0, 0.0, -0.01)),
        ("plumb_bob", "pinhole", (0.0,) * 5),
    ],
)
def test_what_ros_writes_is_read(told, model, data, tmp_path):
    file = tmp_path / "camera.yaml"
    file.write_text(ROS.format(model=told, count=len(data), data=", ".join(map(str, data))))
    lens = pf.Intrinsics.load(file)
    assert (lens.model, lens.size, lens.fx, lens.cy) == (model, (640, 480), 438.8, 243.7)
    assert lens.distortion == (data if any(data) else ())


GOOD = {"width": 640, "height": 360, "fx": 500.0, "fy": 500.0, "cx": 319.5, "cy": 179.5}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"width": 0}, r"width: expected a whole number of pixels, at least 1, found 0"),
        ({"height": 2.5}, r"height: expected a whole number of pixels, at least 1, found 2\.5"),
        ({"fx": -1.0}, r"fx: expected pixels, more than 0, found -1\.0"),
        ({"fy": math.nan}, r"fy: expected pixels, more than 0, found nan"),
        ({"cx": "middle"}, r"cx: expected a number of pixels, found 'middle'"),
        ({"model": "plumb_bob"}, r"model: expected one of pinhole, brown, .*, found 'plumb_bob'"),
        ({"distortion": (0.1, 0, 0, 0)}, r"'pinhole' takes none .*, found 4; 4 are those of model='brown'"),
        ({"model": "brown", "distortion": (0.1,) * 8}, r"takes 4 or 5 .*, found 8; 8 are those of model='rational'"),
        ({"model": "fisheye", "distortion": (0.1, math.inf, 0, 0)}, r"distortion: expected finite numbers"),
        ({"model": "brown", "distortion": "none"}, r"distortion: expected finite numbers, found 'none'"),
    ],
)  # fmt: skip
def test_refused_values(changes, message):
    with pytest.raises(pf.CameraError, match=f"Intrinsics: .*{message}"):
        pf.Intrinsics(**{**GOOD, **changes})


def test_refused_arrays():
    lens = pf.Intrinsics(**GOOD)
    with pytest.raises(pf.CameraError, match=r"points: expected the shape \(N, 3\), found \(2,\)"):
        lens.project((1.0, 2.0))
    with pytest.raises(pf.CameraError, match=r"pixels: expected the shape \(N, 2\), found \(1, 3\)"):
        lens.rays([(1.0, 2.0, 3.0)])


MATRIX = "camera_matrix:\n  rows: 3\n  data: [1, 0, 2, 0, 1, 2, 0, 0, 1]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("image_width: 4\nimage_height: 3\n", r"camera_matrix: expected a 3 x 3 matrix.*, found none"),
        (MATRIX, r"image_width: expected a whole number of pixels, found nothing"),
        (MATRIX + "image_width: 4\nimage_height: -3\n", r"image_height: expected a whole number of pixels, found -3"),
        (MATRIX.replace("2,", "two,", 1), r"camera_matrix: data: expected a list of numbers, found '\[1, 0, two"),
        (MATRIX.replace("1, 0, 2", "1, 9, 2"), r"camera_matrix: skew 9 is not part of any model here"),
        (MATRIX.replace("]", ""), r"line 3: data: the list that begins there has no end"),
        ("no yaml at all\n", r"line 1: expected 'key: value', found 'no yaml at all'"),
        (
            MATRIX + "image_width: 4\nimage_height: 3\ndistortion_model: mine\n",
            r"Intrinsics: model: expected one of pinhole, .*, found 'mine'",
        ),
    ],
)
def test_refused_files(text, message, tmp_path):
    file = tmp_path / "camera.yml"
    file.write_text(text)
    with pytest.raises(pf.CameraError, match=rf"camera\.yml.*{message}"):
        pf.Intrinsics.load(file)


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(pf.CameraError, match=r"none\.yml: no such file"):
        pf.Intrinsics.load(tmp_path / "none.yml")
    with pytest.raises(pf.CameraError, match=r"can't be written: .*; check its folder and rights"):
        pf.Intrinsics(**GOOD).save(tmp_path / "no folder" / "camera.yml")


def test_refused_cameras():
    lens = pf.Intrinsics(**GOOD)
    with pytest.raises(pf.CameraError, match=r"intrinsics: expected a pf\.Intrinsics, found 'camera\.yml'"):
        pf.Camera.at(0, 0, 1, intrinsics="camera.yml")
    with pytest.raises(pf.CameraError, match="frustum_deg and intrinsics exclude each other"):
        pf.Camera.at(0, 0, 1, frustum_deg=(-1, 1, -1, 1), intrinsics=lens)
    camera = pf.Camera.at(0, 0, 1, intrinsics=lens)
    assert camera.intrinsics is lens and "intrinsics=Intrinsics(width=640" in repr(camera)
    assert camera.exposed(12.0).intrinsics is lens
    shown = pf.view("near").with_intrinsics(lens).exposed(9.0)
    assert shown.intrinsics is lens and shown.ev100 == 9.0 and pf.view("near").intrinsics is None
