"""Frames on several workers: the same files as here, whoever is lost on the way; what is refused at once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from countries import hgt_samples, write_fields, write_hgt

import planetfall as pf
from planetfall.capture import farm as farms
from planetfall.capture import recording
from planetfall.capture.carried import packed, unpacked
from planetfall.cli.main import main
from planetfall.engine.gpu.software_threads import OFF
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.systems.terrain.height import TerrainParams

PLAN = """
seed = 5
count = 6
size = [64, 36]
quality = "low"
scene = ["moon", "mine.toml"]
outputs = ["color", "depth"]
[camera]
altitude_m = { log = [500.0, 5000.0] }
"""


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed", reason="the extra farm is not installed")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(OFF, "0")  # two workers on one machine
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
        ) as made:
            yield made


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "plan.toml").write_text(PLAN)
    (tmp_path / "mine.toml").write_text('base = "moon"\nname = "mine"\n[terrain]\nseed = 9\n')
    return tmp_path / "plan.toml"


def files(root: Path) -> dict[str, bytes]:
    return {p.relative_to(root).as_posix(): p.read_bytes() for p in sorted(root.rglob("*")) if p.is_file()}


@pytest.mark.gpu
def test_a_data_set_is_the_same_bytes_and_outlives_a_worker(cluster, plan, tmp_path):
    here = pf.dataset(plan, tmp_path / "here")
    before = {worker.pid for worker in cluster.workers.values()}
    told: list[tuple[int, int]] = []

    def progress(done: int, of: int) -> None:
        if not told:
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
        told.append((done, of))

    there = pf.dataset(plan, tmp_path / "there", scheduler=cluster.scheduler_address, progress=progress)
    assert told == [(n, 6) for n in range(1, 7)]
    assert files(there) == files(here) and len(files(there)) == 3 * 6 + 3
    assert {worker.pid for worker in cluster.workers.values()} != before
    # What is there is kept, and nobody is asked for it.
    assert files(pf.dataset(plan, there, scheduler=cluster.scheduler_address)) == files(here)


@pytest.mark.gpu
def test_a_flight_is_the_same_bytes(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "PART", 2)
    monkeypatch.setattr(recording, "RUN_UP", 1)
    options = {"count": 5, "size": (64, 36), "quality": "low", "video": False}
    with pf.load_scene("mars") as scene:
        here = pf.record(scene, "low", tmp_path / "here", **options)
        told: list[tuple[int, int]] = []
        there = pf.record(scene, "low", tmp_path / "there", scheduler=cluster.scheduler_address,
                          progress=lambda done, of: told.append((done, of)), **options)  # fmt: skip
    assert files(there.folder) == files(here.folder) and len(there.frames) == 5
    assert sorted(told)[-1] == (5, 5) and len(told) == 3


def _echo(common: bytes, job: int) -> dict[str, bytes]:
    return {f"{job}": common, f"{job}.json": b"{}"}


def _slow_echo(common: bytes, job: int) -> dict[str, bytes]:
    time.sleep(0.1)
    return _echo(common, job)


def _fails(common: object, job: int) -> dict[str, bytes]:
    raise pf.SettingError(f"job {job} can't be")


def _ends_its_process(common: object, job: int) -> dict[str, bytes]:
    os.kill(os.getpid(), signal.SIGKILL)


def test_many_jobs_come_once_each_and_land(cluster, tmp_path):
    with farms.Farm(cluster.scheduler_address) as farm:
        for found in farm.results(_echo, b"x" * 1000, range(200)):
            farms.land(tmp_path, found)
        assert len(list(tmp_path.iterdir())) == 400 and (tmp_path / "7").read_bytes() == b"x" * 1000
        with pytest.raises(pf.SettingError, match="job 0 can't be"):
            list(farm.results(_fails, None, range(1)))


def test_a_job_that_ends_every_worker_is_told(cluster):
    told = pytest.raises(pf.expected_errors(), match="ended each worker")
    with farms.Farm(cluster.scheduler_address) as farm, told:
        list(farm.results(_ends_its_process, None, range(1)))


def started(tmp_path, python_path: str) -> tuple[str, list[subprocess.Popen]]:
    """Address of a scheduler, and it and its worker."""
    file = tmp_path / "scheduler.json"
    options = ["--scheduler-file", str(file), "--dashboard-address", ":0"]
    commands = (["scheduler", "--host", "127.0.0.1", "--port", "0"], ["worker", "--nthreads", "1", "--no-nanny"])
    env = {**os.environ, "PYTHONPATH": python_path}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": env, "cwd": tmp_path}
    processes = [subprocess.Popen([sys.executable, "-m", "dask", *c, *options], **quiet) for c in commands]
    end_s = time.monotonic() + 60.0
    while not file.exists() and time.monotonic() < end_s:
        time.sleep(0.1)
    return json.loads(file.read_text())["address"], processes


def test_workers_without_the_package_are_told(tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra farm is not installed")
    (tmp_path / "planetfall").mkdir()
    (tmp_path / "planetfall" / "__init__.py").write_text("raise ModuleNotFoundError('there is none')\n")
    address, processes = started(tmp_path, str(tmp_path))
    try:
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
        with pytest.raises(pf.SettingError, match=r"expected planetfall .*there is none"):
            farms.Farm(address)
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_a_scheduler_that_ends_is_told(tmp_path):
    pytest.importorskip("distributed", reason="the extra farm is not installed")
    address, processes = started(tmp_path, os.pathsep.join(sys.path))
    scheduler = processes[0]
    try:
        with farms.Farm(address) as farm:
            results = farm.results(_slow_echo, b"x", range(1000))
            next(results)
            scheduler.kill()
            with pytest.raises(pf.expected_errors(), match=r"it is gone.*run the same command again"):
                list(results)
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_an_address_without_a_scheduler_is_told_in_seconds(plan, tmp_path, capsys):
    pytest.importorskip("distributed", reason="the extra farm is not installed")
    for address in ("tcp://127.0.0.1:9", "nonsense", "tcp://no-such-host.invalid:8786", "http://127.0.0.1:9", ""):
        started = time.monotonic()
        assert main(["dataset", str(plan), "-o", str(tmp_path / "out"), "--scheduler", address]) == 2
        said = capsys.readouterr().err
        assert "expected the address of a running Dask scheduler" in said.replace("\n", " ") and repr(address) in said
        assert time.monotonic() - started < 3.0 * farms.CONNECT_S and not (tmp_path / "out").exists()
    assert main(["record", "moon", "--scheduler", "tcp://127.0.0.1:9", "-o", str(tmp_path / "film"), "--no-video"]) == 2
    assert "running Dask scheduler" in capsys.readouterr().err.replace("\n", " ")


def test_a_missing_extra_is_named(plan, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(pf.SettingError, match=r'pip install "planetfall\[farm\]"'):
        pf.dataset(plan, tmp_path / "out", scheduler="tcp://127.0.0.1:9")


TILES = """
seed = 3
count = 3
size = [48, 27]
quality = "low"
scene = "country.toml"
outputs = ["color", "depth"]
[camera]
latitude_deg = { uniform = [46.2, 46.8] }
longitude_deg = { uniform = [7.2, 7.8] }
altitude_m = 2500.0
"""


@pytest.fixture
def country(tmp_path):
    """A plan over a tile of 9 seconds that doesn't fit into memory."""
    rough = hgt_samples(46, 7, 801) + np.random.default_rng(1).normal(0.0, 12.0, (801, 801))
    write_hgt(tmp_path / "tiles", 46, 7, 801, np.rint(rough).astype(np.int16))
    (tmp_path / "country.toml").write_text(
        'base = "earth"\n[terrain]\nrivers = 0.0\nheight_map = "tiles"\nheight_map_most_mb = 1.0\n'
    )
    (tmp_path / "plan.toml").write_text(TILES)
    return tmp_path / "plan.toml"


