"""Weather clouds lit as even sheets against Monte-Carlo slabs, and what keeps that light within its bounds."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from cloud_tables import column, rows_of

from planetfall.benchmarks.measure import cloud_sheets as measure
from planetfall.benchmarks.reference.cloud_slab import slab_light

BACK, THROUGH = [180.0, 150.0, 120.0, 120.0], [60.0, 60.0, 30.0, 0.0]
AZIMUTH = [0.0, 0.0, 0.0, 180.0, 0.0, 180.0, 180.0, 0.0]


@pytest.mark.slow
def test_sheets_of_weather_have_the_light_of_independent_slabs() -> None:
    """Depths from 0.5 to 32, suns in the zenith and at 60 degrees. Promised are 30 %."""
    errors, names = [], ("optical_depth", "albedo", "hg_g", "sun_zenith_deg")
    rows = sorted(rows_of("clouds_slab_multiple"), key=lambda row: [row[name] for name in names])
    for kind, group in groupby(rows, key=lambda row: [float(row[name]) for name in names]):
        own = list(group)
        with measure.sheet_probe(*kind[:3], "low") as probe:
            found = measure.sheet_light(probe, kind[3], column(own, "view_zenith_deg"), column(own, "azimuth_deg"))
        errors += list(np.abs(found / column(own, "L_total") - 1.0))
    assert max(errors) < 0.3
    assert np.median(errors) < 0.1


@pytest.mark.parametrize(("depth", "photons"), [(0.5, 20_000), (2.0, 20_000), (8.0, 6_000), (32.0, 1_500)])
def test_under_a_sun_at_30_degrees(depth: float, photons: int) -> None:
    """What is thrown back and what comes through, within 30 % give or take three standard errors of the reference."""
    zenith = [*BACK, *THROUGH]
    with measure.sheet_probe(depth, 0.999, 0.85, "low") as probe:
        found = measure.sheet_light(probe, 30.0, zenith, AZIMUTH)
    truth = slab_light(depth, 0.999, 0.85, 30.0, zenith, AZIMUTH, photons, 7)
    assert (np.abs(found - truth.total) < 0.3 * truth.total + 3.0 * truth.error).all()
