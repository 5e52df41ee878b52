"""AtmosphereProbe: what it takes and what it refuses, by name. Its numbers: test_numbers_air.py."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import planetfall as pf

GROUND = (6.371e6, 0.0, 0.0)
UP, LEVEL, SUN = (1.0, 0.0, 0.0), (0.1, 1.0, 0.0), (0.3, 1.0, 0.0)


@pytest.fixture(scope="module")
def air() -> Iterator[pf.AtmosphereProbe]:
    with pf.AtmosphereProbe(pf.load_scene("earth"), quality="low") as made:
        yield made


@pytest.mark.parametrize(
    ("position", "direction", "sun"),
    [
        pytest.param(np.tile(GROUND, (3, 1)), LEVEL, SUN, id="many positions"),
        pytest.param(GROUND, np.tile(LEVEL, (3, 1)), [SUN], id="many directions"),
        pytest.param([6371000, 0, 0], [[1, 10, 0]] * 3, [3, 10, 0], id="whole numbers"),
        pytest.param(np.tile(GROUND, (3, 1)), 1e200 * np.array(LEVEL), 1e-200 * np.array(SUN), id="far from unit"),
    ],
)
def test_rows_are_broadcast_and_directions_need_not_be_unit(
    air: pf.AtmosphereProbe, position: Any, direction: Any, sun: Any
) -> None:
    one = air.sky_radiance(GROUND, LEVEL, SUN)
    many = air.sky_radiance(position, direction, sun)
    assert one.shape == (1, 3) and many.shape == (3, 3)
    # Unit vectors made along another way differ in their last digit, and so may what float32 makes of them.
    np.testing.assert_allclose(many, np.tile(one, (3, 1)), rtol=1e-5)


def test_no_rows_no_answers(air: pf.AtmosphereProbe) -> None:
    none = np.zeros((0, 3))
    assert air.sky_radiance(none, LEVEL, SUN).shape == (0, 3)
    assert air.transmittance(none, none).shape == (0, 3)
    assert [part.shape for part in air.irradiance(none, UP, SUN)] == [(0, 3), (0, 3)]
    assert [part.shape for part in air.in_scattering(none, none, SUN)] == [(0, 3), (0, 3)]


@pytest.mark.parametrize(
    ("argument", "value", "words"),
    [
        pytest.param("positions_m", 1.0, "shape", id="a number"),
        pytest.param("positions_m", np.ones((2, 2, 3)), "shape", id="three axes"),
        pytest.param("positions_m", [[1.0, 2.0], [1.0]], "equally long", id="ragged"),
        pytest.param("directions", "east", "real numbers", id="words"),
        pytest.param("directions", [1j, 0, 0], "real numbers", id="complex"),
        pytest.param("directions", [0.0, np.nan, 0.0], "finite", id="nan"),
        pytest.param("sun_directions", [np.inf, 0.0, 0.0], "finite", id="inf"),
        pytest.param("sun_directions", [0.0, 0.0, 0.0], "zero", id="zero direction"),
        pytest.param("positions_m", [0.0, 0.0, 0.0], "zero", id="the centre"),
        pytest.param("positions_m", [1e200, 0.0, 0.0], "at most", id="too far"),
        pytest.param("directions", np.ones((2, 3)), "expected 1 or 3 rows, found 2", id="counts"),
        pytest.param("orders", 0, "found 0", id="no order"),
        pytest.param("orders", 2.0, "found 2.0", id="a fractional order"),
        pytest.param("orders", True, "found True", id="a flag"),
        pytest.param("part", "ozone", "found 'ozone'", id="an unknown part"),
    ],
)
def test_bad_questions_are_named(air: pf.AtmosphereProbe, argument: str, value: Any, words: str) -> None:
    asked = {"positions_m": np.tile(GROUND, (3, 1)), "directions": LEVEL, "sun_directions": SUN, argument: value}
    with pytest.raises(ValueError, match=f"{argument}.*{words}"):
        air.sky_radiance(**asked)


def test_whole_numbers_of_numpy_are_orders(air: pf.AtmosphereProbe) -> None:
    orders: Any = np.int64(2)
    asked = GROUND, LEVEL, SUN
    np.testing.assert_array_equal(air.sky_radiance(*asked, orders=orders), air.sky_radiance(*asked, orders=2))


def test_distances(air: pf.AtmosphereProbe) -> None:
    for bad in (-1.0, np.nan, np.inf, "far", [1.0, 2.0], [[1.0]] * 3):
        with pytest.raises(ValueError, match="distance_m"):
            air.transmittance(GROUND, UP, bad)
    near, far, farther = air.transmittance(np.tile(GROUND, (3, 1)), UP, [0.0, 1e9, 1e300])
    np.testing.assert_array_equal(near, 1.0)
    np.testing.assert_array_equal(far, farther)


def test_from_a_point_to_itself_there_is_no_air(air: pf.AtmosphereProbe) -> None:
    light, transmittance = air.in_scattering(GROUND, GROUND, SUN)
    assert (light == 0.0).all() and (transmittance == 1.0).all()


def test_without_air_and_after_release() -> None:
    with pytest.raises(ValueError, match="no Atmosphere component"):
        pf.AtmosphereProbe(pf.load_scene("moon"))
    probe = pf.AtmosphereProbe(pf.load_scene("small"), quality="low")
    probe.release()
    probe.release()
    with pytest.raises(ValueError, match="released"):
        probe.transmittance((6e4, 0, 0), UP)
