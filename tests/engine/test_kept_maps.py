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


@pytest.fixture
def cache(tmp_path: Path) -> TableCache:
    return TableCache("maps", tmp_path)


@pytest.mark.parametrize("name", ["rgba8", "rgba16f", "rg32f"])
def test_a_map_comes_back_with_its_bits(name: str, gpu: Gpu, scope: GpuScope, cache: TableCache) -> None:
    kept = KeptMaps(gpu.caps, cache)
    drawn = scope.texture((7, 5), name)
    bits = np.random.default_rng(1).integers(0, 100, len(drawn.read(alignment=1)), np.uint8).tobytes()
    drawn.write(bits, alignment=1)
    kept.save(kept.key("of the sky", 1), drawn)
    again = scope.texture((7, 5), name)
    assert kept.load(kept.key("of the sky", 1), again) and again.read(alignment=1) == bits
    assert not kept.load(kept.key("of the sky", 2), again), "another seed"
    other = KeptMaps(dataclasses.replace(gpu.caps, version="another"), cache)
    assert not other.load(other.key("of the sky", 1), again), "another driver"


def test_bytes_in_a_key_count(gpu: Gpu) -> None:
    kept = KeptMaps(gpu.caps)
    assert kept.key(b"one", 2) == kept.key(b"one", 2) != kept.key(b"two", 2)


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
