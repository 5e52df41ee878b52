"""The printed clouds in pictures: the density texture with its border, every camera and ray, both ways of coupling, the
shadow from one sample, and the exchange with ours."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from air_kit import radiance
from cloud_kit import COARSE, TINY, cloudy, ran

import planetfall as pf
from planetfall.benchmarks.measure import cloud_paper
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components import CloudLayer, Clouds, Terrain
from planetfall.engine.table_cache import TableCache
from planetfall.systems.clouds.paper import ASYMMETRY, SCATTERING
from planetfall.systems.clouds.paper_volume import PaperVolume, border_texels, deep_path, threshold_for

UP = pf.Sun(elevation_deg=60.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=10.0)


def renderer_of(
    scene: pf.Scene,
    size: tuple[int, int] = (32, 18),
    method: str = "paper_2018",
    overrides: Mapping[str, float] = MappingProxyType({}),
) -> pf.Renderer:
    return pf.Renderer(scene, size, "low", {**TINY, **COARSE, "clouds.method": method, **overrides})


def tile_of(volume: PaperVolume) -> np.ndarray:
    size = volume.texture.size[0]
    return np.frombuffer(volume.texture.read(), np.float16).reshape(size, size, size).astype(np.float64)


def read_level(texture: Any, level: int) -> np.ndarray:
    """A mip level through a copy, level by level: moderngl reads only the first of a volume."""
    size = max(texture.size[0] >> level, 1)
    copy = texture.ctx.compute_shader(
        "#version 430\nlayout(local_size_x = 1) in; layout(binding = 0) uniform sampler3D u_all;"
        "layout(std430, binding = 0) buffer B { float values[]; }; uniform int u_level;"
        "void main() { ivec3 at = ivec3(gl_GlobalInvocationID); ivec3 n = textureSize(u_all, u_level);"
        "values[at.x + n.x * (at.y + n.y * at.z)] = texelFetch(u_all, at, u_level).r; }"
    )
    values = texture.ctx.buffer(reserve=4 * size**3)
    texture.use(0)
    values.bind_to_storage_buffer(0)
    copy["u_level"] = level
    copy.run(size, size, size)
    texture.ctx.memory_barrier()
    found = np.frombuffer(values.read(), np.float32).astype(np.float64)
    values.release()
    copy.release()
    return found


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


def test_mip_levels_let_through_what_the_texels_do(scope) -> None:
    """What a column of the layer lets through on average, from every level and from the texels themselves; and next to
    cloud there is no -1, which filtering would mix into its edge."""
    thickness_m, tile_m = 4000.0, 16e3
    volume = PaperVolume(scope, 64, 0.5, tile_m, thickness_m, 250.0, TableCache("clouds", ""), depth=4.5)
    volume.step(1e9)
    tile = tile_of(volume)
    path_m = deep_path(tile, thickness_m / tile_m * 64) * tile_m / 64
    assert volume.extinction_per_m * path_m == pytest.approx(4.5)
    finest = None
    for level in range(7):
        size = 64 >> level
        found = read_level(volume.texture, level).reshape(size, size, size)
        texel_m = tile_m / size
        through = np.exp(-volume.extinction_per_m * np.maximum(found, 0.0) * min(texel_m, thickness_m)).mean()
        if texel_m >= thickness_m:
            finest = through if finest is None else finest
            assert through == pytest.approx(finest, abs=0.01)
        near = np.max([np.roll(found, step, axis) for axis in range(3) for step in (-1, 0, 1)], axis=0)
        assert not ((found < 0.0) & (near > 0.0)).any()
    columns = np.maximum(tile, 0.0).reshape(4, 16, 64, 64).sum(axis=1) * tile_m / 64
    assert finest == pytest.approx(np.exp(-volume.extinction_per_m * columns).mean(), abs=0.05)


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
    sun = pf.Sun(direction=(0.3, -0.8, 0.2))
    # 12 and 1 of 255 in sRGB, where that paper is white.
    dark: dict[tuple[float, float], tuple[float, float]] = {}
    white = max(sun.irradiance) * np.sin(np.radians(16.5)) / np.pi  # what paper on the ground sends back
    with renderer_of(scene, (16, 9), method, {"clouds.paper_depth": 4.5}) as renderer:
        for altitude in (0.0, base - 1e-3, base, base + 1e-3, top, top + 1e-3, 3.0 * top):
            for pitch in (-90.0, -20.0, 0.0, 90.0):
                camera = pf.Camera.at(40.0, 10.0, altitude, pitch_deg=pitch)
                found = radiance(renderer, camera, sun=sun, time_s=1e8) / white
                meets, all_meet = altitude < top or pitch < 0.0, altitude < top  # the layer: rays, each ray
                if (meets and found.mean() < 0.0037) or (all_meet and found.max(axis=2).min() < 3e-4):
                    dark[altitude, pitch] = found.mean(), found.max(axis=2).min()
        dark.pop((0.0, -90.0), None)  # there is no ground to see
        assert not dark
        away = pf.Camera.at(40.0, 10.0, 3.0 * radius_m, pitch_deg=-90.0)
        assert radiance(renderer, away, sun=sun, time_s=1e8).max() > white


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


@pytest.mark.parametrize("altitude_m, fov_y_deg", [(2.0e6, 34.2), (36.0e6, 12.4)], ids=["orbit", "space"])
def test_land_and_sea_show_between_clouds_from_orbit(altitude_m: float, fov_y_deg: float) -> None:
    """Earth's layer at quality paper over even ground, straight down, pixels as wide as those of 320 x 180 in the
    named views: black clouds hide about half of it, and not as an even veil."""
    earth = preset_scene("earth", clouds=True).planet[Clouds]
    black = Clouds(
        base_m=earth.base_m, top_m=earth.top_m, extinction_per_m=earth.extinction_per_m, albedo=0.0, shadows=False,
        skylight=False,
    )  # fmt: skip
    scene = cloudy(black, air=False, radius_m=6.371e6)
    scene.planet.add(Terrain(highest_m=10.0, lowest_m=-10.0))
    camera = pf.Camera.at(12.0, 22.0, altitude_m, pitch_deg=-90.0, fov_y_deg=fov_y_deg)
    with pf.Renderer(scene, (96, 96), "paper", {"clouds.shape_texels": 128, "terrain.method": "ours"}) as renderer:
        renderer.settle(camera, sun=UP)
        dimmed = radiance(renderer, camera, sun=UP)[16:80, 16:80, 1]
        black.extinction_per_m = 0.0
        clear = radiance(renderer, camera, sun=UP)[16:80, 16:80, 1]
    hidden = 1.0 - dimmed / clear
    assert 0.4 <= hidden.mean() <= 0.6
    assert hidden.std() > 0.2  # a veil of half has 0.0, a picture of nothing but whole clouds and gaps 0.5


def test_both_ways_of_coupling_agree_on_thin_cloud_and_differ_in_thick_air() -> None:
    camera = pf.Camera.at(20.0, 10.0, 10.0, pitch_deg=20.0)
    for extinction, alike in ((1e-6, True), (2e-2, False)):
        scene = cloudy(density_model="uniform", extinction_per_m=extinction, shafts=False, base_m=2000.0, top_m=9000.0)
        found = []
        for method in ("paper_2018", "paper_2019"):
            with renderer_of(scene, method=method) as renderer:
                found.append(radiance(renderer, camera, sun=UP))
        off = np.abs(found[0] - found[1]).max() / found[0].max()
        assert (off < 2e-3) == alike


def test_an_opaque_layer_sends_back_what_thick_water_clouds_do() -> None:
    """Light scattered once by a plane layer without end (Chandrasekhar 1960), under a sun 60 degrees high."""
    g, sun = 0.85 * ASYMMETRY, np.sin(np.radians(60.0))
    up, around = np.meshgrid((np.arange(400) + 0.5) / 400.0, (np.arange(400) + 0.5) / 200.0 * np.pi, indexing="ij")
    cosine = -sun * up + np.sqrt(1.0 - sun**2) * np.sqrt(1.0 - up**2) * np.cos(around)
    phase = (1.0 - g * g) / (4.0 * np.pi * (1.0 + g * g - 2.0 * g * cosine) ** 1.5)
    sent = (SCATTERING * phase * sun / (sun + up) * up).mean() * 2.0 * np.pi / sun
    assert sent == pytest.approx(0.76, abs=0.01)


def test_shafts_are_of_2019_and_darken_air_under_clouds() -> None:
    """Under a closed layer the air between the camera and the horizon loses as much of its light as the layer takes."""
    camera = pf.Camera.at(20.0, 10.0, 10.0, pitch_deg=0.0)
    found = {}
    for method, shafts in (("paper_2018", True), ("paper_2019", False), ("paper_2019", True)):
        scene = cloudy(density_model="uniform", extinction_per_m=2e-4, base_m=2000.0, top_m=4000.0, shafts=shafts)
        with renderer_of(scene, method=method) as renderer:
            found[method, shafts] = radiance(renderer, camera, sun=UP)[8].mean()  # just above the horizon
    lit, shaded = found["paper_2019", False], found["paper_2019", True]
    through = np.exp(-2e-4 * 2000.0 / np.sin(np.radians(60.0)))
    assert through * lit < shaded < 0.9 * lit
    assert abs(found["paper_2018", True] / lit - 1.0) < 0.3


def test_the_planets_shadow_climbs_the_clouds() -> None:
    """From 20 km over a layer at 4 km: lit with the sun a degree below the level, dark with it at five."""
    for method in ("paper_2018", "paper_2019"):
        scene = cloudy(air=False, density_model="uniform", extinction_per_m=5e-3, base_m=3000.0, top_m=4000.0)
        with renderer_of(scene, method=method) as renderer:
            camera = pf.Camera.at(20.0, 10.0, 20e3, pitch_deg=-90.0, fov_y_deg=1.0)
            above, below = (
                radiance(renderer, camera, sun=pf.Sun(elevation_deg=-deg, latitude_deg=20.0, longitude_deg=10.0)).mean()
                for deg in (1.0, 5.0)
            )
        assert above > 0.0
        assert below < 1e-3 * above


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
