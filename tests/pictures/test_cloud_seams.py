"""Lines, lattices and stairs that clouds themselves don't have: what a march, its patterns and its samples of a pixel
must not leave in a picture."""

from __future__ import annotations

import math

import numpy as np
import pytest
from air_kit import bare
from cloud_kit import COARSE, TINY, cloudy, renderer_of, texture
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components import Atmosphere, Clouds, Ocean, Terrain
from planetfall.quality import resolve_quality
from planetfall.systems.clouds.history import STILL, History, radical_inverse, turn_share

pytestmark = pytest.mark.gpu

UP = pf.Sun(elevation_deg=40.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=10.0)
LEVEL = 0.012
"""Of radiance, relative: what a step of 8 bits is where clouds are bright (sRGB 186, an exponent of 2.2)."""


def sweep(scene: pf.Scene, rows: int = 320, columns: int = 64) -> NDArray[np.float64]:
    """Light of clouds from the ground, 13 to 53 degrees above the horizon, (rows,): each row the mean over rays side by
    side, whose samples lie all over their steps. So what is left of chance is alike in all rows."""
    camera = pf.Camera.at(20.0, 10.0, 2.0, heading_deg=30.0, pitch_deg=33.0, frustum_deg=(-0.5, 0.5, -20.0, 20.0))
    with renderer_of(scene, (columns, rows), fine_steps=96, step_growth=0.003, sun_steps=5) as renderer:
        renderer.render(camera, sun=UP)
        return texture(renderer, "clouds.rays")[..., 1].mean(axis=1)


def steps(profile: NDArray[np.float64]) -> NDArray[np.float64]:
    """How much each row differs from the one before beyond what rows around it do, relative."""
    change = np.diff(profile)
    around = np.median([np.roll(change, k) for k in range(-4, 5)], axis=0)
    return (np.abs(change - around) / profile[1:])[5:-5]


def test_no_arc_where_a_ray_has_a_segment_or_a_step_more() -> None:
    """Along elevation, under a closed sky of two layers, without billows: these are as fine as rows."""
    scene = cloudy(air=False, coverage=0.9, relief=0.0)
    found = steps(sweep(scene))
    assert found.max() < LEVEL, (found.argmax(), found.max())


def test_no_outline_where_a_cloud_gets_opaque() -> None:
    """An even layer, of which rays see an optical depth of 2 to 10: what is not marched any more is as bright."""
    scene = cloudy(air=False, density_model="uniform", base_m=1000.0, top_m=2000.0, extinction_per_m=2.4e-3)
    found = steps(sweep(scene))
    assert found.max() < LEVEL, (found.argmax(), found.max())


def test_outlines_of_settled_clouds_are_smooth() -> None:
    """The rim of an opaque shell from space: pixels have the share of it that a picture four times as fine has, to
    what rays through two places of each can tell: a half, which is off by an eighth in the mean. The middle alone is by
    a fourth."""
    scene = cloudy(air=False, density_model="uniform", extinction_per_m=0.1)
    camera = pf.Camera.at(20.0, 10.0, 2e6, pitch_deg=-40.0, fov_y_deg=20.0)
    found = []
    for side in (1, 4):
        with renderer_of(scene, (48 * side, 32 * side), stride=2, samples=32) as renderer:
            renderer.settle(camera, sun=UP)
            renderer.render(camera, sun=UP)
            left = texture(renderer, "clouds.full")[..., 3]
        found.append(left.reshape(32, side, 48, side).mean(axis=(1, 3)))
    rim = (found[1] > 0.1) & (found[1] < 0.9)
    assert rim.sum() > 20
    assert np.abs(found[0] - found[1])[rim].mean() < 0.1875


