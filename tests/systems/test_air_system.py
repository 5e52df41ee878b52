"""The air's system: what runs when, live changes, bad input, hot reload, progress."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from air_kit import HAZY, air_of, at, bare, dispatches, job_of, radiance, ran, renderer_of, settled

import planetfall as pf
from planetfall import ASSETS
from planetfall.components import Atmosphere
from planetfall.systems.atmosphere import job as job_module
from planetfall.systems.atmosphere.tables import QUICK

pytestmark = pytest.mark.gpu

TABLES, VIEW = "atmosphere.tables", "atmosphere.view"
NEVER_SEEN = (1.7e-6, 3.9e-6, 9.5e-6)
CAMERA = at(3000.0, pitch_deg=5.0)


@pytest.fixture
def scene() -> pf.Scene:
    return bare()


@pytest.fixture
def renderer(scene: pf.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[pf.Renderer]:
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))
    with renderer_of(scene) as made:
        yield made
        assert made.ctx.error == "GL_NO_ERROR"


def thicken(scene: pf.Scene, times: float = 1.7) -> None:
    air = scene.planet[pf.Atmosphere]
    air.rayleigh_scattering_per_m = tuple(times * v for v in air.rayleigh_scattering_per_m)


# -- presence --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planet", ["moon", "asteroid"])
def test_a_planet_without_air_has_nothing_of_it(planet: str) -> None:
    with pf.Renderer(pf.load_scene(planet), size=(32, 18), quality="low") as renderer:
        renderer.render(pf.Camera.at(0.0, 0.0, 1000.0))
        assert not [r.name for r in renderer.passes() if r.name.startswith("atmosphere")]
        assert "atmosphere" not in renderer.gpu.counts()
        assert renderer.system("atmosphere") is None
        assert renderer.world.try_resource("air_top_m") is None
        for file in ("sky/background.frag", "sky/sun.frag"):
            used = renderer.gpu.shaders.sources.expand(file).files
            assert not [name for name in used if name.startswith("atmosphere/")], file


def test_air_comes_and_goes(renderer: pf.Renderer, scene: pf.Scene) -> None:
    with_air = settled(renderer, CAMERA)
    first = renderer.gpu.counts()
    held = scene.planet.remove(pf.Atmosphere)
    without = radiance(renderer, CAMERA)
    counts = renderer.gpu.counts()
    assert "atmosphere" in first and "atmosphere" not in counts
    others = {owner: kinds for owner, kinds in first.items() if owner not in ("atmosphere", "graph")}
    assert {owner: kinds for owner, kinds in counts.items() if owner != "graph"} == others
    assert not {TABLES, VIEW} & {r.name for r in renderer.passes()}
    assert with_air.mean() > 0.01 and without.max() < 0.001 * with_air.mean()
    scene.planet.add(held)
    np.testing.assert_array_equal(settled(renderer, CAMERA), with_air)
    assert renderer.gpu.counts() == first


# -- skipping --------------------------------------------------------------------------------------------------------


def test_what_does_not_change_does_not_run(renderer: pf.Renderer) -> None:
    settled(renderer, CAMERA)
    work = renderer.gpu.work
    before = work.snapshot()
    radiance(renderer, CAMERA)
    after = work.snapshot()
    assert not {TABLES, VIEW} & ran(renderer)
    assert (after["dispatches"], after["uploads"]) == (before["dispatches"], before["uploads"])

    radiance(renderer, at(3000.0, pitch_deg=-40.0, heading_deg=200.0))
    assert not {TABLES, VIEW} & ran(renderer), "turning fills nothing again"
    radiance(renderer, at(3001.0))
    assert VIEW in ran(renderer) and TABLES not in ran(renderer), "going up fills the camera's tables"
    before = renderer.gpu.work.dispatches
    radiance(renderer, CAMERA, sun=pf.Sun(direction=(0.0, 0.6, 0.8)))
    assert VIEW in ran(renderer) and TABLES not in ran(renderer), "another height of the sun as well"


@pytest.mark.parametrize("altitude_m", [0.0, 0.1, 2.0, 12345.678, 3.0e5])
def test_level_flight_under_an_equal_sun_fills_nothing(renderer: pf.Renderer, altitude_m: float) -> None:
    # Around the axis that points to the sun: position and sun differ by float64's rounding only.
    sun = pf.Sun(direction=(0.0, 0.0, 1.0))
    settled(renderer, CAMERA)
    radiance(renderer, at(altitude_m, longitude_deg=0.0), sun=sun)
    for longitude in (0.001, 17.3, 90.0, 133.7, 211.1, 300.3):
        radiance(renderer, at(altitude_m, longitude_deg=longitude), sun=sun)
        assert VIEW not in ran(renderer), longitude


def test_a_planet_smaller_than_a_pixel_costs_nothing(renderer: pf.Renderer) -> None:
    settled(renderer, at(1.0e6))
    far = at(3.0e9)
    radiance(renderer, far)
    assert dispatches(renderer, lambda: radiance(renderer, at(3.1e9))) == 0
    assert not {TABLES, VIEW} & ran(renderer)


# -- live changes ----------------------------------------------------------------------------------------------------


def test_a_change_shows_soon_and_refines(renderer: pf.Renderer, scene: pf.Scene) -> None:
    before = settled(renderer, CAMERA)
    generation = job_of(renderer).generation
    thicken(scene)
    frames, shown = 0, before
    while np.array_equal(shown, before):
        shown = radiance(renderer, CAMERA)
        frames += 1
        assert frames < 300
    assert job_of(renderer).generation == generation + 1 and not job_of(renderer).done
    final = settled(renderer, CAMERA)
    # The first look is coarse: within a tenth of where the whole change leads.
    assert np.abs(shown - final).mean() < 0.1 * np.abs(before - final).mean()
    with renderer_of(scene) as fresh:
        np.testing.assert_array_equal(settled(fresh, CAMERA), final)


def test_changes_on_the_heels_of_each_other(renderer: pf.Renderer, scene: pf.Scene) -> None:
    air = scene.planet[pf.Atmosphere]
    radiance(renderer, CAMERA)
    for k in range(12):  # some come while the first look is computed, some while that refines
        air.mie_scattering_per_m = air.mie_extinction_per_m = tuple(v * (1.0 + 0.1 * k) for v in HAZY)
        for _ in range(k % 4):
            radiance(renderer, CAMERA)
    final = settled(renderer, CAMERA)
    with renderer_of(scene) as fresh:
        np.testing.assert_array_equal(settled(fresh, CAMERA), final)


def test_a_value_that_changes_in_every_frame_shows(
    renderer: pf.Renderer, scene: pf.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody drags a slider on a slow machine, where even small tables take many frames."""
    before = settled(renderer, CAMERA)
    job = job_of(renderer)
    monkeypatch.setattr(air_of(renderer).method, "budget_s", 1e-9)
    seen, generation = {job.shown.key()}, job.generation
    # Twice as many frames as slices of the least size in the small tables.
    for k in range(2 * -(-QUICK.samples() // job_module.LEAST_SLICE)):
        scene.planet[pf.Atmosphere].rayleigh_scale_height_m = 8000.0 + 10.0 * (k + 1)
        shown = radiance(renderer, CAMERA)
        seen.add(job.shown.key())
    assert job.generation > generation and len(seen) > 1
    assert not np.array_equal(shown, before)
    monkeypatch.undo()
    final = settled(renderer, CAMERA)
    with renderer_of(scene) as fresh:
        np.testing.assert_array_equal(settled(fresh, CAMERA), final)


def test_back_to_an_air_from_before(renderer: pf.Renderer, scene: pf.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    air = scene.planet[pf.Atmosphere]
    normal, first = air.rayleigh_scattering_per_m, settled(renderer, CAMERA)
    thicken(scene)
    settled(renderer, CAMERA)
    air.rayleigh_scattering_per_m = normal
    np.testing.assert_array_equal(radiance(renderer, CAMERA), first)
    assert job_of(renderer).done, "from the cache, in one frame"

    # Back before anything of the other air was seen: nothing to do, with or without a cache.
    monkeypatch.setattr(job_of(renderer).cache, "folder", None)
    thicken(scene)
    monkeypatch.setattr(job_of(renderer), "work", lambda budget_s: None)
    np.testing.assert_array_equal(radiance(renderer, CAMERA), first)
    air.rayleigh_scattering_per_m = normal
    np.testing.assert_array_equal(radiance(renderer, CAMERA), first)
    assert job_of(renderer).done


def test_night_light_needs_no_tables(renderer: pf.Renderer, scene: pf.Scene) -> None:
    settled(renderer, CAMERA)
    scene.planet[pf.Atmosphere].night_light = 1e6
    brighter = radiance(renderer, CAMERA)
    assert job_of(renderer).done and TABLES not in ran(renderer)
    scene.planet[pf.Atmosphere].night_light = 0.0
    assert (radiance(renderer, CAMERA) < brighter).all()


def test_a_change_of_the_planets_size(renderer: pf.Renderer, scene: pf.Scene) -> None:
    settled(renderer, CAMERA)
    scene.planet[pf.Planet].radius_m = 3.0e6
    radiance(renderer, CAMERA)
    final = settled(renderer, CAMERA)
    assert job_of(renderer).shown.radius_m == 3.0e6
    with renderer_of(scene) as fresh:
        np.testing.assert_array_equal(settled(fresh, CAMERA), final)


def test_slices_keep_to_the_budget(renderer: pf.Renderer, scene: pf.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a clock that runs by the samples computed: a fast and a slow machine."""
    settled(renderer, CAMERA)
    job = job_of(renderer)

    for per_sample_s in (2.0e-8, 4.0e-7):

        def clock(rate: float = per_sample_s) -> float:
            working = job.working
            # What a finished table had spent is left out: that frame is not looked at.
            return rate * (working.spent if working is not None else 0)

        monkeypatch.setattr(job_module, "clock", clock)
        thicken(scene, 1.0 + 1e6 * per_sample_s)
        frames = []
        while True:
            working = job.working
            held = 0 if working is None else working.spent
            radiance(renderer, CAMERA)
            if job.done:
                break
            if working is job.working and job.refining:
                frames.append(per_sample_s * (job.working.spent - held))
        # One slice is at most half the budget by the time of the last; a share beyond it is allowed once.
        late = np.array(frames[3:])
        assert len(late) > 1
        assert late.max() <= 1.5 * air_of(renderer).method.budget_s, (per_sample_s, late.max())


# -- bad input -------------------------------------------------------------------------------------------------------


def test_a_bad_change_is_said_once_and_the_last_air_stays(renderer: pf.Renderer, scene: pf.Scene) -> None:
    good = settled(renderer, CAMERA)
    air = scene.planet[pf.Atmosphere]
    with pytest.raises(pf.SettingError, match=r"rayleigh_scattering_per_m.*found"):
        air.rayleigh_scattering_per_m = (-1.0, 0.0, 0.0)
    with pytest.raises(pf.SettingError):
        air.mie_asymmetry = float("nan")
    air.mie_scattering_per_m = (1e-3, 1e-3, 1e-3)  # above the extinction: alone fine, together not
    with pytest.raises(pf.SettingError, match="mie_extinction_per_m"):
        renderer.render(CAMERA)
    np.testing.assert_array_equal(radiance(renderer, CAMERA), good)
    np.testing.assert_array_equal(radiance(renderer, CAMERA), good)
    assert job_of(renderer).done
    air.mie_scattering_per_m = Atmosphere().mie_scattering_per_m
    np.testing.assert_array_equal(settled(renderer, CAMERA), good)


def test_a_scene_that_went_bad_before_the_first_frame(scene: pf.Scene, renderer: pf.Renderer) -> None:
    scene.planet[pf.Atmosphere].thickness_m = 1e8
    for _ in range(2):
        with pytest.raises(pf.SettingError, match="thickness_m"):
            renderer.render(CAMERA)
    scene.planet[pf.Atmosphere].thickness_m = 60e3
    assert radiance(renderer, CAMERA).max() > 0.0


@pytest.mark.parametrize(
    ("overrides", "named"),
    [
        ({"atmosphere.thickness_m": 1e8}, "thickness_m"),
        ({"atmosphere.thickness_m": 0.0}, "thickness_m"),
        ({"atmosphere.mie_asymmetry": 1.0}, "mie_asymmetry"),
        ({"atmosphere.rayleigh_scattering_per_m": (5.0, 5.0, 5.0)}, "rayleigh_scattering_per_m"),
        ({"atmosphere.mie_scattering_per_m": (1e-3, 1e-3, 1e-3)}, "mie_extinction_per_m"),
        ({"atmosphere.ground_albedo": (0.1, 0.1, 1.5)}, "ground_albedo"),
        ({"atmosphere.columns": 0}, "columns"),
        ({"atmosphere.budget_ms": float("nan")}, "budget_ms"),
        ({"atmosphere.thicknes_m": 6e4}, "thickness_m"),
    ],
)
def test_overrides_that_cannot_be_are_refused_before_any_gpu_work(
    scene: pf.Scene, overrides: dict[str, object], named: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_gpu() -> None:
        raise AssertionError("a context was made")

    monkeypatch.setattr("planetfall.engine.hosts.headless.create_headless", no_gpu)
    with pytest.raises(pf.SettingError, match=named):
        pf.Renderer(scene, size=(32, 18), quality="low", overrides=overrides)


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("thickness_m = 1e8", "thickness_m"),
        ("thickness_m = nan", "thickness_m"),
        ("mie_asymmetry = -1.0", "mie_asymmetry"),
        ("rayleigh_scattering_per_m = [1.0, 1.0, 1.0]", "rayleigh_scattering_per_m"),
        ("ground_albedo = [0.0, -0.1, 0.0]", "ground_albedo"),
        ("rayleigh_scale_height_m = 0", "rayleigh_scale_height_m"),
    ],
)
def test_scene_files_that_cannot_be_are_refused(tmp_path: Path, line: str, named: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(f'name = "bad"\nlike = "earth"\n[atmosphere]\n{line}\n', encoding="utf-8")
    with pytest.raises(pf.SettingError, match=named) as caught:
        pf.load_scene(path)
    assert "bad.toml" in str(caught.value)


# -- settling --------------------------------------------------------------------------------------------------------


def test_settle_reports_growing_shares(renderer: pf.Renderer, scene: pf.Scene) -> None:
    shares: list[float] = []
    renderer.settle(CAMERA, progress=shares.append)
    assert shares[-1] == 1.0 and all(0.0 <= s <= 1.0 for s in shares)
    assert shares == sorted(shares)
    thicken(scene)
    live: list[float] = []
    while not live or not job_of(renderer).done:
        radiance(renderer, CAMERA)
        if job_of(renderer).refining:
            live.append(air_of(renderer).progress(renderer.views[0]))
    assert live == sorted(live) and live[-1] == 1.0 and len(set(live)) >= 4  # few on a fast GPU


def test_settle_names_the_air_when_time_is_up(scene: pf.Scene) -> None:
    with pf.Renderer(scene, size=(32, 18), quality="reference") as renderer:
        with pytest.raises(pf.NotSettled, match="atmosphere"):
            renderer.settle(CAMERA, timeout_s=0.01)
        radiance(renderer, CAMERA)


# -- shaders and sizes -----------------------------------------------------------------------------------------------


def test_a_reloaded_shader_shows(
    scene: pf.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    folder = tmp_path / "assets"
    shutil.copytree(ASSETS / "shaders", folder / "shaders")
    monkeypatch.setattr("planetfall.render.renderer.ASSETS", folder)
    with renderer_of(scene) as renderer:
        first = settled(renderer, CAMERA)
        for file in ("medium.glsl", "view_fill.comp", "add_order.comp"):
            path = folder / "shaders" / "atmosphere" / file
            text = path.read_text(encoding="utf-8")
            changed = {
                "medium.glsl": ("3.0 / (16.0 * PI)", "6.0 / (16.0 * PI)"),
                "view_fill.comp": ("= air_column_mean(c, c.first)", "= 2.0 * air_column_mean(c, c.first)"),
                "add_order.comp": ("vec3 weight = ", "vec3 weight = 1.5 * "),
            }[file]
            assert changed[0] in text
            path.write_text(text.replace(*changed), encoding="utf-8")
            assert renderer.reload_shaders()
            other = settled(renderer, CAMERA)
            assert (other > first).any() and not np.array_equal(other, first), file
            with caplog.at_level(logging.ERROR):
                path.write_text(text + "\nnonsense;\n", encoding="utf-8")
                renderer.reload_shaders()
            assert file in caplog.text
            np.testing.assert_array_equal(radiance(renderer, CAMERA), other, "the last good one goes on")
            path.write_text(text, encoding="utf-8")
            renderer.reload_shaders()
            np.testing.assert_array_equal(settled(renderer, CAMERA), first)


def test_a_resize_fills_the_view_again_and_nothing_else(renderer: pf.Renderer) -> None:
    settled(renderer, CAMERA)
    generation = job_of(renderer).generation
    renderer.resize((48, 20))
    wide = radiance(renderer, CAMERA)
    assert wide.shape == (20, 48, 3) and VIEW in ran(renderer) and TABLES not in ran(renderer)
    radiance(renderer, CAMERA)
    assert VIEW not in ran(renderer)
    renderer.resize((32, 18))
    radiance(renderer, CAMERA)
    assert job_of(renderer).generation == generation


def test_a_resize_while_refining(renderer: pf.Renderer, scene: pf.Scene) -> None:
    settled(renderer, CAMERA)
    thicken(scene)
    for k in range(6):
        renderer.resize((20 + k, 18))
        radiance(renderer, CAMERA)
    renderer.resize((32, 18))
    final = settled(renderer, CAMERA)
    with renderer_of(scene) as fresh:
        np.testing.assert_array_equal(settled(fresh, CAMERA), final)


def test_the_method_can_be_changed(scene: pf.Scene, renderer: pf.Renderer) -> None:
    air = scene.planet[pf.Atmosphere]
    camera = at(3000.0, pitch_deg=40.0)  # the methods differ in what they show where there is no ground
    ours = settled(renderer, camera)
    counts = renderer.gpu.counts()
    air.method = "paper"
    printed = settled(renderer, camera)
    assert VIEW not in {r.name for r in renderer.passes()}
    # Two ways to the same light: the printed one within a few percent by day.
    assert 0.0 < np.abs(printed - ours).mean() < 0.1 * ours.mean()
    assert dispatches(renderer, lambda: radiance(renderer, camera)) == 0
    air.method = "ours"
    np.testing.assert_array_equal(settled(renderer, camera), ours)
    assert renderer.gpu.counts() == counts
