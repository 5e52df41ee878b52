"""The numbers of the benches of selection and culling, at small sizes."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.benchmarks.measure.culling import blocked, cell_samples
from planetfall.benchmarks.measure.selection import MadeGround, time_selection
from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.scheme import QuadScheme, Scheme

SCHEMES: list[Scheme] = [QuadScheme(), TriangleScheme()]
schemes = pytest.mark.parametrize("scheme", SCHEMES, ids=lambda s: s.name)


@schemes
def test_times_are_of_the_selection_that_was_asked_for(scheme: Scheme):
    found = time_selection(MadeGround(scheme), 1e4, 150, 12)
    assert 100 <= found.leaves <= 150 and found.tiles <= found.leaves
    assert len(found.warm_us) == len(found.still_us) == 12
    # The camera that moves by 1 % of its altitude sees other tiles, the one that hardly moves has nothing to do.
    assert found.revisions >= 6
    assert np.median(found.still_us) < 0.5 * np.median(found.warm_us)


@schemes
def test_samples_lie_in_their_cell(scheme: Scheme):
    up = np.array([[0.3, -0.5, 0.8]]) / np.sqrt(0.98)
    for level in (0, 3, 9):
        key = scheme.at(up, level)
        samples = cell_samples(scheme.corners(key)[0], 17)
        # Those on a border belong to either side.
        inside = scheme.at(samples, level) == key[0]
        assert inside.mean() > 0.75
        middle = samples.mean(axis=0)
        assert (scheme.at((samples + 1e-6 * (middle - samples)), level) == key[0]).all()


def test_blocked_by_a_sphere():
    eye = np.array([0.0, 0.0, 2.0])
    points = np.array([[0.0, 0.0, 1.1], [0.0, 0.0, -1.1], [0.0, 3.0, -1.0], [0.0, 1.01, 0.0]])
    assert blocked(eye, points, 1.0).tolist() == [False, True, False, True]