def test_clouds_from_far_away_are_as_opaque_through_all_places_of_a_pixel() -> None:
    """An even layer 5 km above a sea, from 36 000 km, where that is deeper than that within a pixel: rays beside
    a pixel's middle end on the sea that they meet. They see all of the layer while its depth between pixels, which is
    taken as linear, is right to 5 km: pixels are 198 km wide, so within 4000 km of the disc's middle, where a sphere
    bends by 198^2 / 16 / 6371 / cos(39 degrees)^3 = 0.8 km between two."""
    scene = bare(sea_m=0.0)
    scene.planet.add(Clouds(density_model="uniform", base_m=5000.0, top_m=6000.0, extinction_per_m=5e-4))
    camera = pf.Camera.at(20.0, 10.0, 3.6e7, pitch_deg=-90.0, fov_y_deg=20.0)
    found = []
    for samples in (4, 32):
        with renderer_of(scene, (64, 64), stride=2, samples=samples) as renderer:
            renderer.settle(camera, sun=UP)
            renderer.render(camera, sun=UP)
            found.append(texture(renderer, "clouds.full")[..., 3])
    away_px = np.hypot(*(np.indices((64, 64)) - 31.5)).astype(int)
    rings = np.array([[one[away_px == px].mean() for px in range(20)] for one in found])
    assert rings.max() < 0.75
    np.testing.assert_allclose(rings[1], rings[0], atol=0.003)
    assert np.abs(found[1] - found[0])[away_px < 20].max() < 0.05  # chance, of few steps in a thin layer


def test_no_dashes_along_the_horizon() -> None:
    """Of a calm sea at a low sun, whose clouds keep the sun from the air over it: while anti-aliasing looks now above
    the horizon and now below it, each has the light of its own way. Along the rows there light changes as smoothly as
    anywhere: to the rounding of three colours, their dither included."""
    scene = bare(sea_m=0.0)
    scene.planet.add(Clouds(coverage=0.6))
    sun = pf.Sun(elevation_deg=15.0, azimuth_deg=0.0, latitude_deg=20.0, longitude_deg=10.0)
    camera = pf.Camera.at(20.0, 10.0, 5.0, pitch_deg=2.0, fov_y_deg=50.0)
    settled = {"clouds.stride": 2, "clouds.samples": 32, "composite.antialiasing": "temporal", "composite.samples": 17}
    with pf.Renderer(scene, (96, 54), "medium", {**TINY, **COARSE, **settled}) as renderer:
        renderer.settle(camera, sun=sun)
        color = renderer.render(camera, sun=sun)["color"][..., :3].astype(np.float64).mean(axis=-1)
        sky = renderer.render(camera, sun=sun, outputs=("distance",))["distance"] > 1e30
    horizon = int(sky.sum(axis=0).max())
    rows = color[horizon : horizon + 3]  # of the sea: clouds over it have outlines
    bend = np.abs(rows[:, :-2] - 2.0 * rows[:, 1:-1] + rows[:, 2:])
    aside = np.abs(np.arange(1, 95) - 47.5) > 14  # of the sun's glint
    assert bend[:, aside].max() < 4.0, bend.max(axis=1)


def test_no_level_lines_in_bright_clouds() -> None:
    """A part of view clouds, 64 x 64 of its 640 x 360 pixels, in which clouds begin at depths that change by more than
    a step from row to row. Light bends from row to row no more alike in 24 columns than it does in each by itself: by
    chance 1 +- 0.2 times, of 18 rows. While rays side by side began their steps alike it was 2.7 times."""
    scene = preset_scene("earth", True)
    for kind in (Terrain, Ocean, Atmosphere):
        scene.planet.remove(kind)
    scene.planet[Clouds].layers = ()
    view = pf.view("clouds", scene.planet)
    per_px = math.tan(math.radians(0.5 * view.fov_y_deg)) / 180.0
    sides = [math.degrees(math.atan(px * per_px)) for px in (64, 128, -52, 12)]
    camera = pf.Camera(view.position_m, view.forward, view.up, frustum_deg=sides)
    with pf.Renderer(scene, (64, 64), "medium") as renderer:
        renderer.settle(camera, view.time_s, view.sun)
        renderer.render(camera, view.time_s, view.sun)
        light = texture(renderer, "clouds.full")[::-1, :, 1][30:50, 22:46]
    bend = light[:-2] - 2.0 * light[1:-1] + light[2:]
    alike = bend.mean(axis=1).std() / (bend.std() / bend.shape[1] ** 0.5)
    assert alike < 1.6, alike


def turns_of(quality: str) -> dict[str, int]:
    """Blocks and rays of a quality, in which a pixel's turns are: 8 at high, 4 at medium, 7 at low."""
    settings = resolve_quality(quality)
    return {name: int(settings[f"clouds.{name}"]) for name in ("stride", "samples")}


