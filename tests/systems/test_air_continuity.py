"""The air without a step: through top and floor, the sun through zenith and horizon, over a pole; planets of any size.

A planet of sea: pixels that change from sea to sky are left out, and there is no relief that changes with the distance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from air_kit import SUN, at, bare, radiance, renderer_of
from numpy.typing import NDArray

import planetfall as pf
from planetfall.components import Atmosphere

pytestmark = pytest.mark.gpu

Floats = NDArray[np.float64]
RADIUS_M, TOP_M = 6.36e6, 60e3
GLOW = 1.0e-8
"""W m^-2 sr^-1 nm^-1: three times the darkest night sky. Smaller changes are none."""
MOST_SUN = 1.92
"""W m^-2 nm^-1, the default sun's largest channel."""
SUNS = {"day": SUN.direction, "low": (1.0, 0.0, -0.3), "dusk": (0.3, 0.0, -1.0)}


@pytest.fixture(scope="module")
def scene() -> pf.Scene:
    return bare(sea_m=0.0)


@pytest.fixture(scope="module")
def renderer(scene: pf.Scene) -> Iterator[pf.Renderer]:
    with pf.Renderer(scene, (96, 54), "medium", {"ocean.ripples": False}) as made:
        made.settle(at(1000.0))
        yield made


def sun_of(direction: Sequence[float]) -> pf.Sun:
    return pf.Sun(direction=tuple(np.asarray(direction) / np.linalg.norm(direction)))


def rays_of(renderer: pf.Renderer, camera: pf.Camera) -> Floats:
    """(h, w, 3): unit directions of the pixels, in float64."""
    state, (width, height) = renderer.camera_state(camera), renderer.size
    x = state.tan_left + (state.tan_right - state.tan_left) * (np.arange(width) + 0.5) / width
    y = state.tan_top + (state.tan_bottom - state.tan_top) * (np.arange(height) + 0.5) / height
    rays = state.forward + x[None, :, None] * np.cross(state.forward, state.up) + y[:, None, None] * state.up
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def far_from(renderer: pf.Renderer, camera: pf.Camera, suns: Sequence[pf.Sun]) -> NDArray[np.bool_]:
    """(h, w): pixels that none of the suns' discs come near."""
    rays = rays_of(renderer, camera)
    return np.all([rays @ np.asarray(sun.direction) < np.cos(np.radians(1.5)) for sun in suns], axis=0)


def pictures(
    renderer: pf.Renderer, cameras: Sequence[pf.Camera], suns: Sequence[pf.Sun]
) -> tuple[Floats, NDArray[np.bool_]]:
    """(frames, h, w, 3) radiance and (frames - 1, h, w), pixels that show the same in two frames: the sky, or sea whose
    distance has not jumped, as it does in the last row before its horizon."""
    light, distance = [], []
    for camera, sun in zip(cameras, suns, strict=True):
        found = renderer.render(camera, outputs=("radiance", "distance"), sun=sun)
        assert np.isfinite(found["radiance"]).all() and (found["radiance"] >= 0.0).all()
        light.append(found["radiance"].astype(np.float64))
        # The sky, infinitely far away, as something that equals itself alone.
        distance.append(np.minimum(found["distance"], 1e30))
    far = np.stack(distance)
    return np.stack(light), np.abs(np.diff(far, axis=0)) < 0.02 * far[1:]


def largest_step(light: Floats, ignore: float, counts: NDArray[np.bool_]) -> float:
    """Largest relative change from frame to frame beyond `ignore`, where counts (frames - 1, h, w)."""
    change = np.maximum(np.abs(np.diff(light, axis=0)) - ignore, 0.0)
    return float((change / np.maximum(np.maximum(light[1:], light[:-1]), 1e-30))[counts].max(initial=0.0))


def largest_jerk(light: Floats, ignore: float, counts: NDArray[np.bool_]) -> float:
    """Largest relative change of the change, over three frames: 0 for what brightens steadily, however fast."""
    change = np.maximum(np.abs(np.diff(light, 2, axis=0)) - ignore, 0.0)
    return float((change / np.maximum(light[1:-1], 1e-30))[counts[1:] & counts[:-1]].max(initial=0.0))


