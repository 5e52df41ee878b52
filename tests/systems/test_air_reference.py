"""The reference of clear air against tables of independent truth and against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from air_tables import Floats, over_the_pole, table, towards

from planetfall.benchmarks.reference.air_medium import EARTH_BRUNETON, SMALL_PLANET, mie_phase, rayleigh_phase
from planetfall.benchmarks.reference.air_quadrature import integrate
from planetfall.benchmarks.reference.air_rays import make_rays
from planetfall.benchmarks.reference.air_single import SingleScattering, aerial_single, sky_single
from planetfall.benchmarks.reference.air_transmittance import NODES, optical_lengths, transmittance

EARTH = EARTH_BRUNETON
PRINTED = 6e-10
"""The tables have ten digits: 5e-10 of rounding at worst, and a bit for the sums' own."""


def test_transmittance_to_space() -> None:
    truth = table("air_transmittance_top")
    p, d = over_the_pole(truth["altitude_m"]), towards(truth["view_zenith_deg"])
    np.testing.assert_allclose(transmittance(EARTH, p, d), truth.triple("T"), rtol=PRINTED)
    rays = make_rays(EARTH, p, d)
    lengths = optical_lengths(EARTH, rays.level_m2, rays.start_m, rays.end_m)
    stems = ("optlen_rayleigh_m", "optlen_mie_m", "optlen_absorber_m")
    # Coordinates of 6e6 m have 1e-9 m: lengths next to the top are differences of them.
    np.testing.assert_allclose(lengths, np.stack([truth[s] for s in stems], axis=1), rtol=PRINTED, atol=1e-8)


def test_transmittance_between_points() -> None:
    truth = table("air_transmittance_points")
    p, d = over_the_pole(truth["altitude_m"]), towards(truth["view_zenith_deg"])
    np.testing.assert_allclose(transmittance(EARTH, p, d, truth["distance_m"]), truth.triple("T"), rtol=PRINTED)


@pytest.mark.parametrize("visibility", ["disc", "point"])
def test_single_scattering_of_whole_rays(visibility: str) -> None:
    truth = table("air_single_scattering")
    p = over_the_pole(truth["altitude_m"])
    d = towards(truth["view_zenith_deg"], truth["azimuth_deg"])
    found = sky_single(EARTH, p, d, towards(truth["sun_zenith_deg"]), visibility)
    np.testing.assert_array_equal(found.hits_ground, truth["ray_hits_ground"] == 1)
    np.testing.assert_allclose(transmittance(EARTH, p, d), truth.triple("T"), rtol=PRINTED)
    _check_single(found, visibility, "air_single_scattering")


@pytest.mark.parametrize("visibility", ["disc", "point"])
def test_single_scattering_between_points(visibility: str) -> None:
    truth = table("air_aerial_single")
    p = over_the_pole(truth["camera_altitude_m"])
    points = p + truth.directions() * truth["distance_m"][:, None]
    found = aerial_single(EARTH, p, points, towards(truth["sun_zenith_at_camera_deg"]), visibility)
    np.testing.assert_allclose(found.transmittance, truth.triple("T"), rtol=PRINTED)
    _check_single(found, visibility, "air_aerial_single")


def _check_single(found: SingleScattering, visibility: str, name: str) -> None:
    truth = table(name)
    for stem, value in (("SR", found.rayleigh), ("SM", found.mie), ("L1", found.radiance)):
        # Both quadratures stop at about 1e-9; a value of 1e-12 is a hundred thousandth of starlight.
        np.testing.assert_allclose(value, truth.triple(f"{stem}_{visibility}"), rtol=1e-8, atol=1e-12, err_msg=stem)
    assert found.error.max() < 1e-7


