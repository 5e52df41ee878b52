"""Maps of the weather are drawn ahead of their time, a little a frame; what is shown has neither hole nor step."""

from __future__ import annotations

import numpy as np
import pytest
from cloud_kit import cloudy, renderer_of

import planetfall as pf
from planetfall.systems.clouds.charts import FADE_FRAMES, Chart, Charts
from planetfall.systems.clouds.ours import OurClouds
from planetfall.systems.clouds.weather import STEP_S, moment_of

FRAME_S = 1.0 / 60.0


class Drawing:
    """Stands for the GPU: maps of 400 tiles, 5 of them in a frame's time."""

    tiles = 400
    in_a_frame = 5

    def __init__(self) -> None:
        self.drawn, self.coarse, self.most_in_a_frame = 0, 0, 0

    def draw(self, chart: Chart, most: int | None) -> None:
        count = min(self.tiles - chart.drawn, self.tiles if most is None else min(most, self.in_a_frame))
        chart.drawn += count
        chart.complete = chart.drawn == self.tiles
        self.drawn += count
        self.most_in_a_frame = max(self.most_in_a_frame, count if most is not None else 0)

    def draw_coarse(self, chart: Chart) -> None:
        self.coarse += 1


def weights(charts: Charts) -> dict[float, float]:
    """{number of a map's moment: its share of what is shown}; what may not be shown is an error."""
    found: dict[float, float] = {}
    for chart, share in ((charts.first, 1.0 - charts.share), (charts.second, charts.share)):
        assert chart.complete and chart.number is not None
        found[chart.number] = found.get(chart.number, 0.0) + share
    return found


def change(before: dict[float, float], after: dict[float, float]) -> float:
    """Share of what is shown that is another map's than before."""
    return 0.5 * sum(abs(after.get(n, 0.0) - before.get(n, 0.0)) for n in {*before, *after})


def wanted(time_s: float) -> dict[float, float]:
    moment = moment_of(time_s)
    return {float(moment.first): 1.0 - moment.share, float(moment.first + 1): moment.share}


def run(charts: Charts, times: np.ndarray) -> float:
    """Frames at these times; the largest change from one to the next that was no cut."""
    most, before, cuts = 0.0, None, charts.cuts
    for time_s in times:
        charts.running(float(time_s))
        after = weights(charts)
        if before is not None and charts.cuts == cuts:
            most = max(most, change(before, after))
        before, cuts = after, charts.cuts
    return most


@pytest.mark.parametrize("warp", [1.0, 60.0, 400.0])
def test_weather_that_goes_on_is_drawn_before_its_time(warp: float) -> None:
    """400 times as fast a map has 135 frames, and 400 tiles of 5 a frame take 80: the pace follows the time."""
    drawing = Drawing()
    charts = Charts(drawing)
    charts.exact(10.0)
    charts.running(10.0)  # what is due of the next map already
    drawing.most_in_a_frame = 0
    step = FRAME_S * warp
    frames = min(int(4.5 * STEP_S / step), 250_000)
    for k in range(frames):
        time_s = 10.0 + k * step
        charts.running(time_s)
        assert charts.steady and change(weights(charts), wanted(time_s)) < 1e-9
    assert drawing.coarse == 0 and charts.cuts == 0
    # No frame draws more than its part of what is due, rounded up.
    assert drawing.most_in_a_frame <= int(np.ceil(drawing.tiles * step / (0.85 * STEP_S))) + 1


def test_a_jump_shows_a_coarse_map_at_once_and_fine_ones_fade_in() -> None:
    drawing = Drawing()
    charts = Charts(drawing)
    charts.exact(0.0)
    jump = 40.4 * STEP_S
    charts.running(jump)
    assert drawing.coarse == 1 and charts.cuts == 1
    assert weights(charts) == {40.4: 1.0} and not charts.steady
    times = jump + FRAME_S * np.arange(1, 600)
    assert run(charts, times) <= 1.0 / FADE_FRAMES + 1e-9
    assert charts.steady and charts.cuts == 1
    assert change(weights(charts), wanted(times[-1])) < 1e-9
    assert drawing.most_in_a_frame <= Drawing.in_a_frame