@pytest.mark.parametrize("knob", ["height_map", "color_map"])
def test_tiles_are_refused_before_anything_is_made(country, tmp_path, knob):
    """And before a scheduler is asked for."""
    scene = tmp_path / "country.toml"
    scene.write_text(scene.read_text().replace("height_map =", f"{knob} ="))
    if knob == "color_map":
        write_fields(tmp_path / "tiles", 12, 46.5, 7.5)
        scene.write_text(scene.read_text().replace("height_map_most_mb = 1.0\n", ""))
    told = rf"Terrain\.{knob} names a folder of tiles, .*tiles, which can't be sent.*--frames A:B"
    with pytest.raises(pf.SceneError, match=told):
        pf.dataset(country, tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    with pf.load_scene(scene) as found, pytest.raises(pf.SceneError, match=told):
        pf.record(found, "low", tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    assert not (tmp_path / "out").exists()


@pytest.mark.gpu
def test_frames_over_tiles_that_stream_are_the_same_in_any_order(country, tmp_path):
    """As several machines make them that each have the folder: nothing of a frame hangs on what was seen before."""
    with pf.load_scene(tmp_path / "country.toml") as scene:
        real = TerrainParams.from_component(scene.planet[pf.Terrain], scene.planet[pf.Planet].radius_m).real
        assert isinstance(real, StreamedGround)
    here = pf.dataset(country, tmp_path / "here")
    for number in (2, 0, 1):
        there = pf.dataset(country, tmp_path / "there", frames=[number])
    assert files(there) == files(here)


def test_scenes_travel_whole_or_not_at_all():
    with pf.load_scene("earth_moon") as scene:
        scene.sun.elevation_deg = 12.0
        with unpacked(packed(scene)) as again:
            assert list(again.planets) == list(scene.planets) and again.sun.elevation_deg == 12.0
    with pf.load_scene("earth") as scene:
        scene.planet.add(pf.Cover()).mask = pf.clearing((6.371e6, 0.0, 0.0), 100.0)
        with pytest.raises(pf.SceneError, match=r"Cover\.mask can't be sent"):
            packed(scene)
