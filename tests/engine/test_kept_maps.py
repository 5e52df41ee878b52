"""Maps on disk: the bits that were drawn, for the same driver and the same sources alone."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from planetfall.engine.gpu import Gpu, GpuScope
from planetfall.engine.gpu.kept_maps import KeptMaps
from planetfall.engine.table_cache import TableCache
from planetfall.systems.clouds.maps import WeatherMaps
from planetfall.systems.clouds.volumes import make_volume


@pytest.fixture
def cache(tmp_path: Path) -> TableCache:
    return TableCache("maps", tmp_path)


@pytest.mark.parametrize("name", ["rgba8", "rgba16f", "rg32f"])
def test_a_map_comes_back_with_its_bits(
    name: str, scope: GpuScope, cache: TableCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = KeptMaps(scope, cache)
    drawn = scope.texture((7, 5), name)
    bits = np.random.default_rng(1).integers(0, 100, len(drawn.read(alignment=1)), np.uint8).tobytes()
    drawn.write(bits, alignment=1)
    kept.save(kept.key("of the sky", 1), drawn)
    again = scope.texture((7, 5), name)
    assert kept.load(kept.key("of the sky", 1), again) and again.read(alignment=1) == bits
    assert not kept.load(kept.key("of the sky", 2), again), "another seed"
    monkeypatch.setattr(scope, "caps", dataclasses.replace(scope.caps, version="another"))
    assert not kept.load(kept.key("of the sky", 1), again), "another driver"


def test_bytes_in_a_key_count(scope: GpuScope) -> None:
    kept = KeptMaps(scope)
    assert kept.key(b"one", 2) == kept.key(b"one", 2) != kept.key(b"two", 2)


def test_volumes_come_back_with_all_levels(scope: GpuScope, cache: TableCache, tmp_path: Path) -> None:
    made = make_volume(scope, 0, 16, cache)
    kept, noise = KeptMaps(scope, cache), np.random.default_rng(2).random((8, 8, 8), np.float32)
    drawn = scope.texture((8, 8, 8), "r32f", noise, levels=4)
    kept.save(kept.key("noise"), drawn)
    again = scope.texture((8, 8, 8), "r32f", levels=4)
    assert kept.load(kept.key("noise"), again) and again.read() == noise.tobytes()
    kept.save(kept.key("again"), again)
    held = [next((tmp_path / "maps").glob(f"{kept.key(name)}.npz")) for name in ("noise", "again")]
    with np.load(held[0]) as first, np.load(held[1]) as second:
        assert first["level3"].view(np.float32)[0] == pytest.approx(noise.mean(), rel=1e-5)
        assert all(np.array_equal(first[name], second[name]) for name in first if name != "key")
    read = make_volume(scope, 0, 16, cache)
    assert read.texture.read() == made.texture.read() and read.deviations == made.deviations


def test_weather_is_drawn_once_for_all_starts(
    gpu: Gpu, scope: GpuScope, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))

    def shown(coverage: float, time_s: float = 0.0) -> tuple[bytes, bytes, int]:
        maps = WeatherMaps(scope, 128)
        maps.take(coverage, None)
        maps.charts.exact(time_s)
        first = maps.shown[0]
        return first.read(), first.read(level=3), maps.tiles_drawn

    drawn, read = shown(0.5), shown(0.5)
    assert drawn[2] > 0 and read[2] == 0
    assert drawn[:2] == read[:2], "coarse levels, too"
    assert shown(0.6)[2] > 0 and shown(0.5, 1e6)[2] > 0


def test_levels_of_an_empty_texture_can_be_filled(gpu: Gpu, scope: GpuScope) -> None:
    texture = scope.texture((8, 4), "r32f", levels=4, filter="linear")
    texture.write(np.arange(32, dtype=np.float32))
    gpu.generate_mipmaps(texture)
    assert np.frombuffer(texture.read(level=3), np.float32)[0] == pytest.approx(15.5)
    volume = scope.texture((4, 4, 4), "r32f", np.arange(64, dtype=np.float32), levels=3)
    assert np.frombuffer(volume.read(), np.float32)[-1] == 63.0