@pytest.mark.parametrize("sun", ["day", "low", "dusk"])
@pytest.mark.parametrize("pitch_deg", [-90.0, -8.0, 0.0, 90.0])
def test_through_the_top_in_steps_of_a_metre(renderer: pf.Renderer, pitch_deg: float, sun: str) -> None:
    cameras = [at(TOP_M - 30.0 + k, pitch_deg) for k in range(60)]
    light, same = pictures(renderer, cameras, [sun_of(SUNS[sun])] * 60)
    # The model's air ends abruptly, at e^-7.5 of the ground's density. What a ray gains or loses that enters or leaves
    # it is at most the sunlight scattered along the longest way through its last 30 m.
    air = Atmosphere()
    longest = 2.0 * np.sqrt(2.0 * (RADIUS_M + TOP_M) * 30.0)
    edge = max(air.rayleigh_scattering_per_m) * np.exp(-TOP_M / air.rayleigh_scale_height_m) * longest
    edge *= MOST_SUN * 3.0 / (8.0 * np.pi)  # Rayleigh's phase function ahead
    assert edge < 2e-4, "a thousandth of a bright sky"
    assert same.mean() > 0.99
    assert largest_step(light, edge, same) < 0.01
    if sun == "day":
        assert pitch_deg == 90.0 or light.max() > 100.0 * edge


@pytest.mark.parametrize("step_m", [1.0, 1e-4])
@pytest.mark.parametrize("pitch_deg", [-20.0, 0.0, 60.0])
def test_through_the_floor(renderer: pf.Renderer, scene: pf.Scene, pitch_deg: float, step_m: float) -> None:
    """Below it, over a sea that lies deeper, the air is held at the floor's density."""
    scene.planet[pf.Ocean].sea_level_m = -300.0
    try:
        for direction in SUNS.values():
            cameras = [at((k - 15.5) * step_m, pitch_deg) for k in range(31)]
            light, same = pictures(renderer, cameras, [sun_of(direction)] * 31)
            assert same.mean() > 0.99
            # A metre brings the water nearer by 0.3 %, and the camera's tables, whose rows go over four decades of
            # lengths here, are good to 1 %.
            assert largest_step(light, GLOW, same) < (0.02 if step_m == 1.0 else 0.005)
    finally:
        scene.planet[pf.Ocean].sea_level_m = 0.0


@pytest.mark.parametrize("altitude_m", [2.0, 9000.0, 2.0e6])
@pytest.mark.parametrize("zenith_deg", [0.0, 90.0, 96.0, 180.0])
def test_the_sun_through_zenith_and_horizon(renderer: pf.Renderer, zenith_deg: float, altitude_m: float) -> None:
    camera = at(altitude_m, pitch_deg=5.0, heading_deg=0.0)
    up = renderer.camera_state(camera).position_m
    up = up / np.linalg.norm(up)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    angles = np.radians(zenith_deg - 0.1 + 0.01 * np.arange(21) + 1e-4)
    suns = [sun_of(np.cos(a) * up + np.sin(a) * east) for a in angles]
    for pitch_deg, heading_deg in ((5.0, 90.0), (50.0, 0.0), (-30.0, 70.0)):
        view = at(altitude_m, pitch_deg, heading_deg)
        light, same = pictures(renderer, [view] * len(suns), suns)
        # From low down what the sun draws on the water is the sea's affair.
        seen = renderer.render(view, outputs=("surface",))["surface"] == 0
        counts = same & far_from(renderer, view, suns) & (seen | (altitude_m > 1e5))
        # Brightness may change fast, at dusk by 1.5 % a step, but evenly.
        assert largest_jerk(light, GLOW, counts) < 0.01, (pitch_deg, heading_deg)


