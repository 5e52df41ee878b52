"""The references of homogeneous clouds against tables of independent truth and against theory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cloud_tables import Rows, column, configs, geometry, radius_of, rows_of, triple

from planetfall.benchmarks.reference.air_medium import EARTH_BRUNETON
from planetfall.benchmarks.reference.cloud_shells import Layer, cloud_light, cloud_transmittance
from planetfall.benchmarks.reference.cloud_slab import slab_light, slab_single


def _question(rows: Rows) -> tuple[float, list[Layer], Any, Any, Any]:
    names = ("base_m", "top_m", "extinction_per_m", "albedo", "hg_g")
    return radius_of(rows), [Layer(*(float(rows[0][name]) for name in names))], *geometry(rows, radius_of(rows))


@pytest.mark.parametrize("config", configs("clouds_shell"))
def test_shells_in_vacuum(config: str) -> None:
    rows = rows_of("clouds_shell", config=config)
    found = cloud_light(*_question(rows), rtol=1e-7)
    # Twelve digits in the table; a way of 3e5 m that is known to 1e-8 m has depths of up to 6000 to 2e-10.
    np.testing.assert_allclose(found.transmittance[:, 0], column(rows, "transmittance"), rtol=1e-8, atol=1e-14)
    # Below 1e-25 of the sun's irradiance the quadrature's own floor (1e-30) shows.
    np.testing.assert_allclose(found.radiance[:, 0], column(rows, "L1"), rtol=1e-6, atol=1e-25)


@pytest.mark.parametrize("config", configs("clouds_in_air"))
def test_shells_in_the_air_of_earth(config: str) -> None:
    rows = rows_of("clouds_in_air", config=config)
    found = cloud_light(*_question(rows), air=EARTH_BRUNETON, rtol=1e-6)
    for name, value in (("T", found.transmittance), ("L_total", found.radiance)):
        np.testing.assert_allclose(value, triple(rows, name), rtol=1e-5, atol=1e-25, err_msg=name)


def test_a_parabola_takes_two_thirds_on_the_way_up() -> None:
    up, layer = [[0.0, 0.0, 6.36e6]], Layer(1000.0, 2000.0, 1e-3, parabola=True)
    found = cloud_transmittance(6.36e6, [layer], up, [[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(found, np.exp(-2.0 / 3.0), rtol=1e-7)


@pytest.mark.parametrize("depth", [0.5, 2.0, 8.0])
def test_slabs_of_all_orders(depth: float) -> None:
    for row in rows_of("clouds_slab_multiple", optical_depth=str(depth)):
        view = float(row["view_zenith_deg"]), float(row["azimuth_deg"])
        sun = float(row["albedo"]), float(row["hg_g"]), float(row["sun_zenith_deg"])
        assert slab_single(depth, *sun, *view)[0] == pytest.approx(float(row["L1_exact"]), rel=1e-8)
        found = slab_light(depth, *sun, *view, photons=20_000, seed=3)
        spread = np.hypot(found.error[0], float(row["L_total_se"]))
        # Ten batches: the standard error itself is known to a quarter; 18 rows, none beyond five of it by chance.
        assert abs(found.total[0] - float(row["L_total"])) < 5.0 * spread


def test_a_deep_slab_reflects_as_chandrasekhar_says() -> None:
    # Isotropic, no loss: I = F / (4 pi) mu_0 / (mu + mu_0) H(mu) H(mu_0) from a half space (Chandrasekhar 1950, table
    # XI), less what a slab of this depth lets through: F mu_0 / pi K(mu) K(mu_0) 4/3 / (depth + 2 * 0.71044), where
    # K = sqrt(3) H / 4.
    h_half, h_one, depth = 2.01278, 2.90781, 32.0
    endless = 0.5 / 1.5 * h_half * h_one / (4.0 * np.pi)
    passed = 0.5 / np.pi * (3.0 / 16.0) * h_half * h_one * (4.0 / 3.0) / (depth + 1.42089)
    found = slab_light(depth, 1.0, 0.0, 60.0, 180.0, 0.0, photons=10_000, seed=5)
    assert abs(found.total[0] - (endless - passed)) < 5.0 * found.error[0]
    assert found.error[0] < 0.02 * endless
