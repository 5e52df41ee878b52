"""Suite peers: files of the peer, what is held against them, and the scenes, on small pictures and made-up numbers."""

from __future__ import annotations

import contextlib
import json
import time
from pathlib import Path
from typing import Any

import msgspec
import pytest

import planetfall as pf
from planetfall.benchmarks import cli
from planetfall.benchmarks.child import answer_of
from planetfall.benchmarks.machine import describe_machine
from planetfall.benchmarks.measure import peer_scenes
from planetfall.benchmarks.measure.peers import STEP_S, WAYS, PageFrames, page_frames
from planetfall.benchmarks.peer_results import (
    FILES,
    SIZE,
    VIEWS,
    PeerResultsError,
    read_peer_results,
    runs_of_peer,
    same_renderer,
)
from planetfall.benchmarks.session import Session
from planetfall.benchmarks.suites import peers as suite
from planetfall.benchmarks.timing import Timing
from planetfall.errors import SettingError

THEIRS = "ANGLE (Mesa/X.org, llvmpipe (LLVM 15.0.6 256 bits), OpenGL 4.5)"
OURS = "llvmpipe (LLVM 15.0.6, 256 bits)"


def run_of_peer(name: str, median_ms: float = 100.0) -> dict[str, Any]:
    """A file's content as a page writes it, fields that nobody reads too."""
    view = {"first_ms": 900.0, "median_ms": median_ms, "p10_ms": median_ms, "p95_ms": median_ms, "n": 20, "calls": 1}
    return {
        "renderer": THEIRS,
        "size": list(SIZE),
        "withClouds": FILES[name].with_clouds,
        "load_ms": 1100.0,
        "views": {view_name: dict(view) for view_name in VIEWS},
        "rss_sum_mb": 1000,
    }


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, median_ms in (("sky", 100.0), ("clouds low", 1000.0), ("clouds high", 4000.0)):
        (tmp_path / FILES[name].name).write_text(json.dumps(run_of_peer(name, median_ms)))
    return tmp_path


def test_a_folder_of_the_peer_is_read(folder: Path) -> None:
    runs = read_peer_results(folder)
    assert list(runs) == list(FILES) and runs["sky"].renderer == THEIRS and not runs["sky"].with_clouds
    assert runs["clouds high"].views["space"].median_ms == 4000.0 and runs["sky"].views["ground"].n == 20
    (folder / FILES["clouds high"].name).unlink()
    assert list(read_peer_results(folder, runs_of_peer("sky"))) == ["sky"], "only what a bench is about is asked for"


def test_what_is_missing_says_what_to_do(folder: Path) -> None:
    with pytest.raises(PeerResultsError, match=r"add --peer-results FOLDER\. docs/benchmarks-howto\.md"):
        read_peer_results(None)
    with pytest.raises(PeerResultsError, match="expected a folder, found nothing of that name"):
        read_peer_results(folder / "nowhere")
    with pytest.raises(PeerResultsError, match="expected a folder, found a file"):
        read_peer_results(folder / FILES["sky"].name)
    (folder / FILES["clouds low"].name).unlink()
    with pytest.raises(PeerResultsError, match=r"gl_c1_low\.json.*measure the peer with clouds at quality low first"):
        read_peer_results(folder)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("size",), [1280, 720], "size: expected 640 x 360, found 1280 x 720"),
        (("withClouds",), False, "withClouds: expected true, found false"),
        (("quality",), "high", 'quality: expected "low", found "high"'),
        (("load_ms",), "soon", r"Expected `float`, got `str` - at `\$\.load_ms`"),
        (("views", "space", "n"), 0, "Expected `int` >= 1"),
        (("views", "space", "first_ms"), -1.0, "Expected `float` > 0"),
        (("views", "space", "p95_ms"), 1.0, r"views\.space: expected p10_ms <= median_ms <= p95_ms"),
        (("views",), {}, "views: ground, air10km, space missing, found none"),
        (("renderer",), None, "Expected `str`, got `null`"),
    ],
)
def test_a_malformed_file_is_named_with_the_place_in_it(
    folder: Path, path: tuple[str, ...], value: Any, said: str
) -> None:
    run: dict[str, Any] = run_of_peer("clouds low")
    place = run
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    file = folder / FILES["clouds low"].name
    file.write_text(json.dumps(run))
    with pytest.raises(PeerResultsError, match=said) as caught:
        read_peer_results(folder)
    assert str(caught.value).startswith(f"{file}: ")


