"""Rows of a picture that may show water before the lens, against the waterline's formula pixel by pixel."""

import numpy as np
import pytest

from planetfall.engine.space import CameraState
from planetfall.systems.ocean.lens import FAR_M, LensPlane, wet_rows

WIDTH, HEIGHT, EDGE_PX = 64, 36, 60.0


def camera_of(random: np.random.Generator, tan_top: float, shift: float) -> CameraState:
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    right, up = axes[0], axes[1]
    wide = tan_top * WIDTH / HEIGHT
    return CameraState(
        np.array([0.0, 0.0, 6.4e6]), np.cross(up, right), up, right, shift - wide, shift + wide, -tan_top, tan_top, 0.1
    )


def over_water(lens: LensPlane, camera: CameraState) -> np.ndarray:
    """lens_over_water() of assets/shaders/ocean/waterline.glsl at all pixels, in pixels, rows from below."""
    x = camera.tan_left + (camera.tan_right - camera.tan_left) * (np.arange(WIDTH) + 0.5) / WIDTH
    y = camera.tan_bottom + (camera.tan_top - camera.tan_bottom) * (np.arange(HEIGHT) + 0.5) / HEIGHT
    ray = camera.forward + x[None, :, None] * camera.right + y[:, None, None] * camera.up
    pixel = (camera.tan_top - camera.tan_bottom) / HEIGHT
    over = (ray @ np.array(lens.normal)) * camera.near_m + lens.height_m
    return over / (camera.near_m * pixel * np.linalg.norm(ray, axis=-1))


def test_no_wet_row_is_left_out_and_few_dry_ones_are_in() -> None:
    random = np.random.default_rng(7)
    kept = needed = 0
    for _ in range(2000):
        camera = camera_of(random, random.uniform(0.05, 1.2), random.uniform(-0.5, 0.5))
        normal = random.normal(size=3)
        lens = LensPlane(normal / np.linalg.norm(normal), random.uniform(-0.3, 0.6))
        first, end = wet_rows(lens, camera, HEIGHT)
        wet = np.flatnonzero((over_water(lens, camera) <= EDGE_PX).any(axis=1))
        assert first >= 0 and end <= HEIGHT
        assert wet.size == 0 or (first <= wet[0] and wet[-1] < end), (lens, first, end, wet)
        kept += max(end - first, 0)
        needed += wet.size
    assert 0.3 * 2000 * HEIGHT < needed < 0.9 * 2000 * HEIGHT  # both kinds were asked for
    assert kept < 1.05 * needed


@pytest.mark.parametrize(("height_m", "rows"), [(-FAR_M, (0, HEIGHT)), (FAR_M, (0, 0))])
def test_far_from_all_waves_there_is_one_answer(height_m: float, rows: tuple[int, int]) -> None:
    camera = camera_of(np.random.default_rng(1), 0.4, 0.0)
    first, end = wet_rows(LensPlane((0.0, 0.0, 1.0), height_m), camera, HEIGHT)
    assert (first, end) == rows or (rows == (0, 0) and first >= end)
