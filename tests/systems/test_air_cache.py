"""Tables on disk: who computes, what a file has to be, folders that don't work, two processes at once."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from air_kit import HAZY, TINY, at, bare, dispatches, job_of, radiance, ran, renderer_of, settled

import planetfall as pf
from planetfall.components import Atmosphere
from planetfall.engine.table_cache import TableCache

KITS = Path(__file__).parents[1] / "kits"
CAMERA = at(3000.0, pitch_deg=5.0)
SHAPES = {"one": (2, 3), "two": (4,)}
ARRAYS = {"one": np.arange(6, dtype=np.float32).reshape(2, 3), "two": np.ones(4, np.float32)}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))
    yield tmp_path / "atmosphere"


# -- files -----------------------------------------------------------------------------------------------------------


def test_what_is_saved_is_loaded(folder: Path) -> None:
    cache = TableCache("atmosphere")
    assert cache.folder == folder
    assert cache.load("key", SHAPES) is None
    cache.save("key", ARRAYS)
    found = cache.load("key", SHAPES)
    assert found is not None
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(found[name], array)
    assert [path.name for path in folder.iterdir()] == ["key.npz"]


def spoil(path: Path, how: str) -> None:
    whole = path.read_bytes()
    if how == "empty":
        path.write_bytes(b"")
    elif how == "truncated":
        path.write_bytes(whole[: len(whole) // 2])
    elif how == "noise":
        path.write_bytes(np.random.default_rng(1).bytes(5000))
    elif how == "one bit":
        place = whole.index(ARRAYS["one"].tobytes()) + 5
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1 :])
    elif how == "another's":
        TableCache("atmosphere", path.parent.parent).save("other", ARRAYS)
        os.replace(path.parent / "other.npz", path)
    elif how == "other arrays":
        np.savez(path, key=np.array("key"), three=np.ones(3))
    elif how == "other shape":
        np.savez(path, key=np.array("key"), one=np.ones((3, 2)), two=np.ones(4))
    elif how == "not a number":
        np.savez(path, key=np.array("key"), one=np.full((2, 3), np.nan), two=np.ones(4))
    elif how == "infinite":
        np.savez(path, key=np.array("key"), one=np.ones((2, 3)), two=np.full(4, 1e300))
    elif how == "objects":
        np.savez(path, key=np.array("key"), one=np.array([[object()] * 3] * 2), two=np.ones(4))
    elif how == "a folder":
        path.unlink()
        path.mkdir()


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize(
    "how",
    ["empty", "truncated", "noise", "one bit", "another's", "other arrays", "other shape", "not a number", "infinite",
     "objects", "a folder"],
)  # fmt: skip
def test_a_file_that_is_not_what_it_should_be(folder: Path, how: str, caplog: pytest.LogCaptureFixture) -> None:
    cache = TableCache("atmosphere")
    cache.save("key", ARRAYS)
    spoil(folder / "key.npz", how)
    with caplog.at_level(logging.WARNING):
        assert cache.load("key", SHAPES) is None
    assert "key.npz" in caplog.text
    cache.save("key", ARRAYS)
    assert how == "a folder" or cache.load("key", SHAPES) is not None


def test_a_folder_that_cannot_be_made_is_logged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "file"))
    cache = TableCache("atmosphere")
    with caplog.at_level(logging.WARNING):
        assert cache.load("key", SHAPES) is None
        cache.save("key", ARRAYS)
    assert "cannot be kept" in caplog.text


def test_an_empty_variable_means_no_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PLANETFALL_CACHE", "")
    monkeypatch.chdir(tmp_path)
    cache = TableCache("atmosphere")
    cache.save("key", ARRAYS)
    assert cache.load("key", SHAPES) is None
    assert not list(tmp_path.iterdir())


def test_files_used_last_are_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("planetfall.engine.table_cache.KEPT", 3)
    cache = TableCache("atmosphere")
    now = time.time()
    for k in range(3):
        cache.save(f"key{k}", ARRAYS)
        os.utime(folder / f"key{k}.npz", (now - 1000.0 + k, now - 1000.0 + k))
    for name, age in (("left.part", 7200.0), ("growing.part", 1.0)):
        (folder / name).write_bytes(b"half")
        os.utime(folder / name, (now - age, now - age))
    assert cache.load("key0", SHAPES) is not None
    cache.save("key3", ARRAYS)
    assert sorted(path.name for path in folder.iterdir()) == ["growing.part", "key0.npz", "key2.npz", "key3.npz"]


def test_large_files_make_room(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = TableCache("atmosphere")
    cache.save("key0", ARRAYS)
    size, now = (folder / "key0.npz").stat().st_size, time.time()
    os.utime(folder / "key0.npz", (now - 1000.0, now - 1000.0))
    monkeypatch.setattr("planetfall.engine.table_cache.KEPT_BYTES", 2 * size)
    for k in (1, 2):
        cache.save(f"key{k}", ARRAYS)
        os.utime(folder / f"key{k}.npz", (now - 500.0 + k, now - 500.0 + k))
    assert sorted(path.stem for path in folder.iterdir()) == ["key1", "key2"]
    # One that is larger than all that may be kept is of use too.
    monkeypatch.setattr("planetfall.engine.table_cache.KEPT_BYTES", size // 2)
    cache.save("key3", ARRAYS)
    assert [path.stem for path in folder.iterdir()] == ["key3"]


# -- the renderer ----------------------------------------------------------------------------------------------------


@pytest.mark.gpu
def test_the_second_start_computes_nothing(folder: Path) -> None:
    with renderer_of(bare()) as renderer:
        final = settled(renderer, CAMERA)
    files = {path: path.read_bytes() for path in folder.iterdir()}
    assert len(files) == 1
    with renderer_of(bare()) as renderer:
        # Two for the camera's tables.
        assert dispatches(renderer, lambda: radiance(renderer, CAMERA)) == 2
        assert job_of(renderer).done and "atmosphere.tables" not in ran(renderer)
        np.testing.assert_array_equal(radiance(renderer, CAMERA), final)
    assert {path: path.read_bytes() for path in folder.iterdir()} == files


@pytest.mark.gpu
@pytest.mark.parametrize("how", ["truncated", "not a number"])
def test_a_spoilt_file_is_computed_again(folder: Path, how: str, caplog: pytest.LogCaptureFixture) -> None:
    with renderer_of(bare()) as renderer:
        final = settled(renderer, CAMERA)
    (path,) = folder.iterdir()
    if how == "truncated":
        path.write_bytes(path.read_bytes()[:2000])
    else:
        with np.load(path) as held:
            arrays = {name: held[name].copy() for name in held.files}
        arrays["moments"][-1, -1, -1, 0] = np.nan
        np.savez(path, **arrays)
    with caplog.at_level(logging.WARNING), renderer_of(bare()) as renderer:
        np.testing.assert_array_equal(settled(renderer, CAMERA), final)
    assert path.name in caplog.text
    caplog.clear()
    with caplog.at_level(logging.WARNING), renderer_of(bare()) as renderer:
        radiance(renderer, CAMERA)
        assert job_of(renderer).done, "written again"
    assert not caplog.records


@pytest.mark.gpu
def test_it_works_without_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "file"))
    with caplog.at_level(logging.WARNING), renderer_of(bare()) as renderer:
        final = settled(renderer, CAMERA)
    assert "cannot be kept" in caplog.text
    monkeypatch.setenv("PLANETFALL_CACHE", "")
    with renderer_of(bare()) as renderer:
        np.testing.assert_array_equal(settled(renderer, CAMERA), final)


@pytest.mark.gpu
def test_the_key_tells_all_that_matters_apart(folder: Path, tmp_path: Path) -> None:
    def key(scene: pf.Scene, **changes: object) -> str:
        with renderer_of(scene, **changes) as renderer:
            radiance(renderer, CAMERA)
            job = job_of(renderer)
            assert job.wanted is not None
            return job.wanted[0]

    normal = key(bare())
    assert key(bare()) == normal
    # Neither the camera's tables nor the budget nor the night's light are in the tables.
    assert key(bare(), columns=16, rows=16, slices=5, budget_ms=1.0) == normal
    assert key(bare(Atmosphere(night_light=0.0, wavelengths_nm=(700.0, 500.0, 400.0)))) == normal
    others = [key(bare(), **{name: TINY[f"atmosphere.{name}"] + 1})
              for name in ("altitudes", "sun_heights", "directions", "march", "degree", "orders")]  # fmt: skip
    others += [
        key(bare(radius_m=6.3e6)),
        key(bare(Atmosphere(thickness_m=61e3))),
        key(bare(Atmosphere(mie_scattering_per_m=HAZY, mie_extinction_per_m=HAZY))),
        key(bare(Atmosphere(mie_asymmetry=0.7))),
        key(bare(Atmosphere(absorption_center_m=24e3))),
        key(bare(Atmosphere(ground_albedo=(0.1, 0.1, 0.2)))),
        key(bare(), method="paper"),
    ]
    scene = bare()
    scene.sun.angular_radius_rad = 0.01
    others.append(key(scene))
    assert len({normal, *others}) == 1 + len(others)


@pytest.mark.gpu
def test_two_processes_at_once(folder: Path) -> None:
    """Both compute, both write the same file, and what is left is whole."""
    text = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parents[1] / 'kits')!r})\n"
        "from air_kit import *\n"
        "with renderer_of(bare()) as renderer:\n"
        "    print(repr(float(settled(renderer, at(3000.0, pitch_deg=5.0)).sum())))\n"
    )
    started = [
        subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    said = [process.communicate(timeout=120) for process in started]
    assert [process.returncode for process in started] == [0, 0], said
    assert said[0][0] == said[1][0]
    (path,) = folder.iterdir()
    with renderer_of(bare()) as renderer:
        assert repr(float(radiance(renderer, CAMERA).sum())) == said[0][0].strip()
        assert job_of(renderer).done
        job = job_of(renderer)
        assert job.wanted is not None and job.wanted[0] == path.stem