def test_no_json_is_refused(folder: Path) -> None:
    (folder / FILES["sky"].name).write_text("{")
    with pytest.raises(PeerResultsError, match="not a run of the peer"):
        read_peer_results(folder)


def test_a_browser_s_name_of_a_renderer_is_known_again() -> None:
    assert same_renderer(THEIRS, OURS)
    assert same_renderer("ANGLE (NVIDIA Corporation, NVIDIA T4/PCIe/SSE2, OpenGL 4.5.0)", "NVIDIA T4/PCIe/SSE2")
    assert not same_renderer(THEIRS, "llvmpipe (LLVM 15.0.6, 128 bits)")
    assert not same_renderer("ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device), SwiftShader driver)", OURS)
    assert not same_renderer(THEIRS, ""), "nobody knows what it was"


def test_the_command_refuses_before_anything_is_drawn(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setattr(cli, "Session", None)
    with pytest.raises(PeerResultsError, match="add --peer-results FOLDER"):
        cli.bench_main(["peers"])
    with pytest.raises(SettingError, match="--peer-results goes with suite peers"):
        cli.bench_main(["graph", "--peer-results", str(folder)])
    (folder / FILES["sky"].name).write_text("[]")
    with pytest.raises(PeerResultsError, match="gl_c0_default"):
        cli.bench_main(["peers.whole", "--peer-results", str(folder)])
    monkeypatch.setattr(cli, "choose", lambda suites, quick: {"peers": suite.BENCHES})
    assert cli.bench_main([]) == 0 and "left out: peers, which needs --peer-results" in capsys.readouterr().out


def measured(
    monkeypatch: pytest.MonkeyPatch, folder: Path, ms: float, renderer: str = OURS
) -> tuple[dict[str, list[Any]], dict[str, str]]:
    """Rows by bench, and what was skipped, of a suite in which each frame and each start of ours takes `ms`."""
    frames = dict.fromkeys(WAYS, PageFrames(Timing(ms, ms, ms, 5), ms, 2.0 * ms))
    machine = msgspec.structs.replace(describe_machine(None), gl_renderer=renderer)
    monkeypatch.setattr(suite, "page_frames", lambda *_, **__: frames)
    monkeypatch.setattr(suite, "answer_of", lambda *_, **__: {"import": 1.0, "first picture": ms})
    monkeypatch.setattr(Session, "renderer", lambda *_, **__: contextlib.nullcontext())
    monkeypatch.setattr(Session, "machine", lambda _: machine)
    report = Session("peers", "quick", folder).run(suite.BENCHES)
    return {bench: [row for row in report.rows if row.bench == bench] for bench in suite.BENCHES}, report.skipped


def test_rows_are_ratios_to_the_run_they_name(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows, skipped = measured(monkeypatch, folder, 75.0)
    assert not skipped
    cases = {"sky": 2, "clouds": 2, "whole": 4}
    assert {bench: len(rows[bench]) for bench in cases} == {b: n * len(VIEWS) * len(WAYS) for b, n in cases.items()}
    assert {row.error for row in rows["sky"] + rows["whole"]} == {0.75}
    assert {(row.variant.split(";")[0], row.error) for row in rows["clouds"]} == {("low", 0.075), ("high", 0.01875)}
    low = rows["sky"][0]
    assert low.variant == "low; time running" and (low.ms, low.runs, low.extra["p95_ms"]) == (75.0, 5, 75.0)
    assert low.extra["peer_renderer"] == THEIRS and low.extra["same_renderer"] is True and low.extra["peer_n"] == 20
    targets = {(bench, row.variant.split(";")[0]): (row.target, row.met) for bench in cases for row in rows[bench]}
    assert targets == {
        ("sky", "low"): ("<= 0.2", False),
        ("sky", "medium"): ("", None),
        ("clouds", "low"): ("<= 0.07", False),
        ("clouds", "high"): ("<= 0.08", True),
        ("whole", "low, no gullies, rivers and trees"): ("<= 0.6", False),
        ("whole", "low"): ("<= 0.75", True),
        ("whole", "medium"): ("<= 1.2", True),
        ("whole", "high"): ("<= 3", True),
    }
    assert [(row.error, row.target, row.met) for row in rows["start"]] == [(75.0 / 2000.0, "<= 1", True)] * 3


def test_nothing_is_promised_of_another_renderer(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows, _ = measured(monkeypatch, folder, 10.0, "llvmpipe (LLVM 19.1.0, 256 bits)")
    every = [row for found in rows.values() for row in found]
    assert every and all(row.target == "" and row.extra["same_renderer"] is False for row in every)


def test_a_bench_without_its_file_is_skipped_and_the_others_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / FILES["clouds high"].name).unlink()
    rows, skipped = measured(monkeypatch, folder, 10.0)
    assert list(skipped) == ["clouds"] and "gl_c1_high.json" in skipped["clouds"]
    assert rows["sky"] and rows["whole"] and rows["start"] and not rows["clouds"]


def test_the_scenes_have_what_their_names_say() -> None:
    kinds = (pf.Ocean, pf.Clouds, pf.Cover, pf.Atmosphere, pf.Terrain)
    has = {}
    for name, make in peer_scenes.SCENES.items():
        with make() as scene:
            has[name] = {kind.__name__ for kind in kinds if scene.planet.has(kind)}
            height_m = pf.TerrainSampler(scene).height(
                pf.direction(peer_scenes.LATITUDE_DEG, peer_scenes.LONGITUDE_DEG)[None]
            )[0]
            terrain = scene.planet[pf.Terrain]
            if name in ("sky", "clouds"):
                assert abs(height_m) <= 1.0, "a smooth ball"
            else:
                assert height_m > 50.0, "over land"
                assert (terrain.erosion > 0.0, terrain.rivers > 0.0) == ((name == "whole"),) * 2
    assert has == {
        "sky": {"Atmosphere", "Terrain"},
        "clouds": {"Atmosphere", "Terrain", "Clouds"},
        "whole": {"Ocean", "Clouds", "Cover", "Atmosphere", "Terrain"},
        "bare": {"Ocean", "Clouds", "Atmosphere", "Terrain"},
    }
    sun = peer_scenes.sun()
    assert sun.elevation_deg == pytest.approx(25.94, abs=0.02) and sun.azimuth_deg == pytest.approx(69.8, abs=0.05)


@pytest.mark.gpu
def test_frames_are_timed_as_the_page_does(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[tuple[float, tuple[float, ...]]] = []
    render_to = pf.Renderer.render_to

    def noted(self: pf.Renderer, target: Any, camera: pf.Camera, **how: Any) -> None:
        drawn.append((how["time_s"], tuple(self.camera_state(camera).forward)))
        assert how["dt_s"] == STEP_S and how["sun"].elevation_deg > 25.0
        render_to(self, target, camera, **how)

    monkeypatch.setattr(pf.Renderer, "render_to", noted)
    with peer_scenes.SCENES["sky"]() as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
        found = page_frames(renderer, "ground", runs=3, run_up=2)
    assert list(found) == list(WAYS)
    assert all(frames.timing.runs == 3 and frames.p95_ms >= frames.timing.ms > 0.0 for frames in found.values())
    running, turning = drawn[:5], drawn[5:]
    assert [moment_s - peer_scenes.TIME_S for moment_s, _ in running] == pytest.approx([STEP_S * k for k in range(5)])
    assert len({forward for _, forward in running}) == 1 and len({forward for _, forward in turning}) == 5
    assert {moment_s for moment_s, _ in turning} == {peer_scenes.TIME_S}


@pytest.mark.gpu
def test_a_start_is_told_by_stage() -> None:
    module = "planetfall.benchmarks.measure.peer_start"
    marks = answer_of("-m", module, str(time.time()), "sky", "low")
    assert list(marks) == ["interpreter", "import", "renderer", "first picture"]
    assert list(marks.values()) == sorted(marks.values()) and marks["interpreter"] > 0.0
