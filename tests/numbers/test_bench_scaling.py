"""The exponent of a series of times."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.benchmarks.measure.scaling import fit_power_law


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("fixed_ms", [0.0, 3.0])
def test_the_exponent_is_found(exponent, fixed_ms):
    counts = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    law = fit_power_law(counts, fixed_ms + 2.0 * counts**exponent)
    assert law.exponent == pytest.approx(exponent, abs=0.03)
    assert law.fixed_ms == pytest.approx(fixed_ms, abs=0.06)
    assert law.worst < 1.01


def test_noise_moves_it_little():
    counts = np.array([160 * 90, 320 * 180, 640 * 360, 1280 * 720], float)
    times = 5.0 + 1e-4 * counts * np.array([1.05, 0.96, 1.03, 0.98])
    law = fit_power_law(counts, times)
    assert law.exponent == pytest.approx(1.0, abs=0.1) and law.worst < 1.1


def test_what_is_no_series_is_refused():
    for counts, ms in (([1, 2], [1, 2]), ([1, 2, 0], [1, 2, 3]), ([1, 2, 3], [1, 2]), ([1, 2, 3], [1, -2, 3])):
        with pytest.raises(ValueError, match="three positive pairs"):
            fit_power_law(counts, ms)
