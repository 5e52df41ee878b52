"""common/camera.glsl and the default of the contract sun_visibility against float64."""

from __future__ import annotations

import numpy as np
import pytest
from picture_harness import look

from planetfall.engine.blocks.bindings import FRAME_BLOCK, PLANET_BLOCK
from planetfall.engine.frame.block import FrameBlock, PlanetBlock

CAMERA = '#include "common/camera.glsl"'


@pytest.fixture
def blocks(gpu):
    scope = gpu.scope("blocks")
    frame = scope.uniform_block(FrameBlock, FRAME_BLOCK, "frame")
    planet = scope.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")

    def bind(block: FrameBlock, radius_m: float):
        frame.write(block)
        planet.write(PlanetBlock(radius_m, 9000.0, -9000.0, 0.0, 0.0, has_sea=False))
        return lambda _: (frame.bind(), planet.bind())

    yield bind
    scope.release()


def points_around(rng, up, altitude, radius, count=400):
    """Camera-relative points (f32-exact) on and above the visible ground, and their f64 altitudes."""
    reach = np.sqrt(altitude * (2 * radius + altitude)) + 1.0
    distance = np.exp(rng.uniform(np.log(0.1), np.log(min(1.5 * reach, 2 * radius)), count))
    aside = rng.normal(size=(count, 3))
    aside -= np.outer(aside @ up, up)
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    sideways = aside * np.minimum(distance, 0.9 * radius)[:, None]
    ground = np.sqrt(np.maximum(radius**2 - np.sum(sideways**2, axis=1), 0.0)) - radius - altitude
    point = sideways + up * (ground + rng.uniform(0, 9000, count))[:, None]
    return point.astype(np.float32).astype(np.float64)


@pytest.mark.parametrize("radius", [1e3, 6.371e6, 7e7])
@pytest.mark.parametrize("altitude", [2.0, 1e4, 2e6, 3.6e7])
def test_altitude_and_foot_offset(run_compute, blocks, radius, altitude):
    rng = np.random.default_rng(int(radius + altitude))
    up = np.float32([0.48, 0.6, 0.64]).astype(np.float64)
    up /= np.linalg.norm(up)
    up32 = up.astype(np.float32).astype(np.float64)
    ground = min(120.5, 0.05 * radius)
    offset = (up * (altitude - ground)).astype(np.float32).astype(np.float64)
    block = look(
        camera_zenith=up, camera_altitude_m=altitude, anchor_up=up, anchor_height_m=ground, camera_offset_m=offset
    )
    points = points_around(rng, up, altitude, radius)
    out = run_compute(
        "height = altitude_of(p); foot = foot_offset_of(p, h); height2 = h;\n",
        {"p": points.astype(np.float32)},
        {"height": "float", "foot": "vec3", "height2": "float"},
        header=CAMERA + "\nfloat h;",
        setup=blocks(block, radius),
    )
    # The reference stands on the same f32 up as the shader.
    center = -up32 * (radius + np.float64(np.float32(altitude)))
    from_center = points - center
    distance = np.linalg.norm(from_center, axis=1)
    expected = distance - radius
    scale = np.linalg.norm(points, axis=1)
    # An f32 up isn't exactly unit: 6e-8 of the distances is all that can be had.
    tolerance = 1e-4 + 5e-7 * scale + 2e-7 * altitude
    assert np.all(np.abs(out["height"] - expected) <= tolerance)
    assert np.all(np.abs(out["height2"] - expected) <= tolerance)
    direction = (points + up32 * altitude + up32 * radius) / distance[:, None]
    foot = radius * (direction - up32)
    error = np.linalg.norm(out["foot"] - foot, axis=1)
    assert np.all(error <= 1e-4 + 1e-6 * scale + 3e-7 * altitude), error.max()


def test_rays_and_depth_round_trip(run_compute, blocks):
    block = look(
        (0.3, -0.5, 0.8), (0.0, 1.0, 0.1), 47.0, (320, 180), projection_scale=(0.8, 0.5), projection_offset=(0.1, -0.05)
    )
    rng = np.random.default_rng(1)
    pixel = rng.uniform(0, 1, (200, 2)) * (320, 180)
    depth = np.exp(rng.uniform(np.log(1e-9), 0.0, 200))
    out = run_compute(
        "vec2 ndc = ndc_of_pixel(pixel); point = position_from_depth(ndc, depth); clip = clip_position(point);",
        {"pixel": pixel, "depth": depth},
        {"point": "vec3", "clip": "vec4"},
        header=CAMERA,
        setup=blocks(block, 6.371e6),
    )
    z = out["point"] @ np.array(block.camera_forward)
    np.testing.assert_allclose(z, 0.1 / depth, rtol=1e-6)
    back = (out["clip"][:, :2] / out["clip"][:, 3:] * 0.5 + 0.5) * (320, 180)
    np.testing.assert_allclose(back, pixel, atol=1e-3)
    np.testing.assert_allclose(out["clip"][:, 2] / out["clip"][:, 3], depth, rtol=1e-6)


def test_sun_visibility_is_the_planets_shadow(run_compute, blocks):
    radius, altitude = 6.371e6, 4e5
    block = look(sun_direction=(1.0, 0.0, 0.0))
    rng = np.random.default_rng(2)
    # Points at the surface and above, around the terminator and far from it; the camera is over the north pole.
    angle = np.concatenate([rng.uniform(-0.05, 0.05, 300), rng.uniform(-np.pi / 2, np.pi / 2, 300)])
    height = rng.choice([0.0, 1.0, 5000.0, 3e5], 600)
    position = (radius + height)[:, None] * np.stack([np.sin(angle), np.zeros(600), np.cos(angle)], axis=1)
    point = position - [0.0, 0.0, radius + altitude]
    out = run_compute(
        "seen = sun_visibility(p);",
        {"p": point.astype(np.float32)},
        {"seen": "float"},
        header='#include "contract/sun_visibility.glsl"',
        setup=blocks(block, radius),
    )["seen"]
    r = radius + height
    sin_h, cos_h = radius / r, -np.sqrt(1 - (radius / r) ** 2)
    t = np.clip((np.sin(angle) - cos_h + 0.004675 * sin_h) / (2 * 0.004675 * sin_h), 0, 1)
    # Half a metre of altitude lowers the horizon by 0.08 of the sun's radius: that is what f32 points are worth.
    high = height > 10.0
    np.testing.assert_allclose(out[high], (t * t * (3 - 2 * t))[high], atol=2e-3)
    np.testing.assert_allclose(out, t * t * (3 - 2 * t), atol=0.1)
    assert np.all(out[angle > 0.06] == 1.0) and np.all(out[(angle < -0.06) & (height < 6000)] == 0.0)
