"""The printed clouds in pictures: the density texture with its border, every camera and ray, both ways of coupling, the
shadow from one sample, and the exchange with ours."""

from __future__ import annotations

import numpy as np
import pytest
from air_kit import radiance
from cloud_kit import COARSE, TINY, cloudy, ran

import planetfall as pf
from planetfall.benchmarks.measure import cloud_paper
from planetfall.components import CloudLayer, Clouds, Terrain
from planetfall.engine.table_cache import TableCache
from planetfall.systems.clouds.paper_volume import PaperVolume, border_texels, threshold_for

UP = pf.Sun(elevation_deg=60.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=10.0)


def renderer_of(scene: pf.Scene, size: tuple[int, int] = (32, 18), method: str = "paper_2018") -> pf.Renderer:
    return pf.Renderer(scene, size, "low", {**TINY, **COARSE, "clouds.method": method})


def tile_of(volume: PaperVolume) -> np.ndarray:
    size = volume.texture.size[0]
    return np.frombuffer(volume.texture.read(), np.float16).reshape(size, size, size).astype(np.float64)


# -- the texture ----------------------------------------------------------------------------------------------------


def test_the_border_is_as_wide_as_a_large_step_all_around_and_no_wider(scope) -> None:
    volume = PaperVolume(scope, 32, 0.5, 16e3, 2500.0, 1000.0, TableCache("clouds", ""))
    assert not volume.done and volume.texture.size == (16, 16, 16)
    volume.step(1e9)
    tile = tile_of(volume)
    assert volume.done and tile.shape == (32, 32, 32)
    assert set(np.unique(tile[tile <= 0.0])) == {-1.0, 0.0}
    assert tile.max() <= 1.0
    border = border_texels(1000.0, 16e3, 32)
    assert border == 3  # 1000 m are two texels, and one for the filter
    clouds = np.argwhere(tile > 0.0)
    rng = np.random.default_rng(1)
    for least, most, value in ((border + 1e-9, np.inf, -1.0), (0.0, border + 1e-9, 0.0)):
        cells = np.argwhere(tile == value)
        for cell in cells[rng.integers(len(cells), size=60)]:
            away = np.abs(clouds - cell)
            away = np.minimum(away, 32 - away)  # on the torus: borders go on beyond the texture's sides
            assert least <= np.sqrt((away**2).sum(axis=1)).min() <= most


def test_the_noise_has_no_seam(scope) -> None:
    """From the last texel to the first, density changes as it does from any to the next."""
    volume = PaperVolume(scope, 32, 0.5, 16e3, 2500.0, 250.0, TableCache("clouds", ""))
    volume.step(1e9)
    cloud = np.maximum(tile_of(volume), 0.0)
    for axis in range(3):
        steps = np.abs(np.diff(cloud, axis=axis)).mean(axis=tuple(k for k in range(3) if k != axis))
        seam = np.abs(cloud.take(0, axis) - cloud.take(-1, axis)).mean()
        assert seam < 1.3 * steps.max()


def test_the_threshold_leaves_the_share_of_the_sky_that_is_asked_for() -> None:
    noise = np.random.default_rng(3).normal(size=(64, 64, 64)).astype(np.float32)
    for coverage in (0.1, 0.5, 0.9):
        cut = threshold_for(noise, coverage, 20.0)
        under = (noise[16:30] > cut).any(axis=0).mean()  # 14 texels: where a parabola is above a half
        assert under == pytest.approx(coverage, abs=0.02)


def test_a_full_texture_comes_from_the_cache(scope, tmp_path) -> None:  # type: ignore[no-untyped-def]
    cache = TableCache("clouds", tmp_path)
    first = PaperVolume(scope, 32, 0.5, 16e3, 2500.0, 250.0, cache)
    first.step(1e9)
    again = PaperVolume(scope, 32, 0.5, 16e3, 2500.0, 250.0, cache)
    assert again.done
    np.testing.assert_array_equal(tile_of(again), tile_of(first))
    assert not PaperVolume(scope, 32, 0.6, 16e3, 2500.0, 250.0, cache).done


# -- the march ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["paper_2018", "paper_2019"])
@pytest.mark.parametrize("radius_m", [1e3, 6.36e6, 7e7])
def test_every_camera_and_ray_sees_light(method: str, radius_m: float) -> None:
    base, top = (50.0, 90.0) if radius_m < 1e5 else (1500.0, 4000.0)
    scene = cloudy(radius_m=radius_m, base_m=base, top_m=top, coverage=0.7)
    with renderer_of(scene, (16, 9), method) as renderer:
        for altitude in (0.0, base - 1e-3, base, base + 1e-3, top, top + 1e-3, 3.0 * top, 3.0 * radius_m):
            for pitch in (-90.0, -20.0, 0.0, 90.0):
                camera = pf.Camera.at(40.0, 10.0, altitude, pitch_deg=pitch)
                radiance(renderer, camera, sun=pf.Sun(direction=(0.3, -0.8, 0.2)), time_s=1e8)


