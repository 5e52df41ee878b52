"""The meter of knobs: times and pictures of both values, settings put back, quality keys, planets in turn."""

from __future__ import annotations

import pytest
from golden_compare import SAME

from planetfall.benchmarks.knobs import PAIRS, VISIBLE, Pair
from planetfall.benchmarks.measure.knobs import KnobMeter
from planetfall.benchmarks.session import Session
from planetfall.benchmarks.suites import frame

pytestmark = pytest.mark.gpu

SIZE = (64, 36)


@pytest.fixture(scope="module")
def meter(gpu):
    with KnobMeter(SIZE, "low") as made:
        yield made
    gpu.ctx.__enter__()  # the tests' own context again


def test_a_knob_has_times_values_and_a_difference(meter):
    found = meter.knob("terrain.land_share", PAIRS["terrain.land_share"], 2)
    assert found.on_value == 0.6 and found.off_value != 0.6
    assert found.on.runs == found.off.runs == 2 and found.ratio == found.on.ms / found.off.ms > 0.0
    assert found.mean_flip is not None and found.mean_flip >= VISIBLE
    assert found.worst_flip is not None and found.worst_flip >= found.mean_flip


def test_settings_are_put_back_and_nothing_else_differs(meter):
    """After other knobs: the same value on both sides gives the same picture."""
    meter.knob("ocean.sea_level_m", PAIRS["ocean.sea_level_m"], 1)
    meter.knob("exposure.mode", PAIRS["exposure.mode"], 1)
    preset = meter.knob("terrain.land_share", PAIRS["terrain.land_share"], 1).off_value
    same = meter.knob("terrain.land_share", Pair("earth", "orbit", preset), 1)
    assert same.on_value == same.off_value and same.mean_flip is not None
    assert same.mean_flip <= SAME.mean, "what was drawn before moves roundings at most"


def test_a_quality_key_gives_each_side_a_renderer_of_its_own(meter):
    """Overrides may name any knob."""
    found = meter.quality_knob("composite.tone_map", ("agx", "linear"), ("earth", "orbit"), 1)
    assert (found.off_value, found.on_value) == ("agx", "linear")
    assert found.mean_flip is not None and found.mean_flip >= VISIBLE


def test_other_planets_come_and_go(meter):
    for planet in ("moon", "small", "earth"):
        assert meter.knob("terrain.layers", Pair(planet, "space", 4), 1).on_value == 4
        assert len(meter.renderers) <= 2 * meter.KEEP


def test_the_bench_has_a_row_for_each_pair(monkeypatch):
    """Pairs are looked up when the bench runs: a new one has a row at once."""
    pairs = {"terrain.seed": PAIRS["terrain.seed"], "terrain.rock_albedo": PAIRS["terrain.rock_albedo"]}
    monkeypatch.setattr(frame, "PAIRS", pairs)
    monkeypatch.setattr(frame, "QUICK_SIZE", SIZE)
    with Session("frame", "quick") as session:
        report = session.run({"knobs": frame.BENCHES["knobs"]})
    assert report.skipped == {} and [row.variant for row in report.rows] == ["terrain.seed"], (
        "colours: only in full runs"
    )
    row = report.rows[0]
    assert row.ms and row.error and row.extra["off_ms"] and row.extra["on"] == "2"
