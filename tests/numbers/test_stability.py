"""docs/numerical-stability.md and the sweep that it is made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tiers import skip_if_results_are_new

from planetfall.benchmarks import cli
from planetfall.benchmarks.schema import ReportError, read_report
from planetfall.benchmarks.stability import stability_text
from planetfall.benchmarks.store import results_root
from planetfall.benchmarks.stress.deviations import ABSOLUTE_EDGES, ULP_EDGES, Deviations, shares

ROOT = Path(__file__).parents[2]
CLOUDS = ("cloud coordinates, broad", "cloud coordinates, wide")
QUANTITIES = ("heights anywhere", "waves", "transmittance of air", *CLOUDS)


def test_shares_add_up_and_name_their_bins():
    found = shares(np.array([0.2, 0.5, 0.51, 3.0, 1e9]), ULP_EDGES)
    assert sum(found.values()) == pytest.approx(1.0) and len(found) == len(ULP_EDGES) + 1
    assert found["<= 0.5"] == pytest.approx(0.4) and found["<= 1"] == pytest.approx(0.2)
    assert found["<= 4"] == pytest.approx(0.2) and found["> 4096"] == pytest.approx(0.2)
    assert sum(shares(np.array([1e-13, 1.0, 20.0]), ABSOLUTE_EDGES).values()) == pytest.approx(1.0)


def test_deviations_count_in_units_of_the_last_place():
    one = np.float32(1.0)
    found = Deviations.of(np.array([np.nextafter(one, np.float32(2.0))]), np.array([1.0]), "m", np.spacing([one]))
    assert found.ulp == pytest.approx([1.0]) and found.absolute == pytest.approx([2.0**-23])


@pytest.mark.gpu
@pytest.mark.slow
def test_a_short_sweep_keeps_its_promises_and_makes_a_page(tmp_path: Path):
    assert cli.stress_main(["compare", "--seed", "3", "--count", "8", "--output", str(tmp_path)]) == 0
    report = read_report(next(tmp_path.rglob("stress-compare.json")))
    assert {row.variant for row in report.rows if row.bench == "errors"} >= set(QUANTITIES)
    assert cli.stress_main(["--document", "--output", str(tmp_path)]) == 0
    page = (tmp_path / "numerical-stability.md").read_text()
    assert page.startswith("# Numerical stability") and all(name in page for name in QUANTITIES)
    assert page.count("```text") == page.count("\n```\n") >= 2 * len(QUANTITIES)


def test_without_results_it_says_what_to_run(tmp_path: Path):
    with pytest.raises(ReportError, match="run planetfall stress compare first"):
        stability_text(tmp_path)


def test_the_page_in_docs_is_what_the_results_say():
    """`planetfall stress --document` after a sweep that is to be committed."""
    skip_if_results_are_new(results_root())
    assert (ROOT / "docs" / "numerical-stability.md").read_text() == stability_text(results_root())
