"""The command line: options, messages, files; with a stand-in for the renderer, so that no GPU is needed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall import extend
from planetfall.cli.main import main
from planetfall.cli.options import CameraOptions, SunOptions, parse_overrides, parse_size
from planetfall.systems.capture import read_arrays, read_png_settings, write_png


class FakeRenderer:
    """Answers like a Renderer; every instance is remembered."""

    made: ClassVar[list[FakeRenderer]] = []

    def __init__(self, scene: Any, size: Any, quality: str = "high", overrides: Any = None, ctx: Any = None) -> None:
        self.scene, self.size, self.quality, self.overrides = scene, size, quality, overrides
        self.rendered: list[tuple[Any, Any]] = []
        self.settled = 0
        self.released = False
        self.graph = SimpleNamespace(explain=lambda name: f"pass {name}", to_mermaid=lambda: "graph LR\n  a --> b")
        FakeRenderer.made.append(self)

    def __enter__(self) -> FakeRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.released = True

    def settle(
        self, camera: Any, time_s: Any = None, sun: Any = None, timeout_s: Any = None, progress: Any = None
    ) -> None:
        self.settled += 1
        if progress:
            progress(1.0)

    def render(
        self, camera: Any, time_s: Any = None, sun: Any = None, outputs: Any = ("color",), dt_s: Any = None
    ) -> dict[str, np.ndarray]:
        self.rendered.append((camera, sun))
        width, height = self.size
        color = np.full((height, width, 3), len(self.rendered) % 200, np.uint8)
        return {name: color if name == "color" else np.zeros((height, width), np.float32) for name in outputs}

    def camera_state(self, camera: Any) -> Any:
        return camera.resolve(self.scene, self.size[0] / self.size[1])

    def passes(self) -> list[Any]:
        return [
            SimpleNamespace(
                name="sky.shade", system="sky", ran=True, skipped_why=None, cpu_ms=0.1, gpu_ms=None, bytes=2e6,
                reads=("frame",), writes=("scene.radiance",),
            )
        ]  # fmt: skip


@pytest.fixture(autouse=True)
def no_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("planetfall.render.renderer")
    module.Renderer = FakeRenderer  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "planetfall.render.renderer", module)
    FakeRenderer.made.clear()


def fails(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The one line that a command ends with; it must end with code 2 and without a traceback."""
    capsys.readouterr()
    assert main(arguments) == 2
    text = capsys.readouterr().err
    assert text.startswith("planetfall: ") and "Traceback" not in text
    return text


def test_two_knobs_behind_one_set(capsys: pytest.CaptureFixture[str]) -> None:
    text = fails(["render", "moon", "--set", "terrain.edge_px=4", "ocean.edge_px=3"], capsys)
    assert "nothing takes 'ocean.edge_px=3'; each takes its own --set: --set ocean.edge_px=3" in text


def test_render_writes_a_picture_with_its_settings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "a.png"
    assert main(["render", "earth", "--view", "high", "--size", "64x36", "--quality", "low",
                 "--set", "terrain.edge_px=10", "-o", str(target)]) == 0  # fmt: skip
    assert Image.open(target).size == (64, 36)
    settings = read_png_settings(target)
    assert settings["view"] == "high" and settings["overrides"] == {"terrain.edge_px": 10}
    assert len(settings["camera"]["position_m"]) == 3
    renderer = FakeRenderer.made[0]
    assert (renderer.quality, renderer.settled, renderer.released) == ("low", 1, True)
    assert capsys.readouterr() == (f"{target}\n", "")  # for a pipe: the file and nothing else