@pytest.mark.parametrize("quality", ["low", "medium", "high"])
def test_no_lattice_is_left_in_a_settled_picture(quality: str) -> None:
    """The pattern of samples in their steps is a lattice over the picture. None of its harmonics stands out of the
    spectrum of an even layer's light, whose picture has nothing else but a gradient and what chance leaves. Where four
    turns are as far apart as eight should be, the fourth harmonic is left: level lines 3.6 pixels apart."""
    scene, side = cloudy(density_model="uniform", base_m=1000.0, top_m=2000.0, extinction_per_m=1e-3), 96
    low = pf.Sun(elevation_deg=5.0, azimuth_deg=0.0, latitude_deg=20.0, longitude_deg=10.0)
    camera = pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=15.0, fov_y_deg=10.0)
    with renderer_of(scene, (side, side), **turns_of(quality), fine_steps=48) as renderer:
        renderer.settle(camera, sun=low)
        renderer.render(camera, sun=low)
        light = texture(renderer, "clouds.full")[..., 1]
    window = np.hanning(side)
    spectrum = np.abs(np.fft.fft2((light / light.mean() - 1.0) * np.outer(window, window)))
    strong = {}
    for harmonic in range(1, 60):
        x, y = (round(side * ((harmonic * step) % 1.0)) for step in (0.75487766, 0.56984029))
        if math.hypot(min(x, side - x), min(y, side - y)) < 20:
            continue  # where the gradient is
        near, around = (np.ix_(*(np.arange(k - n, k + n + 1) % side for k in (y, x))) for n in (1, 6))
        strong[harmonic] = float(spectrum[near].max() / np.median(spectrum[around]))
    # Of noise the largest of nine values is twice their median in the mean (Rayleigh), and 4.5 times in one of 10^5.
    assert max(strong.values()) < 4.5, strong


def test_turns_are_spread_over_steps() -> None:
    turns = [radical_inverse(k) for k in range(8)]
    assert turns[:4] == [0.0, 0.5, 0.25, 0.75]
    np.testing.assert_allclose(sorted(turns), np.arange(8) / 8.0)
    assert [turn_share(k, 8) for k in range(8)] == turns
    assert [turn_share(k, 4) for k in range(4)] == turns[:4]
    for count in (7, 12):
        np.testing.assert_allclose(sorted(turn_share(k + 5, count) for k in range(count)), np.arange(count) / count)


class _Frame:
    cut = settling = one_shot = still = False
    jitter_px = (0.0, 0.0)
    time_s, size = 0.0, (32, 18)

    def __init__(self, camera: object) -> None:
        self.camera = camera
        self.sun = type("Sun", (), {"direction": np.float64([0.0, 0.0, 1.0])})()


def test_places_in_a_pixel_are_those_of_a_still_picture_alone() -> None:
    """In flight, and while anti-aliasing moves the frame, rays go through the middles of pixels."""
    with pf.Renderer(cloudy(), (32, 18), "low") as renderer:
        frame = _Frame(renderer.camera_state(pf.Camera.at(0.0, 0.0, 1e4)))
    past = History(2, 32, 6.36e6)
    seen = []
    for _ in range(33):
        past.begin(frame, 0)  # type: ignore[arg-type]
        seen.append(past.inside)
    assert past.mode == STILL and seen[0] == (0.0, 0.0)
    places = np.array(seen[1:33:4])
    assert len(np.unique(places, axis=0)) == 2 and np.abs(places).max() < 0.5
    np.testing.assert_allclose(places.mean(axis=0), 0.0, atol=1e-12)
    sparse = History(4, 64, 6.36e6)
    for _ in range(65):
        sparse.begin(frame, 0)  # type: ignore[arg-type]
        assert sparse.inside == (0.0, 0.0)  # four turns are none to spare
    frame.jitter_px = (0.25, 0.0)
    past.begin(frame, 0)  # type: ignore[arg-type]
    assert past.inside == (0.0, 0.0)
    frame.jitter_px, frame.time_s = (0.0, 0.0), 1.0
    past.begin(frame, 0)  # type: ignore[arg-type]
    assert past.mode != STILL and past.inside == (0.0, 0.0)
