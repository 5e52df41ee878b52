"""Weather of a planet: what moves in it, its map, and the noise that fills it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from cloud_kit import cloudy, opacity, renderer_of, texture

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components import Clouds
from planetfall.engine.blocks.bindings import CLOUD_CELLS_UNIT
from planetfall.systems.clouds.field import CloudField
from planetfall.systems.clouds.maps import BORDER
from planetfall.systems.clouds.ours import OurClouds
from planetfall.systems.clouds.view_block import cloud_view_uniforms
from planetfall.systems.clouds.volumes import even_spread, level_deviations
from planetfall.systems.clouds.weather import (
    STEP_S,
    balance_for,
    cyclones_at,
    generations_at,
    moment_of,
    octahedral_weights,
)

DAY_S = 86400.0


def system_of(renderer: pf.Renderer) -> OurClouds:
    found = renderer.system("clouds").method
    assert isinstance(found, OurClouds)
    return found


def map_of(renderer: pf.Renderer, border: bool = False) -> np.ndarray:
    """The first map (rows, columns, 4) in 0..1."""
    maps = system_of(renderer).field.maps
    with renderer.current():
        held = maps.shown[0].read()
    side = maps.size + 2 * BORDER
    whole = np.frombuffer(held, np.uint8).reshape(side, side, 4) / 255.0
    return whole if border else whole[BORDER:-BORDER, BORDER:-BORDER]


def looked_up(chart: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The map's nearest texels: octahedral, +Z in the middle."""
    flat = directions[:, :2] / np.abs(directions).sum(axis=1, keepdims=True)
    folded = (1.0 - np.abs(flat[:, ::-1])) * np.where(flat < 0.0, -1.0, 1.0)
    place = np.where(directions[:, 2:] < 0.0, folded, flat)
    cell = np.clip(((0.5 + 0.5 * place) * len(chart)).astype(int), 0, len(chart) - 1)
    return chart[cell[:, 1], cell[:, 0]]


