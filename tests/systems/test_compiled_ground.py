"""Compiled loops of the ground against numpy: the same bits, or as near as the docs say."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine import compiled
from planetfall.engine.compiled import Kernels, Library, switched
from planetfall.systems.terrain import height_octaves
from planetfall.systems.terrain.crater_paths import found_along
from planetfall.systems.terrain.height import TerrainField, TerrainParams, height
from planetfall.systems.terrain.ray_ground import detail_of, ground_at, layers_at

pytest.importorskip("numba")

PLAIN = TerrainParams(mountains=0.4, hills=0.2, roughness=1.35)
GROUNDS = {
    "plain": PLAIN,
    "few layers": replace(PLAIN, layers=3),
    "without seas": replace(PLAIN, lowest_m=100.0, craters=0.3),
    "asteroid": TerrainParams(radius_m=800.0, highest_m=80.0, lowest_m=-80.0, layers=10, roughness=2.5, craters=0.9),
}


def places(count: int, seed: int = 7) -> np.ndarray:
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def both(ask):
    """What numpy says, and what compiled loops do."""
    with switched(False):
        plain = ask()
    with switched(True):
        return plain, ask()


@pytest.mark.parametrize("name", GROUNDS)
def test_heights_have_the_bits_of_numpy(name):
    d = places(1000)
    plain, fast = both(lambda: height(d, GROUNDS[name]))
    assert np.array_equal(plain, fast)


@pytest.mark.parametrize("preset", ["moon", "mars"])
def test_heights_of_maps_and_craters_have_the_bits_of_numpy(preset):
    sampler, d = pf.TerrainSampler(pf.load_scene(preset)), places(1000)
    plain, fast = both(lambda: sampler.height(d))
    assert np.array_equal(plain, fast)


def test_a_place_has_the_same_bits_alone_and_in_any_batch():
    d = places(700)
    with switched(True):
        whole = height(d, GROUNDS["without seas"])
        alone = np.concatenate([height(d[k : k + 1], GROUNDS["without seas"]) for k in range(0, 700, 50)])
        some = np.concatenate([height(d[k : k + 7], GROUNDS["without seas"]) for k in range(0, 700, 7)])
    assert np.array_equal(whole[::50], alone)
    assert np.array_equal(whole, some)


def test_few_places_differ_by_rounding_alone():
    d = places(40)
    for count in (1, 2, 20):
        plain, fast = both(lambda n=count: height(d[:n], PLAIN))
        assert np.abs(plain - fast).max() < 1e-9


@pytest.mark.parametrize("erosion", [0.3, 1.0])
def test_gullies_agree_to_a_hundred_millionth_of_a_metre(erosion):
    d, params = places(3000), replace(PLAIN, erosion=erosion)
    plain, fast = both(lambda: height(d, params))
    assert np.abs(plain - fast).max() < 1e-8
    with switched(False):
        assert np.abs(plain - height(d, PLAIN)).max() > 1.0  # there are some


def test_gullies_beside_rivers_agree():
    scene = pf.load_scene("earth")
    sampler = pf.TerrainSampler(scene)
    d = places(20_000)
    with switched(False):
        d = d[sampler.height(d) > 0.0][:2000]
    plain, fast = both(lambda: sampler.height(d))
    assert np.abs(plain - fast).max() < 1e-8


@pytest.mark.parametrize("name", ["plain", "without seas"])
def test_what_rays_ask_of_the_ground(name):
    model = height_octaves.model_of(GROUNDS[name])
    feet = np.ascontiguousarray(places(1500).T) * model.params.radius_m
    coarse, fine = detail_of(model, 4096.0), detail_of(model, 16.0)
    assert coarse.layers < fine.layers
    for a, b in zip(*both(lambda: ground_at(feet, coarse)), strict=True):
        assert np.array_equal(a, b)
    plain, fast = both(lambda: layers_at(feet, coarse, fine))
    assert np.abs(plain - fast).max() < 1e-10


def test_lists_of_craters_along_stretches_have_the_bits_and_the_order_of_numpy():
    craters = height_octaves.model_of(GROUNDS["asteroid"]).craters
    assert craters is not None
    rng, radius = np.random.default_rng(3), craters.radius_m
    first = places(400)
    for octave in (0, 2, len(craters) - 1):
        aside = np.cross(first, rng.normal(size=first.shape))
        aside /= np.linalg.norm(aside, axis=1)[:, None]
        last = first + aside * (rng.uniform(0.3, 0.9, len(first)) / (craters.frequency[octave] * radius))[:, None]
        last /= np.linalg.norm(last, axis=1)[:, None]
        ends = first.T * radius, last.T * radius
        length = np.linalg.norm(ends[1] - ends[0], axis=0)
        middle = 0.5 * (ends[0] + ends[1])
        middle *= radius / np.linalg.norm(middle, axis=0)
        number = np.arange(2 * len(first)) // 3
        number[::3] = -1

        def ask(k=octave, ends=ends, length=length, middle=middle, number=number):
            found, *sums = found_along(craters, np.arange(k + 1), ends, length)
            halves, added = found.halves(craters, middle, 0.5 * length, len(length))
            kept = halves.renumbered(number)
            other, *_ = found_along(craters, np.arange(k, k + 1), ends, length)
            lists = [
                part for paths in (found, halves, kept, found.joined(other)) for part in (paths.names, paths.numbers)
            ]
            return [*lists, *sums, added, found.rise(craters, length), halves.rise(craters, np.repeat(0.5 * length, 2))]

        plain, fast = both(ask)
        assert plain[0].shape[1] > 100
        for a, b in zip(plain, fast, strict=True):
            assert np.array_equal(a, b)


@pytest.mark.parametrize("name", ["plain", "without seas", "asteroid"])
def test_rays_and_contacts_agree_to_a_micrometre(name):
    field = TerrainField(GROUNDS[name])
    sampler_up = places(60, 11)
    above, reach = (0.2, 1e3) if name == "asteroid" else (2.0, 1e4)
    from planetfall.systems.terrain.height_march import contact
    from planetfall.systems.terrain.height_rays import raycast

    with switched(False):
        distance = field.radius_m + field.height(sampler_up)
    origins = sampler_up * (distance + above)[:, None]
    level = np.cross(sampler_up, places(60, 12))
    level /= np.linalg.norm(level, axis=1)[:, None]
    (hit, t), (fast_hit, fast_t) = both(lambda: raycast(field, origins, level, np.full(60, reach)))
    assert hit.any()
    assert np.array_equal(hit, fast_hit)
    assert np.abs(t[hit] - fast_t[hit]).max() < 1e-6
    centers = sampler_up * (distance + 0.3)[:, None]
    (depth, _), (fast_depth, _) = both(lambda: contact(field, centers, np.full(60, 0.5)))
    assert np.abs(depth - fast_depth).max() < 1e-6


def test_a_loop_is_compiled_once():
    from planetfall.systems.terrain import crater_kernels, crater_path_kernels, eroded_kernels, height_kernels

    with switched(True):
        for ground in (*GROUNDS.values(), replace(PLAIN, erosion=1.0)):
            field = TerrainField(ground)
            for count in (1, 5, 1300):
                field.height(places(count))
                field.height_slope(places(count))
    for module in (height_kernels, crater_kernels, crater_path_kernels, eroded_kernels):
        found = [v for v in vars(module).values() if getattr(v, "__module__", "") == module.__name__]
        kernels = [v for v in found if hasattr(v, "signatures") and v.stats.cache_path]
        assert kernels
        assert all(len(kernel.signatures) <= 1 for kernel in kernels)


def test_nothing_is_compiled_where_it_is_switched_off_or_cannot_be(monkeypatch):
    package = "planetfall.systems.terrain"
    with switched(False):
        assert Kernels(package, "height_kernels")() is None
    with switched(True):
        assert Kernels(package, "height_kernels")().heights
        monkeypatch.setattr(compiled, "import_module", refused)
        assert Kernels(package, "height_kernels")() is None
    monkeypatch.delenv(compiled.OFF, raising=False)
    assert compiled.wanted()
    monkeypatch.setenv(compiled.OFF, "0")
    assert not compiled.wanted()


def refused(name: str):
    raise ImportError(name)


def test_compiled_code_is_kept_by_the_text_it_was_made_of(monkeypatch, tmp_path, caplog):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))

    def twice(x: float) -> float:
        return 2.0 * x

    for text in ("one", "other", "one", "third", "fourth", "fifth"):
        assert Library("test", [text]).kernel(twice)(1.5) == 3.0
    folders = [path for path in (tmp_path / "compiled" / "test").iterdir()]
    assert len(folders) == 4
    assert any(path.suffix == ".nbc" for path in folders[0].rglob("*"))
    monkeypatch.setenv("PLANETFALL_CACHE", "")
    assert Library("test", ["one"]).kernel(twice)(1.5) == 3.0
    (tmp_path / "file").touch()
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "file"))
    with caplog.at_level(logging.WARNING):
        assert Library("test", ["one"]).kernel(twice)(1.5) == 3.0
    assert "cannot be kept" in caplog.text