def _everywhere(count: int, seed: int, radius_m: float, thickness_m: float) -> tuple[Floats, Floats, Floats]:
    """Cameras from the ground to far out, views about their horizon, and suns anywhere."""
    rng = np.random.default_rng(seed)
    height = thickness_m * 10.0 ** rng.uniform(-4.0, 3.0, count)
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    side = np.cross(up, rng.normal(size=(count, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    # From the straight line down to a little above the air's top as seen from there.
    limb = np.minimum((radius_m + thickness_m) / (radius_m + height), 1.0)
    reach = np.where(height < thickness_m, np.pi, np.arcsin(limb) * 1.05)
    below = rng.uniform(0.0, 1.0, count) * reach
    suns = rng.normal(size=(count, 3))
    return (
        up * (radius_m + height)[:, None],
        -up * np.cos(below)[:, None] + side * np.sin(below)[:, None],
        suns / np.linalg.norm(suns, axis=1, keepdims=True),
    )


@pytest.mark.parametrize("air", [EARTH, SMALL_PLANET], ids=["earth", "small"])
def test_twice_the_nodes_change_nothing(air) -> None:
    p, d, _ = _everywhere(2000, 1, air.radius_m, air.thickness_m)
    rays = make_rays(air, p, d)
    lengths = [optical_lengths(air, rays.level_m2, rays.start_m, rays.end_m, n) for n in (NODES, 2 * NODES)]
    np.testing.assert_allclose(lengths[0], lengths[1], rtol=1e-11, atol=1e-12 * air.thickness_m)


@pytest.mark.parametrize("air", [EARTH, SMALL_PLANET], ids=["earth", "small"])
@pytest.mark.parametrize("visibility", ["disc", "point"])
def test_a_finer_tolerance_changes_nothing(air, visibility: str) -> None:
    p, d, suns = _everywhere(200, 2, air.radius_m, air.thickness_m)
    usual, finer = (sky_single(air, p, d, suns, visibility, rtol) for rtol in (1e-8, 1e-11))
    np.testing.assert_allclose(usual.radiance, finer.radiance, rtol=1e-8, atol=1e-20)
    assert (usual.radiance >= 0.0).all() and (usual.radiance > 0.0).any()


def test_columns_in_closed_form() -> None:
    up = transmittance(EARTH, over_the_pole([0.0]), towards([0.0]))
    columns = [8000.0 * -np.expm1(-60.0 / 8.0), 1200.0 * -np.expm1(-50.0), 15_000.0]
    np.testing.assert_allclose(up[0], np.exp(-np.array(columns) @ EARTH.extinction_per_m), rtol=1e-12)
    # Scale heights of a thousand Earths: uniform air, whose optical lengths are lengths of chords.
    even = replace(EARTH, rayleigh_scale_height_m=1e13, mie_scale_height_m=1e13, absorption_half_width_m=0.0)
    p, d, _ = _everywhere(500, 3, even.radius_m, even.thickness_m)
    rays = make_rays(even, p, d)
    lengths = optical_lengths(even, rays.level_m2, rays.start_m, rays.end_m)
    np.testing.assert_allclose(lengths[:, 0], rays.end_m - rays.start_m, rtol=1e-7, atol=1e-6)


def test_rays_of_a_thin_uniform_shell_are_lit_over_their_length() -> None:
    """Hardly any extinction: straight up, the integral is scattering times the length in sunlight."""
    faint = 1e-15
    air = replace(
        EARTH, rayleigh_scattering_per_m=(faint,) * 3, rayleigh_scale_height_m=1e13, mie_scattering_per_m=(0.0,) * 3,
        mie_extinction_per_m=(0.0,) * 3, absorption_per_m=(0.0,) * 3,
    )  # fmt: skip
    below = np.array([0.0, 2.0, 5.0, 7.0, 8.0])
    found = sky_single(air, over_the_pole(0.0 * below), towards(0.0 * below), towards(90.0 + below), "point")
    shadow = air.radius_m * (1.0 / np.cos(np.radians(below)) - 1.0)
    lit = np.maximum(air.thickness_m - shadow, 0.0)
    np.testing.assert_allclose(found.rayleigh[:, 0], faint * lit, rtol=1e-8)


def test_misses_and_cameras_under_the_floor() -> None:
    out = over_the_pole([70_000.0, 1e9, 36e6])
    away = towards([0.0, 10.0, 165.0])
    np.testing.assert_array_equal(transmittance(EARTH, out, away), 1.0)
    assert not sky_single(EARTH, out, away, [[0.0, 0.0, 1.0]]).radiance.any()
    deep = over_the_pole([-100.0])
    column = transmittance(EARTH, deep, towards([0.0]))
    floor = np.exp(-100.0 * np.array([1.0, 1.0, 0.0]) @ EARTH.extinction_per_m)
    np.testing.assert_allclose(column, transmittance(EARTH, over_the_pole([0.0]), towards([0.0])) * floor, rtol=1e-12)
    # What is seen from below the floor: the air up to a point above it, and what is seen from there through it.
    view, sun = towards([30.0]), towards([60.0])
    point = deep + 500.0 * view
    near = aerial_single(EARTH, deep, point, sun)
    whole = near.radiance + near.transmittance * sky_single(EARTH, point, view, sun).radiance
    np.testing.assert_allclose(sky_single(EARTH, deep, view, sun).radiance, whole, rtol=1e-8)


def test_phase_functions_scatter_all_light() -> None:
    def phases(owner, s: Floats) -> Floats:
        return 2.0 * np.pi * np.stack([rayleigh_phase(s), *(mie_phase(s, g) for g in (-0.5, 0.0, 0.8))], axis=-1)

    found = integrate(phases, np.array([[-1.0, 1.0]]), 4, 1e-12)
    np.testing.assert_allclose(found.value, 1.0, rtol=1e-12)


def test_bad_vectors_are_named() -> None:
    with pytest.raises(ValueError, match="directions: a direction has length 0"):
        transmittance(EARTH, [[0.0, 0.0, 7e6]], [[0.0, 0.0, 0.0]])
    with pytest.raises(ValueError, match="positions_m: expected finite vectors"):
        transmittance(EARTH, [[0.0, np.nan, 7e6]], [[0.0, 0.0, 1.0]])
    with pytest.raises(ValueError, match="sun_visibility: expected one of disc, point"):
        sky_single(EARTH, [[0.0, 0.0, 7e6]], [[0.0, 0.0, -1.0]], [[0.0, 0.0, 1.0]], "both")