def test_an_even_layer_takes_as_much_as_its_depth_says() -> None:
    """Straight down through a parabola: two thirds of extinction and thickness; steps of a fortieth are good to a
    percent of that depth."""
    scene = cloudy(air=False, density_model="uniform", extinction_per_m=5e-4, albedo=0.0, base_m=1000.0, top_m=3000.0)
    scene.planet.add(Terrain(highest_m=10.0, lowest_m=-10.0))
    camera = pf.Camera.at(20.0, 10.0, 8000.0, pitch_deg=-90.0, fov_y_deg=1.0)
    with renderer_of(scene) as renderer:
        dimmed = radiance(renderer, camera, sun=UP)
    scene.planet[Clouds].coverage = 0.0
    with renderer_of(scene) as renderer:
        clear = radiance(renderer, camera, sun=UP)
    depth = 5e-4 * 2000.0 * 2.0 / 3.0
    # The ground lies in the shadow of the same layer, as printed: one sample in its middle, which is 3/2 of the mean.
    shadow = np.exp(-5e-4 * 2000.0 / np.sin(np.radians(60.0)))
    assert (dimmed / clear)[clear > 0.0].mean() == pytest.approx(np.exp(-depth) * shadow, rel=0.08)


def test_both_ways_of_coupling_agree_on_thin_cloud_and_differ_in_thick_air() -> None:
    camera = pf.Camera.at(20.0, 10.0, 10.0, pitch_deg=20.0)
    for extinction, alike in ((1e-6, True), (2e-2, False)):
        scene = cloudy(density_model="uniform", extinction_per_m=extinction, base_m=2000.0, top_m=9000.0)
        found = []
        for method in ("paper_2018", "paper_2019"):
            with renderer_of(scene, method=method) as renderer:
                found.append(radiance(renderer, camera, sun=UP))
        off = np.abs(found[0] - found[1]).max() / found[0].max()
        assert (off < 2e-3) == alike


def test_the_sources_have_one_layer_and_clouds_in_no_mirror() -> None:
    one, two = cloudy(coverage=0.5), cloudy(coverage=0.5)
    two.planet[Clouds].layers = (CloudLayer(base_m=8000.0, top_m=9000.0, density_model="uniform"),)
    camera = pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=30.0)
    with renderer_of(one) as first, renderer_of(two) as second:
        np.testing.assert_array_equal(radiance(first, camera, sun=UP), radiance(second, camera, sun=UP))
        assert ran(first) == {"clouds.march"}


# -- beside ours ----------------------------------------------------------------------------------------------------


def test_methods_are_exchanged_while_a_renderer_runs() -> None:
    scene = cloudy(coverage=0.6)
    camera = pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=30.0)
    with pf.Renderer(scene, (32, 18), "low", {**TINY, **COARSE}) as renderer:
        renderer.settle(camera, sun=UP)
        ours = radiance(renderer, camera, sun=UP)
        assert "clouds.resolve" in ran(renderer)
        held = renderer.gpu.counts()["clouds"]
        scene.planet[Clouds].method = "paper_2019"
        renderer.settle(camera, sun=UP)
        printed = radiance(renderer, camera, sun=UP)
        assert ran(renderer) == {"clouds.march"}
        scene.planet[Clouds].method = "ours"
        renderer.settle(camera, sun=UP)
        # To the rounding of the air's tables, which are filled anew; another cloud is a tenth of the light away.
        np.testing.assert_allclose(radiance(renderer, camera, sun=UP), ours, rtol=1e-4)
        assert renderer.gpu.counts()["clouds"] == held
        assert np.abs(printed / ours - 1.0).max() > 0.05


def test_no_pass_where_there_is_nothing_to_see() -> None:
    scene = cloudy(coverage=0.6)
    with renderer_of(scene) as renderer:
        renderer.render(pf.Camera.at(20.0, 10.0, 1e7, pitch_deg=90.0), sun=UP)
        assert not ran(renderer)
        renderer.render(pf.Camera.at(20.0, 10.0, 1e3), sun=UP)
        assert ran(renderer) == {"clouds.march"}
        scene.planet[Clouds].coverage = 0.0
        renderer.render(pf.Camera.at(20.0, 10.0, 1e3), sun=UP)
        assert not ran(renderer)


def test_the_bench_marches_both_methods_through_the_printed_texture(monkeypatch: pytest.MonkeyPatch) -> None:
    """As far as one picture of each goes: there are clouds in it."""
    monkeypatch.setattr(cloud_paper, "TEXELS", 32)
    camera, found = pf.Camera.at(20.0, 10.0, 3e4, pitch_deg=-90.0), {}
    for method in (None, "paper_2018", "ours"):
        with cloud_paper.renderer_of((48, 27), method, stride=1) as renderer:
            renderer.settle(camera, sun=UP)
            found[method] = radiance(renderer, camera, sun=UP)[..., 0]
    for method in ("paper_2018", "ours"):
        assert (np.abs(found[method] / found[None] - 1.0) > 0.25).mean() > 0.05, method