def test_render_writes_all_arrays(tmp_path: Path) -> None:
    target = tmp_path / "a.npz"
    assert main(["render", "--size", "16x9", "--latitude-deg", "10", "--longitude-deg", "-20", "--altitude-m", "5000",
                 "--sun-elevation-deg", "30", "-o", str(target)]) == 0  # fmt: skip
    arrays, settings = read_arrays(target)
    assert set(arrays) >= {"color", "radiance", "distance", "position", "normal", "surface", "camera_position_m"}
    assert np.linalg.norm(arrays["camera_position_m"]) == pytest.approx(6.371e6 + 5000)
    sun = FakeRenderer.made[0].rendered[0][1]
    assert (sun.elevation_deg, sun.latitude_deg, sun.longitude_deg) == (30, pytest.approx(10), pytest.approx(-20))
    assert settings["view"] is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--view", "nera"], "did you mean 'near'?"),
        (["erth"], "did you mean 'earth'?"),
        (["--size", "640"], "expected width x height such as 1280x720, found '640'"),
        (["--size", "0x9"], "at least 1"),
        (["--size", "999999x999999"], "--size: expected at most 65536 pixels a side, found '999999x999999'"),
        (["--set", "edge"], "expected knob=value"),
        (["--latitude-deg", "3"], "missing: --longitude-deg, --altitude-m"),
        (["--latitude-deg", "nan", "--longitude-deg", "0", "--altitude-m", "5"], "latitude_deg"),
        (["--position-m", "0", "0", "0"], "position_m"),
        (["--position-m", "7e6", "0", "0", "--altitude-m", "3"], "exclude each other"),
        (["--view", "near", "--pitch-deg", "3"], "exclude each other"),
        (["--view", "near", "--sun-elevation-deg", "3", "--sun-epoch-s", "4"], "exclude each other"),
        (["--sise", "3"], "--size"),
        (["--above", "clouds"], "sphere"),
    ],
)  # fmt: skip
def test_bad_options_say_what_to_do(
    options: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = fails(["render", *options, "-o", str(tmp_path / "a.png")], capsys)
    assert message in text.replace("\n", " ")
    assert not FakeRenderer.made and not list(tmp_path.iterdir())


def test_a_game_brings_its_own_tables(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", sys.path.copy())
    Path("halos.py").write_text(
        "from dataclasses import dataclass\n"
        "from planetfall import extend\n"
        "@dataclass\n"
        "class Halo:\n"
        "    size: float = extend.knob(2.0, 1.0, 5.0)\n"
        "extend.register(Halo)\n"
    )
    Path("mine.toml").write_text("[planet]\n[halo]\nsize = 3.0\n")
    plain = ["render", "./mine.toml", "--size", "16x9", "-o", "a.png"]
    assert "halo: unknown table" in (text := fails(plain, capsys)) and "(planetfall --import MODULE)" in text
    assert "--import nowhere: No module named 'nowhere'" in fails(["--import", "nowhere", *plain], capsys)
    assert "--import: expected a module" in fails([*plain, "--import"], capsys)
    try:
        for arguments in (["--import", "halos", *plain], [*plain, "--import=halos"]):
            assert main(arguments) == 0
        halo = sys.modules["halos"].Halo
        assert FakeRenderer.made[-1].scene.planet[halo].size == 3.0
    finally:
        if "halos" in sys.modules:
            extend.unregister(sys.modules.pop("halos").Halo)


@pytest.mark.parametrize("command", ["render", "gallery", "record", "graph"])
def test_output_is_checked_before_rendering(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    target = tmp_path / "file" / "a.png"
    text = fails([command, "earth", "-o", str(target)], capsys)
    assert "file" in text and ("is a file" in text or "cannot be made" in text)
    assert not FakeRenderer.made


def test_unknown_suffix(capsys: pytest.CaptureFixture[str]) -> None:
    assert ".png, .exr or .npz" in fails(["render", "-o", "a.jpeg"], capsys)


def test_unknown_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert 'Did you mean "render"' in fails(["rendr"], capsys)


def test_debug_shows_where_it_came_from() -> None:
    with pytest.raises(pf.UnknownNameError):
        main(["render", "erth", "--debug"])


def test_bugs_keep_their_traceback(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def broken(self: Any, *_: Any, **__: Any) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(FakeRenderer, "settle", broken)
    with pytest.raises(ZeroDivisionError):
        main(["render", "-o", str(tmp_path / "a.png")])
    assert FakeRenderer.made[0].released and not list(tmp_path.iterdir())


def test_interrupt(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def stop(self: Any, *_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(FakeRenderer, "settle", stop)
    assert main(["render", "-o", str(tmp_path / "a.png")]) == 130


def test_gallery_resumes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = pf.views("moon")
    folder = tmp_path / "deep" / "gallery"
    command = ["gallery", "moon", "--size", "32x18", "-o", str(folder)]
    assert main(command) == 0
    assert {file.name for file in folder.iterdir()} == {"moon.png", *(f"moon_{name}.png" for name in names)}
    assert read_png_settings(folder / f"moon_{names[0]}.png")["view"] == names[0]
    (folder / f"moon_{names[1]}.png").unlink()
    write_png(folder / f"moon_{names[0]}.png", np.full((18, 32, 3), 250, np.uint8))
    assert main(command) == 0
    assert len(FakeRenderer.made[1].rendered) == 1
    assert np.asarray(Image.open(folder / f"moon_{names[0]}.png"))[0, 0, 0] == 250
    assert main([*command, "--force", "--view", names[0], "--view", names[2]]) == 0
    assert len(FakeRenderer.made[2].rendered) == 2
    said = capsys.readouterr()
    assert said.out == f"{folder / 'moon.png'}\n" * 3 and "--force makes them again" in said.err


def test_a_gallery_of_an_edited_planet_is_made_again(tmp_path: Path) -> None:
    planet, folder = tmp_path / "mine.toml", tmp_path / "gallery"
    command = ["gallery", str(planet), "--view", "space", "--view", "orbit", "--size", "32x18", "-o", str(folder)]
    planet.write_text('base = "moon"\n', encoding="utf-8")
    assert main(command) == 0 and main(command) == 0
    assert len(FakeRenderer.made) == 1
    planet.write_text('base = "moon"\n[terrain]\nseed = 5\n', encoding="utf-8")
    assert main(command) == 0
    assert len(FakeRenderer.made[1].rendered) == 2


def test_record_resumes(tmp_path: Path) -> None:
    command = ["record", "earth", "--count", "6", "--size", "32x18", "-o", str(tmp_path), "--path", "low"]
    assert main([*command, "--no-video"]) == 0
    assert len(list(tmp_path.glob("frame_*.png"))) == 6 and (tmp_path / "contact_sheet.png").exists()
    settings = read_png_settings(tmp_path / "frame_0003.png")
    assert settings["path"] == "low" and settings["time_s"] == pytest.approx(36.0)
    for index in (2, 3, 5):
        (tmp_path / f"frame_{index:04d}.png").unlink()
    assert main([*command, "--no-video"]) == 0
    again = FakeRenderer.made[1]
    # A frame depends on those before it: they are made again, and only the missing ones written.
    assert len(again.rendered) == 6 and again.settled == 1
    assert len(list(tmp_path.glob("frame_*.png"))) == 6
    assert all(sun is not None for _, sun in again.rendered)


def test_record_makes_a_video(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("imageio_ffmpeg")
    assert main(["record", "--count", "4", "--size", "32x18", "-o", str(tmp_path)]) == 0
    assert (tmp_path / "flight.mp4").stat().st_size > 200
    said = capsys.readouterr()
    assert said.out.split() == [str(tmp_path / "contact_sheet.png"), str(tmp_path / "flight.mp4")]
    assert "4 frames" in said.err


def test_record_unknown_path(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "did you mean 'descent'" in fails(["record", "--path", "decent", "-o", str(tmp_path), "--no-video"], capsys)


def test_lists(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["planets"]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in pf.planets()) and "6 371 km" in text
    assert main(["views", "moon"]) == 0
    text = capsys.readouterr().out
    assert "orbit" in text and "beach" not in text


@pytest.mark.parametrize("columns", [80, 140])
def test_table_of_passes_fits_its_window(columns: int) -> None:
    from rich.console import Console

    from planetfall.cli.info import pass_table

    report = SimpleNamespace(
        name="clouds.shadow_blocks", ran=True, cpu_ms=0.1, gpu_ms=12.5, bytes=11_800_000,
        reads=("gbuffer.attributes", "contract.sun_visibility"), writes=("scene.radiance",), skipped_why=None,
    )  # fmt: skip
    console = Console(width=columns)
    with console.capture() as shown:
        console.print(pass_table([report], columns))
    lines = shown.get().splitlines()
    assert len(lines) == 2 and "clouds.shadow_blocks" in lines[1] and "11.8" in lines[1]
    assert ("contract.sun_visibility" in lines[1]) == (columns == 140)


def test_graph(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["graph"]) == 0
    assert "graph LR" in capsys.readouterr().out
    assert main(["graph", "--explain", "sky.shade"]) == 0
    assert "pass sky.shade" in capsys.readouterr().out
    assert main(["graph", "--passes"]) == 0
    assert "sky.shade" in capsys.readouterr().out
    assert main(["graph", "-o", str(tmp_path / "frame.mmd")]) == 0
    assert (tmp_path / "frame.mmd").read_text().startswith("graph LR")


def test_bench_and_stress_pass_their_options_on(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[list[str]] = []
    module = ModuleType("planetfall.benchmarks.cli")
    module.bench_main = lambda arguments: seen.append(arguments) or 3  # type: ignore[attr-defined]
    module.stress_main = lambda arguments: seen.append(arguments) or 0  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "planetfall.benchmarks.cli", module)
    monkeypatch.setattr("planetfall.benchmarks.cli", module, raising=False)
    assert main(["bench", "terrain", "--json", "x.json", "--help"]) == 3
    assert main(["stress", "space", "--seed", "-5"]) == 0
    assert seen == [["terrain", "--json", "x.json", "--help"], ["space", "--seed", "-5"]]


@pytest.mark.parametrize("command", ["fly", "render", "record", "gallery", "planets", "views", "graph"])
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    assert f"planetfall {command}" in capsys.readouterr().out


def test_fly_without_a_display(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if not sys.platform.startswith("linux"):
        pytest.skip("these systems always have a display")
    assert "No display found" in fails(["fly"], capsys)


def test_camera_options_are_those_of_python() -> None:
    camera = CameraOptions(latitude_deg=1, longitude_deg=2, altitude_m=3e5, heading_deg=30, pitch_deg=-10).camera()
    same = pf.Camera.at(1, 2, 3e5, heading_deg=30, pitch_deg=-10)
    assert repr(camera) == repr(same) and np.array_equal(camera.forward, same.forward)
    down = CameraOptions(position_m=(0.0, 0.0, 8e6)).camera()
    np.testing.assert_allclose(down.forward, [0, 0, -1], atol=1e-12)
    assert abs(down.up @ down.forward) < 1e-12


def test_sun_options() -> None:
    with pf.load_scene("earth") as scene:
        scene.sun.angular_radius_rad = 0.01
        camera = pf.Camera.at(5, 6, 100)
        assert SunOptions().sun(scene, camera) is None
        toward = SunOptions(sun_direction=(0.0, 1.0, 0.0)).sun(scene, camera)
        assert toward is not None and toward.angular_radius_rad == 0.01
        assert SunOptions(sun_epoch_s=3.0).sun(scene, camera).epoch_s == 3.0  # type: ignore[union-attr]
        high = SunOptions(sun_elevation_deg=80, sun_latitude_deg=1).sun(scene, camera)
        assert high is not None and (high.latitude_deg, high.longitude_deg) == (1, pytest.approx(6))


def test_small_parsers() -> None:
    assert parse_size("640x360") == parse_size(" 640 X 360 ") == (640, 360)
    assert parse_overrides(("a.b=1", "c=true", "d=[1, 2]", "e = quadtree", 'f="x=y"')) == {
        "a.b": 1, "c": True, "d": [1, 2], "e": "quadtree", "f": "x=y",
    }  # fmt: skip


def test_the_package_runs_as_a_module():
    found = subprocess.run([sys.executable, "-m", "planetfall", "planets"], capture_output=True, text=True, check=False)
    assert found.returncode == 0 and "earth" in found.stdout, found.stderr
    wrong = subprocess.run(
        [sys.executable, "-m", "planetfall", "views", "erth"], capture_output=True, text=True, check=False
    )
    assert wrong.returncode == 2 and "did you mean 'earth'" in wrong.stderr


FLIGHT = """
[path.mine]
kind = "cruise"
latitude_deg = 10.0
longitude_deg = {longitude}
heading_deg = 90.0
speed_m_s = 100.0
altitude_m = 500.0
duration_s = 10.0
"""


@pytest.mark.parametrize("edited", ["flight", "scene", "companion"])
def test_frames_of_an_edited_flight_or_scene_are_not_kept(
    edited: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flights, scene = tmp_path / "flights.toml", tmp_path / "mine.toml"

    def write(longitude: float = 20.0, rocks: int = 1, phase: float = 0.0) -> None:
        flights.write_text(FLIGHT.format(longitude=longitude))
        scene.write_text(
            f"base = 'earth'\n[terrain]\nseed = {rocks}\n[[companions]]\nbase = 'moon'\n"
            f"[companions.orbit]\nphase_deg = {phase}\n"
        )

    command = ["record", str(scene), "--path", "mine", "--paths", str(flights), "--count", "2", "--size", "32x18",
               "--no-video", "-o", str(tmp_path / "out")]  # fmt: skip
    write()
    assert main(command) == 0
    assert main(command) == 0 and len(FakeRenderer.made) == 1  # nothing was edited: all frames are kept
    write(**{"flight": {"longitude": 21.0}, "scene": {"rocks": 2}, "companion": {"phase": 9.0}}[edited])
    assert "other settings" in fails(command, capsys) and len(FakeRenderer.made) == 1
    assert main([*command, "--force"]) == 0 and len(FakeRenderer.made[1].rendered) == 2
