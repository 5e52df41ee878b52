"""Numbers given at 680, 550 and 440 nm, where light is carried at 610, 550 and 440 nm."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.wavelengths import (
    DISPLAY_NM,
    GIVEN_NM,
    SUNLIGHT,
    carried_air,
    carried_sunlight,
    carried_water,
    wavelengths_of,
)
from planetfall.quality import resolve_quality

ANGSTROM = np.log(680.0 / 610.0)
"""The logarithm of a number that goes with 1 / wavelength, from 680 to 610 nm."""


def air(**given):
    return carried_air(pf.Atmosphere(**given), DISPLAY_NM)


def water(absorption):
    return carried_water(pf.Ocean(absorption_per_m=absorption), DISPLAY_NM).absorption_per_m


def test_each_quality_says_where_light_is_carried():
    for name in pf.qualities():
        assert wavelengths_of(resolve_quality(name)) == (GIVEN_NM if name == "paper" else DISPLAY_NM), name
    assert wavelengths_of(resolve_quality("high", {"light.wavelengths": "given"})) == GIVEN_NM
    assert wavelengths_of({}) == GIVEN_NM


def test_powers_of_the_wavelength_stay_what_they_are_and_only_red_moves():
    for exponent in (-4.0, -1.3, 0.0, 1.0):
        given = tuple(1e-5 * (np.array(GIVEN_NM) / 550.0) ** exponent)
        found = air(rayleigh_scattering_per_m=given).rayleigh_scattering_per_m
        assert found == pytest.approx(tuple(1e-5 * (np.array(DISPLAY_NM) / 550.0) ** exponent), rel=1e-12)
        assert found[1:] == given[1:]


def test_haze_never_scatters_more_than_it_takes_away():
    rng = np.random.default_rng(1)
    for _ in range(200):
        taken = rng.uniform(0.0, 1e-4, 3) * rng.integers(0, 2, 3)
        scattered = taken * rng.uniform(0.0, 1.0, 3) * rng.integers(0, 2, 3)
        found = air(mie_scattering_per_m=tuple(scattered), mie_extinction_per_m=tuple(taken))
        assert found.mie_extinction_per_m[0] >= found.mie_scattering_per_m[0] >= 0.0


def test_an_absorber_is_ozone_where_its_proportions_are():
    ozone = pf.Atmosphere().absorption_per_m
    assert air().absorption_per_m[0] == pytest.approx(3.56 * ozone[0], rel=1e-3)
    for scale in (0.01, 5.0):  # however much of it there is
        assert air(absorption_per_m=tuple(scale * np.array(ozone))).absorption_per_m[0] == pytest.approx(
            scale * 3.56 * ozone[0], rel=1e-3
        )
    # Soot and a dust that swallows blue: power laws.
    soot = tuple(1e-6 * 550.0 / np.array(GIVEN_NM))
    assert air(absorption_per_m=soot).absorption_per_m[0] == pytest.approx(soot[0] * np.exp(ANGSTROM))
    red, green, _ = dust = (0.3e-6, 1e-6, 3e-6)
    assert red < air(absorption_per_m=dust).absorption_per_m[0] < green
    assert air(absorption_per_m=(0.0, 0.0, 0.0)).absorption_per_m == (0.0, 0.0, 0.0)


def test_an_absorber_turns_into_another_without_a_jump():
    shares = np.linspace(0.0, 1.0, 401)
    ends = np.log(pf.Atmosphere().absorption_per_m), np.log([1e-6, 1e-6, 1e-6])
    found = [air(absorption_per_m=tuple(np.exp((1 - s) * ends[0] + s * ends[1]))).absorption_per_m[0] for s in shares]
    assert np.abs(np.diff(np.log(found))).max() < 0.02


def test_numbers_at_other_wavelengths_move_from_there():
    given = {"rayleigh_scattering_per_m": (7e-6, 1.355776e-5, 3.31e-5)}
    at_650 = air(wavelengths_nm=(650.0, 550.0, 440.0), **given).rayleigh_scattering_per_m[0]
    assert 7e-6 < at_650 < air(**given).rayleigh_scattering_per_m[0]
    for nm in ((610.0, 550.0, 440.0), (900.0, 800.0, 700.0), (600.0, 550.0, 440.0), (550.0, 550.0, 550.0)):
        there = pf.Atmosphere(wavelengths_nm=nm, **given)
        assert carried_air(there, DISPLAY_NM) is there


def test_sunlight_follows_the_solar_spectrum():
    ours = SUNLIGHT[GIVEN_NM]
    assert carried_sunlight(ours, DISPLAY_NM) == pytest.approx(np.array(SUNLIGHT[DISPLAY_NM]))
    assert carried_sunlight(0.43 * np.array(ours), DISPLAY_NM) == pytest.approx(0.43 * np.array(SUNLIGHT[DISPLAY_NM]))
    redder = carried_sunlight((2.0 * ours[0], ours[1], ours[2]), DISPLAY_NM)
    assert SUNLIGHT[DISPLAY_NM][0] < redder[0] < 2.0 * SUNLIGHT[DISPLAY_NM][0]
    assert carried_sunlight((0.0, 0.0, 0.0), DISPLAY_NM).tolist() == [0.0, 0.0, 0.0]
    given = np.array([1.0, 2.0, 3.0])
    assert carried_sunlight(given, GIVEN_NM) is given


def test_what_is_like_water_absorbs_as_water_does():
    assert water((0.465, 0.0565, 0.00635))[0] == pytest.approx(0.18)
    ours = pf.Ocean().absorption_per_m
    assert ours[1] < water(ours)[0] < ours[0] and water(ours)[1:] == ours[1:]
    assert water((0.4, 0.4, 0.4))[0] == pytest.approx(0.4)  # a grey liquid stays grey
    ocean = pf.Ocean()
    assert carried_water(ocean, GIVEN_NM) is ocean


def test_a_liquids_glow_stays_red():
    found = carried_water(pf.Ocean(glow=(4.0, 0.0, 0.0)), DISPLAY_NM).glow
    assert 0.0 < found[0] < 4.0 and found[1:] == (0.0, 0.0)