@pytest.mark.parametrize("warp", [1500.0, 6000.0])
def test_weather_faster_than_it_can_be_drawn_fades_from_map_to_map(warp: float) -> None:
    """A map a second and four a second, 80 frames for one: what is shown lags, and goes on without a step."""
    charts = Charts(Drawing())
    charts.exact(0.0)
    times = np.arange(0.0, 20.0 * STEP_S, FRAME_S * warp)
    assert run(charts, times) <= max(1.0 / FADE_FRAMES, FRAME_S * warp / STEP_S) + 1e-9
    # And it comes to rest at what the time asks for.
    assert run(charts, np.full(400, times[-1])) <= 1.0 / FADE_FRAMES + 1e-9
    assert charts.steady and change(weights(charts), wanted(times[-1])) < 1e-9


def test_time_that_runs_back() -> None:
    charts = Charts(Drawing())
    charts.exact(3.2 * STEP_S)
    times = np.concatenate([np.arange(3.2, 1.6, -0.01), np.full(400, 1.6)]) * STEP_S
    assert run(charts, times) <= 1.0 / FADE_FRAMES + 1e-9
    assert charts.cuts == 0 and change(weights(charts), wanted(1.6 * STEP_S)) < 1e-9


def test_random_times_never_show_a_hole() -> None:
    rng = np.random.default_rng(7)
    charts = Charts(Drawing())
    time_s = 0.0
    for _ in range(3000):
        kind = rng.random()
        time_s = rng.uniform(-1e6, 1e8) if kind < 0.005 else time_s + rng.normal() * (900.0 if kind < 0.05 else 5.0)
        if rng.random() < 0.01:
            charts.exact(time_s)
            assert charts.steady and change(weights(charts), wanted(time_s)) < 1e-9
        elif rng.random() < 0.005:
            charts.forget()
        charts.running(time_s)
        assert sum(weights(charts).values()) == pytest.approx(1.0)
    for _ in range(400):
        charts.running(time_s)
    assert charts.steady and change(weights(charts), wanted(time_s)) < 1e-9


def test_frames_come_to_the_map_that_a_settled_picture_has() -> None:
    camera = pf.Camera.at(20.0, 10.0, 1e7, pitch_deg=-90.0)
    time_s = 20.3 * STEP_S
    with renderer_of(cloudy()) as one, renderer_of(cloudy()) as other:
        one.settle(camera, time_s)
        exact = one.render(camera, time_s)["color"]
        other.render(camera, 0.0, dt_s=FRAME_S)
        system, reference = other.system("clouds").method, one.system("clouds").method
        assert isinstance(system, OurClouds) and isinstance(reference, OurClouds)
        maps = system.field.maps
        frames, most = 0, 0
        while frames == 0 or not maps.charts.steady:
            before = maps.tiles_drawn
            other.render(camera, time_s, dt_s=FRAME_S)
            most, frames = max(most, maps.tiles_drawn - before), frames + 1
            assert frames < 1000
        assert maps.charts.cuts == 2  # the first picture, and the jump
        assert most <= 16 < maps.tiles
        with one.current():
            wanted_texels = [reference.field.maps.texture_of(n).read() for n in moment_of(time_s).maps]
        with other.current():
            assert [maps.texture_of(n).read() for n in moment_of(time_s).maps] == wanted_texels
        other.settle(camera, time_s)
        np.testing.assert_array_equal(other.render(camera, time_s)["color"], exact)


def frames_until(charts: Charts, drawing: Drawing, tiles: int, time_s: float, most: int = 60000) -> int:
    for count in range(most):
        if drawing.drawn >= tiles:
            return count
        charts.running(time_s + count * FRAME_S)
    raise AssertionError(f"{drawing.drawn} of {tiles} tiles after {most} frames")


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_a_picture_that_begins_between_two_maps_does_not_hurry_after_the_next(share: float) -> None:
    """What was there at once leaves time: the next map comes a tile in some frames, and still before it is due."""
    drawing = Drawing()
    charts = Charts(drawing)
    begin = (7.0 + share) * STEP_S
    charts.exact(begin)
    drawing.drawn = drawing.most_in_a_frame = 0
    frames = frames_until(charts, drawing, Drawing.tiles, begin)
    due = (0.05 if share == 0.0 else 0.85 - share) * STEP_S / FRAME_S
    assert 0.9 * due < frames < 1.1 * due
    assert drawing.most_in_a_frame == 1


def test_time_that_stands_still_waits_for_no_map() -> None:
    """A pause just after a jump: maps come as fast as frames allow, so that the picture can rest."""
    drawing = Drawing()
    charts = Charts(drawing)
    charts.exact(7.0 * STEP_S)
    later = 7.0 * STEP_S + 1.0
    for _ in range(2 + Drawing.tiles // Drawing.in_a_frame + 2 * FADE_FRAMES):
        charts.running(later)
    assert charts.steady and charts.share == pytest.approx(moment_of(later).share)
