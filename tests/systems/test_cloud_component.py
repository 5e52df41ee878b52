"""Clouds as a component: checked values, layers, scene files, and what only values together show."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from air_kit import radiance
from cloud_kit import cloudy, renderer_of
from cloud_tables import even, planet_of

import planetfall as pf
from planetfall.components import Atmosphere, Planet
from planetfall.engine.settings import revision
from planetfall.systems.clouds.block import cloud_block
from planetfall.systems.clouds.layers import kind_of
from planetfall.systems.clouds.model import CloudModel
from planetfall.systems.clouds.view_block import CloudKind


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("albedo", 1.5, r"^Clouds\.albedo: expected a number from 0 to 1, found 1\.5\. The nearest .* is 1$"),
        ("asymmetry", 1.0, r"^Clouds\.asymmetry: expected a number from -0\.99 to 0\.99, found 1\.0"),
        ("asymmetry", -1.0, r"The nearest allowed value is -0\.99$"),
        ("extinction_per_m", math.nan, r"^Clouds\.extinction_per_m: .*found nan\. Give a finite number$"),
        ("extinction_per_m", -0.1, r"found -0\.1\. The nearest allowed value is 0$"),
        ("base_m", -1.0, r"^Clouds\.base_m: "),
        ("coverage", 2.0, r"^Clouds\.coverage: "),
        ("density_model", "wether", r"did you mean 'weather'"),
        ("kind", "cirus", r"^Clouds\.kind: .*did you mean 'cirrus'"),
        ("height_profile", "box", r"one of 'parabola', 'none'"),
        ("layers", pf.CloudLayer(), r"^Clouds\.layers: expected a list of CloudLayer, .*Put even one in brackets$"),
        ("layers", [1.0], r"^Clouds\.layers\[0\]: expected a CloudLayer or a table of its fields, found 1\.0$"),
        ("layers", [{"base_m": 1.0}, {"albedo": 2.0}], r"^Clouds\.layers\[1\]\.albedo: .*found 2\.0"),
        ("layers", [{"bas_m": 1.0}], r"^Clouds\.layers\[0\]\.bas_m: unknown key; did you mean 'base_m'"),
        ("layers", [pf.Clouds(layers=[pf.CloudLayer()])], r"expected a CloudLayer, found a Clouds with layers set$"),
    ],
)  # fmt: skip
def test_bad_values_say_field_range_value_and_remedy(field: str, value: object, message: str) -> None:
    clouds = pf.Clouds()
    with pytest.raises(pf.SettingError, match=message):
        setattr(clouds, field, value)
    assert clouds == pf.Clouds()


def test_layers_are_given_as_components_or_tables() -> None:
    cirrus = {"base_m": 8000.0, "top_m": 9000.0}
    for given in (cirrus, pf.CloudLayer(**cirrus), pf.Clouds(**cirrus)):
        assert pf.Clouds(layers=[given]).layers == (pf.CloudLayer(**cirrus),)


def test_a_change_of_a_layer_is_a_change_of_the_clouds() -> None:
    clouds = pf.Clouds(layers=[pf.CloudLayer(base_m=8000.0, top_m=9000.0)])
    before = revision(clouds), revision(clouds, "layers"), revision(clouds, "base_m")
    clouds.layers[0].coverage = 0.1
    assert revision(clouds) != before[0]
    assert revision(clouds, "layers") != before[1]
    assert revision(clouds, "base_m") == before[2]


@pytest.mark.parametrize(
    ("clouds", "air", "message"),
    [
        (pf.Clouds(base_m=3000.0, top_m=2000.0), None, r"Clouds\.base_m \(3000 m\) has to be below top_m \(2000 m\)"),
        (pf.Clouds(base_m=2000.0, top_m=2000.0), None, r"Clouds\.base_m \(2000 m\) has to be below top_m"),
        (pf.Clouds(top_m=7e4), Atmosphere(), r"Clouds\.top_m: expected at most Atmosphere\.thickness_m \(60000 m\)"),
        (pf.Clouds(top_m=2e7), None, r"Clouds\.top_m: expected at most Planet\.radius_m"),
        (pf.Clouds(base_m=1000.0, top_m=1000.01), None, r"Clouds\.top_m: expected at least 1e-08 of Planet\.radius_m"),
        (pf.Clouds(layers=[{"base_m": 9e3, "top_m": 8e3}]), None, r"Clouds\.layers\[0\]\.base_m \(9000 m\) has to be"),
        (pf.Clouds(layers=[{}, {}, {}, {}]), None, r"Clouds\.layers: expected at most 3 further layers, found 4"),
    ],
)
def test_layers_that_cannot_be_are_told_of_with_the_scene(
    clouds: pf.Clouds, air: Atmosphere | None, message: str
) -> None:
    scene = planet_of(even(1000.0, 2000.0, 1e-3), air=air)
    held = scene.planet[pf.Clouds]
    with pytest.raises(pf.SceneError, match=message):
        scene.planet.add(clouds)
    assert scene.planet[pf.Clouds] is held
    parts = {"planet": Planet(), "clouds": clouds} | ({} if air is None else {"atmosphere": air})
    with pytest.raises(pf.SceneError, match=message):
        pf.Scene("bad", parts)


@pytest.mark.gpu
@pytest.mark.parametrize("method", ["ours", "paper_2018"])
def test_a_running_renderer_says_once_what_cannot_be_and_keeps_the_clouds_from_before(method: str) -> None:
    scene = cloudy(method=method, density_model="uniform")
    camera = pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=30.0)
    with renderer_of(scene) as renderer:
        renderer.settle(camera)
        good = radiance(renderer, camera)
        scene.planet[pf.Clouds].base_m = 9000.0
        with pytest.raises(pf.SettingError, match=r"Clouds\.base_m \(9000 m\) has to be below top_m \(4000 m\)"):
            renderer.render(camera)
        np.testing.assert_allclose(radiance(renderer, camera), good, rtol=1e-4)
        scene.planet[pf.Clouds].top_m = 9500.0
        assert np.abs(radiance(renderer, camera) / good - 1.0).max() > 1e-3


@pytest.mark.gpu
@pytest.mark.parametrize("method", ["ours", "paper_2018"])
def test_clouds_that_cannot_be_from_the_first_picture_on_are_told_of_in_each(method: str, tmp_path: Path) -> None:
    scene = cloudy(method=method, density_model="uniform")
    camera = pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=30.0)
    clouds = scene.planet[pf.Clouds]
    with renderer_of(scene) as renderer:
        clouds.base_m = 9000.0
        for _ in range(3):
            with pytest.raises(pf.SettingError, match="has to be below top_m"):
                renderer.render(camera)
        clouds.base_m = 1000.0
        if method == "ours":  # the papers have no maps
            clouds.weather_map = str(tmp_path / "none.png")
            for _ in range(3):
                with pytest.raises(pf.SettingError, match=r"none\.png"):
                    renderer.render(camera)
            clouds.weather_map = ""
        assert np.isfinite(radiance(renderer, camera)).all()


@pytest.mark.parametrize(
    ("fields", "kind"),
    [
        ({"extinction_per_m": 4.9e-3}, CloudKind.CIRRUS),
        ({"extinction_per_m": 5.1e-3}, CloudKind.CUMULUS),
        ({"extinction_per_m": 4.9e-3, "kind": "cumulus"}, CloudKind.CUMULUS),
        ({"extinction_per_m": 5.1e-3, "kind": "cirrus"}, CloudKind.CIRRUS),
        ({"extinction_per_m": 4.9e-3, "kind": "water"}, CloudKind.CUMULUS),
        ({"extinction_per_m": 5.1e-3, "kind": "ice"}, CloudKind.CIRRUS),
        ({"density_model": "uniform", "kind": "cirrus"}, CloudKind.UNIFORM),
    ],
)
def test_a_kind_that_is_said_overrides_the_guess_from_optical_depth(fields: dict[str, Any], kind: CloudKind) -> None:
    assert kind_of(pf.CloudLayer(base_m=1000.0, top_m=2000.0, **fields)) is kind


@pytest.mark.gpu
def test_a_kind_that_is_said_is_drawn_as_the_guessed_one_to_the_bit() -> None:
    scene = cloudy(extinction_per_m=1e-3, radius_m=1e6, coverage=1.0)
    camera = pf.Camera.at(10.0, 20.0, 500.0, pitch_deg=20.0)
    seen = {}
    with renderer_of(scene) as renderer:
        for kind in ("auto", "cirrus", "cumulus"):
            scene.planet[pf.Clouds].kind = kind
            renderer.settle(camera)
            seen[kind] = radiance(renderer, camera)
    np.testing.assert_array_equal(seen["cirrus"], seen["auto"])
    assert np.mean(np.abs(seen["cumulus"] - seen["auto"]) > 0.01 * seen["auto"]) > 0.25


def test_clouds_without_air_may_be_as_high_as_the_planet() -> None:
    model = CloudModel.from_components(Planet(radius_m=6e4), pf.Clouds(top_m=5.9e4), None)
    assert [layer.top_m for layer in model.layers] == [5.9e4]


def test_a_scene_file_keeps_layers(tmp_path) -> None:  # type: ignore[no-untyped-def]
    scene = planet_of(even(1000.0, 2000.0, 1e-3))
    scene.planet[pf.Clouds].layers = [pf.CloudLayer(base_m=8000.0, top_m=9000.0, coverage=0.25)]
    scene.save(tmp_path / "cloudy.toml")
    found = pf.load_scene(tmp_path / "cloudy.toml")
    assert found.planet[pf.Clouds] == scene.planet[pf.Clouds]


def test_the_block_has_only_layers_that_take_light() -> None:
    clouds = even(1000.0, 2000.0, 0.0)
    clouds.layers = [pf.CloudLayer(base_m=8e3, top_m=9e3, extinction_per_m=2e-4), pf.CloudLayer(coverage=0.0)]
    model = CloudModel.from_components(Planet(), clouds, None)
    block = cloud_block(model)
    assert block.layer_count == 1
    assert (block.layers[0].base_m, block.layers[0].top_m) == (8e3, 9e3)
    assert block.layers[0].extinction_per_m == 2e-4
    assert not model.uniform


def test_a_map_with_nan_is_refused_where_it_is_added(tmp_path) -> None:  # type: ignore[no-untyped-def]
    cover = np.full((64, 128), 0.5, np.float32)
    cover[10, 20] = np.nan
    np.save(tmp_path / "cover.npy", cover)
    scene = planet_of(even(1000.0, 2000.0, 1e-3))
    with pytest.raises(pf.SceneError, match=r"cover\.npy.*(NaN|nan|finite)"):
        scene.planet.add(pf.Clouds(weather_map=str(tmp_path / "cover.npy")))