def even_directions(count: int) -> np.ndarray:
    """(count, 3): a spiral of equal areas, not the map's own weights."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, k * np.pi * (1.0 + 5.0**0.5)
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


@pytest.mark.parametrize("time_s", [0.0, 1.0, 2.5 * DAY_S, 1e8])
def test_generations_of_noise_keep_the_variance_and_are_born_and_die_unseen(time_s: float) -> None:
    weights = np.array([one.weight for one in generations_at(time_s)])
    assert (weights**2).sum() == pytest.approx(1.0, abs=1e-6)
    # At the change of a generation the one that changes weighs nothing: its age jumps, the picture doesn't.
    change = 2.5 * DAY_S * np.ceil(time_s / (2.5 * DAY_S) + 1.0)
    before, after = generations_at(change - 1e-3), generations_at(change + 1e-3)
    jumped = [(a, b) for a, b in zip(before, after, strict=True) if a.seed != b.seed]
    assert len(jumped) == 1
    assert max(abs(one.weight) for one in jumped[0]) < 1e-6


def test_moments_are_in_float64_after_three_years() -> None:
    moment = moment_of(1e8 + 0.001)
    assert moment.first * STEP_S + moment.share * STEP_S == pytest.approx(1e8 + 0.001, abs=1e-6)
    assert 0.0 <= moment.share < 1.0
    assert moment_of(-1.0).first == -1


def test_cyclones_lie_on_the_sphere_wind_as_their_hemisphere_does_and_come_and_go_smoothly() -> None:
    times = np.arange(0.0, 20.0 * DAY_S, 1800.0)
    all_of = [cyclones_at(t, 1) for t in times]
    places = np.array([[c.direction for c in some] for some in all_of])
    kinds = np.array([[(c.winding, c.strength, c.phase) for c in some] for some in all_of])
    np.testing.assert_allclose(np.linalg.norm(places, axis=-1), 1.0, atol=1e-6)
    assert (np.sign(places[..., 2]) == kinds[..., 0]).all()
    # sin^2 over four days or more changes by at most pi / 4 days.
    assert np.abs(np.diff(kinds[..., 1], axis=0)).max() < np.pi / (4.0 * DAY_S) * 1800.0 * 1.01
    moved = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    same = kinds[1:, :, 2] == kinds[:-1, :, 2]
    # 40 degrees of longitude in four days at the equator, and some towards the pole.
    assert moved[same].max() < np.radians(45.0) / (4.0 * DAY_S) * 1800.0
    strength = np.minimum(kinds[1:, :, 1], kinds[:-1, :, 1])[~same]
    assert strength.max() < 1e-3  # who is replaced has died


@pytest.mark.parametrize("coverage", [0.3, 0.6, 0.8])
def test_the_balance_gives_the_mean_cover(coverage: float) -> None:
    raw = np.random.default_rng(3).normal(size=(64, 64))
    weights = octahedral_weights(64)
    level, slope = balance_for(raw, weights, coverage, 0.7)
    assert (np.clip(0.5 + slope * (raw - level), 0.0, 1.0) * weights).sum() == pytest.approx(coverage, abs=1e-9)


def test_octahedral_weights_are_solid_angles() -> None:
    weights = octahedral_weights(128)
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    # The map's middle half in both directions (|x| + |y| < 1/2 is a diamond) against counted directions.
    d = even_directions(200_000)
    flat = d[:, :2] / np.abs(d).sum(axis=1, keepdims=True)
    inside = (np.abs(flat) < 0.5).all(axis=1) & (d[:, 2] > 0.0)
    assert weights[32:96, 32:96].sum() == pytest.approx(inside.mean(), abs=2e-3)


@pytest.mark.parametrize("coverage", [0.45, 0.6])
def test_the_map_has_the_cover_that_was_asked_for_and_its_bands(coverage: float) -> None:
    with renderer_of(cloudy(coverage=coverage)) as renderer:
        renderer.render(pf.Camera.at(0.0, 0.0, 1e7, pitch_deg=-90))
        chart = map_of(renderer)
    d = even_directions(40_000)
    cover = looked_up(chart, d)[:, 0]
    # Balanced on a map of 256 texels a side without its eight-bit steps, at the same moment.
    assert cover.mean() == pytest.approx(coverage, abs=0.01)
    latitude = np.degrees(np.arcsin(d[:, 2]))
    dry = cover[np.abs(np.abs(latitude) - 24.0) < 6.0].mean()
    storms = cover[np.abs(np.abs(latitude) - 52.0) < 6.0].mean()
    assert dry < coverage < storms


def test_the_map_goes_on_across_its_edges() -> None:
    with renderer_of(cloudy()) as renderer:
        renderer.render(pf.Camera.at(0.0, 0.0, 1e7, pitch_deg=-90))
        whole = map_of(renderer, border=True)
    side, b = len(whole), BORDER
    # A texel beyond the left edge lies on the sphere where the inner one does that is turned about the edge's middle.
    np.testing.assert_array_equal(whole[b:-b, b - 1], whole[b:-b, b][::-1])
    np.testing.assert_array_equal(whole[b:-b, 0], whole[b:-b, 2 * b - 1][::-1])
    np.testing.assert_array_equal(whole[side - b, b:-b], whole[side - b - 1, b:-b][::-1])


def test_weather_changes_a_little_in_an_hour_and_much_in_ten_days() -> None:
    with renderer_of(cloudy(wind_speed_m_s=0.0)) as renderer:
        camera = pf.Camera.at(0.0, 0.0, 1e7, pitch_deg=-90)
        maps = []
        for time_s in (0.0, 3600.0, 10.0 * DAY_S):
            renderer.render(camera, time_s=time_s)
            number = moment_of(time_s).first
            system = system_of(renderer)
            with renderer.current():
                held = system.field.maps.texture_of(number).read()
            maps.append(np.frombuffer(held, np.uint8).astype(float))
    hour, days = (np.corrcoef(maps[0], m)[0, 1] for m in maps[1:])
    assert hour > 0.98
    assert days < 0.8


@pytest.mark.parametrize("time_s", [0.0, 10.0 * DAY_S])
def test_earth_is_half_to_two_thirds_under_cloud(time_s: float) -> None:
    """Straight down on 24 regions of 2400 km, weighted by the area they stand for. Satellites find 0.67 of the planet
    under cloud that they can tell from none (King et al. 2013); that is taken to hide a third of what is below."""
    with preset_scene("earth", clouds=True) as earth:
        clouds = earth.planet[pf.Clouds]
        given = {f.name: getattr(clouds, f.name) for f in dataclasses.fields(clouds)}
    found, areas = [], []
    with renderer_of(cloudy(pf.Clouds(**given), air=False), (24, 24), shape_texels=64, fine_steps=48) as renderer:
        for latitude in (-75.0, -45.0, -15.0, 15.0, 45.0, 75.0):
            for longitude in (0.0, 90.0, 180.0, 270.0):
                fov = 2.0 * np.degrees(np.arctan(1.2e6 / 2e7))
                camera = pf.Camera.at(latitude, longitude, 2e7, pitch_deg=-90.0, fov_y_deg=fov)
                sun = pf.Sun(direction=tuple(pf.direction(latitude, longitude)))
                found.append((opacity(renderer, camera, time_s=time_s, sun=sun) > 1.0 / 3.0).mean())
                areas.append(np.cos(np.radians(latitude)))
    assert 0.5 < np.average(found, weights=areas) < 0.7


def test_noise_is_spread_evenly_and_wraps() -> None:
    values = np.random.default_rng(1).normal(size=(16, 16, 16)) ** 3
    spread = even_spread(values)
    np.testing.assert_allclose(np.quantile(spread, [0.1, 0.5, 0.9]), [0.1, 0.5, 0.9], atol=2e-3)
    assert (np.argsort(values.ravel()) == np.argsort(spread.ravel(), kind="stable")).mean() > 0.9
    with renderer_of(cloudy()) as renderer:
        renderer.render(pf.Camera.at(0.0, 0.0, 1e7, pitch_deg=-90))
        held = system_of(renderer).field.shape
        with renderer.current():
            volume = np.frombuffer(held.texture.read(), held.texture.dtype).reshape(32, 32, 32).astype(float)
    np.testing.assert_allclose(np.quantile(volume, [0.1, 0.5, 0.9]), [0.1, 0.5, 0.9], atol=0.01)
    for axis in range(3):
        # Plane by plane: noise is steepest where its lattice lies, and the border is such a place.
        steps = np.abs(np.diff(np.moveaxis(volume, axis, 0), axis=0)).mean(axis=(1, 2))
        across = np.abs(volume.take(0, axis) - volume.take(-1, axis)).mean()
        assert across < 1.1 * steps.max()
    assert held.deviations == pytest.approx(level_deviations(volume.astype(np.float32), 6), abs=2e-3)


def test_shadow_of_an_even_layer_is_what_its_depth_says() -> None:
    scene = cloudy(
        density_model="uniform",
        height_profile="none",
        base_m=1000.0,
        top_m=2000.0,
        extinction_per_m=1e-3,
        asymmetry=0.8,
    )
    camera = pf.Camera.at(20.0, 10.0, 100.0)
    up = np.asarray(pf.direction(20.0, 10.0))
    side = np.cross(up, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    with renderer_of(scene) as renderer:
        for mu in (1.0, 0.6, 0.3):
            sun = pf.Sun(direction=tuple(mu * up + np.sqrt(1.0 - mu * mu) * side))
            renderer.render(camera, sun=sun)
            found = texture(renderer, "clouds.shadow")[0]
            middle = found[28:36, 28:36].mean(axis=(0, 1))
            # Depth 1 straight down; the map is 8 km wide, its middle within 500 m, where the sun stands as high.
            # What droplets throw straight on, g squared of all (Joseph, Wiscombe and Weinman 1976), stays in the beam.
            assert middle[0] == pytest.approx(np.exp(-(1.0 - 0.8**2) / mu), rel=5e-3)
            assert 0.0 < middle[1] < 1.0 - middle[0], "as light from all over the sky"


def test_clouds_have_rims_in_every_weather(scope: Any, run_compute: Any) -> None:
    """Weights of noise whose squares add up to one do so but for rounding, whose sign must not matter."""
    sizes = {"shape": 32, "rim": 16, "fibre": 64, "map": 64}
    field = CloudField(scope, {f"clouds.{name}_texels": texels for name, texels in sizes.items()})
    field.take(Clouds(extinction_per_m=0.05))
    field.place(np.array([6.4e6, 0.0, 0.0]), 6.36e6, 0.0)
    field.block.hiding = (10.0, 1.0, 10.0, 1.0)  # nothing of the noise: as seen from near
    block = cloud_view_uniforms(scope)
    block.write(field.block)

    def bind(_: Any) -> None:
        block.bind()
        field.shape.texture.use(0)
        field.rims.texture.use(1)
        field.cells.texture.use(int(CLOUD_CELLS_UNIT))

    found = run_compute(
        """
        for (int k = 0; k < 48; ++k) {
            vec3 place = vec3(731.0, 1371.0, 2111.0) * float(k);
            CloudWeather w = CloudWeather(0.5, towers, 0.0, 0.6, 0.5);
            differing += abs(cloud_density(0, place, 0.12, w, 1.0, 2) - cloud_density(0, place, 0.12, w, 1.0, 0));
        }""",
        {"towers": np.linspace(0.0, 1.0, 2048)}, {"differing": "float"},
        header='#include "clouds/density.glsl"', setup=bind,
    )  # fmt: skip
    assert found["differing"].min() > 0.0