@pytest.mark.parametrize("sun", [(0.8, 0.0, 0.6), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
@pytest.mark.parametrize("step_m", [1e-3, 30.0])
def test_over_a_pole(renderer: pf.Renderer, step_m: float, sun: tuple[float, float, float]) -> None:
    """Where longitudes meet, and the sun's azimuth turns round under a sun in the zenith."""
    for altitude_m in (2.0, 2.0e5):
        cameras = [
            pf.Camera(
                position_m=((k - 10.3) * step_m, 0.3 * step_m, RADIUS_M + altitude_m),
                forward=(1.0, 0.1, 0.1),
                up=(0.0, 0.0, 1.0),
            )
            for k in range(20)
        ]
        light, same = pictures(renderer, cameras, [sun_of(sun)] * 20)
        assert largest_step(light, GLOW, same & far_from(renderer, cameras[10], [sun_of(sun)])) < 0.01


# -- planets of any size ---------------------------------------------------------------------------------------------


def of_size(radius_m: float, thickness_m: float, depth: float) -> Atmosphere:
    """Air of this vertical optical depth, a third of it haze, in proportion to its thickness."""
    height = thickness_m / 7.0
    gas, haze = 0.6 * depth / height, 0.3 * depth / (0.3 * height)
    return Atmosphere(
        thickness_m=thickness_m,
        rayleigh_scattering_per_m=(0.3 * gas, 0.5 * gas, gas),
        rayleigh_scale_height_m=height,
        mie_scattering_per_m=(0.9 * haze,) * 3,
        mie_extinction_per_m=(haze,) * 3,
        mie_scale_height_m=0.3 * height,
        absorption_per_m=(0.0, 0.1 * depth / height, 0.0),
        absorption_center_m=3.0 * height,
        absorption_half_width_m=height,
    )


@pytest.mark.parametrize(
    ("radius_m", "share", "depth"),
    [(1e3, 1.0, 1.0), (1e3, 1e-4, 1e-6), (6e4, 0.03, 0.3), (6.36e6, 0.01, 50.0), (7e7, 1e-3, 0.5), (7e7, 1.0, 50.0)],
)
def test_finite_and_never_negative(radius_m: float, share: float, depth: float) -> None:
    """`radiance` checks it. Cameras from the floor to 1e9 m and on the boundaries themselves, the sun all around."""
    thickness = share * radius_m
    scene = bare(of_size(radius_m, thickness, depth), radius_m)
    heights = (-0.01 * thickness, 0.0, 1e-6 * thickness, 0.5 * thickness, np.nextafter(thickness, 0.0), thickness)
    heights += (np.nextafter(thickness, np.inf), 3.0 * thickness, 10.0 * radius_m, 1e9)
    brightest = 0.0
    with renderer_of(scene, size=(24, 16)) as renderer:
        renderer.settle(at(thickness))
        for height in heights:
            horizon_deg = -np.degrees(np.arccos(min(radius_m / (radius_m + max(height, 0.0)), 1.0)))
            for pitch_deg in {-90.0, max(horizon_deg, -89.0), 0.0, 90.0}:
                camera = at(height, pitch_deg)
                for sun in ((0.6, 0.0, 0.8), (-0.2, 0.9, -0.4), tuple(-up_of(renderer, camera)), (0.0, 0.0, 1.0)):
                    light = radiance(renderer, camera, sun=sun_of(sun))
                    brightest = max(brightest, float(np.minimum(light, 10.0).max()))
    assert brightest > 0.0


def up_of(renderer: pf.Renderer, camera: pf.Camera) -> Floats:
    position = renderer.camera_state(camera).position_m
    return position / np.linalg.norm(position)


def test_the_night_side_does_not_glow(renderer: pf.Renderer, scene: pf.Scene) -> None:
    """From space, where the sun is 120 degrees and more from the zenith: no light comes round the planet so far."""
    air = scene.planet[pf.Atmosphere]
    air.night_light = 0.0
    try:
        for altitude_m in (1e5, 1e6, 3.6e7):
            camera = at(altitude_m, -90.0)
            sun = sun_of(-up_of(renderer, camera))
            light = radiance(renderer, camera, sun=sun)
            # The angle from the nadir of a ray that ends 60 degrees from the middle of the night side.
            reach = np.arctan2(np.sin(np.radians(60.0)), (RADIUS_M + altitude_m) / RADIUS_M - np.cos(np.radians(60.0)))
            horizon = np.arcsin(RADIUS_M / (RADIUS_M + altitude_m))
            below = np.arccos(np.clip(rays_of(renderer, camera) @ np.asarray(sun.direction), -1.0, 1.0))
            dark = below < min(reach, 0.98 * horizon)
            assert dark.sum() > 20
            assert light[dark].max() < GLOW
    finally:
        air.night_light = 1.0
