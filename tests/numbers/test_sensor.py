"""pf.Sensor: held against the equations of EMVA 1288, against that standard's reference implementation, which measures
it as a camera on a bench, and against OpenCV's names of Bayer mosaics."""

from __future__ import annotations

import itertools
import math
import re
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf

SIZE = (200, 240)
EXPOSURE_S, F_NUMBER = 0.02, 5.6
FRAMES = 24


def flat(value: float) -> NDArray[np.float64]:
    """A picture whose green alone shines, W m^-2 sr^-1 nm^-1."""
    return np.broadcast_to((0.0, value, 0.0), (*SIZE, 3))


def photons_per_radiance(sensor: pf.Sensor) -> float:
    """That fall on a pixel, of green light: EMVA 1288, equations 1 to 3, behind a lens."""
    nm, band_nm = 550.0, 85.0  # halfway to 610 and 440
    irradiance = math.pi / (4.0 * F_NUMBER**2) * band_nm
    return irradiance * sensor.pixel_pitch_m**2 * EXPOSURE_S * nm * 1e-9 / (6.62607015e-34 * 299792458.0)


@pytest.mark.parametrize("share", [0.0, 0.003, 0.05, 0.4, 0.8])
@pytest.mark.parametrize("bits, gain, full_well_e", [(8, 0.3, 700.0), (12, 0.38, 10_500.0), (16, 6.0, 10_500.0)])
def test_mean_and_variance_are_those_of_emva_1288(share: float, bits: int, gain: float, full_well_e: float) -> None:
    black = 8.0 * gain * 2.3 + 2.0
    sensor = pf.Sensor(
        pattern="mono", bits=bits, gain_dn_e=gain, black_level_dn=black, dark_e_s=300.0, prnu=0.0, dsnu_e=0.0, seed=4,
        full_well_e=full_well_e,
    )  # fmt: skip
    photons = share * full_well_e / 0.6
    pictures = [
        sensor.expose(flat(photons / photons_per_radiance(sensor)), EXPOSURE_S, F_NUMBER, n) for n in range(FRAMES)
    ]
    stack = np.stack(pictures).astype(float)
    # Equations 7, 8, 14 and 15: K (mu_d + eta mu_p) above the black level, K^2 sigma_d^2 + 1/12 + K (mu_y - mu_y.dark).
    dark_e = 300.0 * EXPOSURE_S
    mean = black + gain * (dark_e + 0.6 * photons)
    variance = gain**2 * (2.3**2 + dark_e) + 1.0 / 12.0 + gain * (mean - black - gain * dark_e)
    assert stack.mean() == pytest.approx(mean, rel=0.01)
    assert stack.var(axis=0, ddof=1).mean() == pytest.approx(variance, rel=0.01)
    found = sensor.predicted(flat(photons / photons_per_radiance(sensor)), EXPOSURE_S, F_NUMBER)
    np.testing.assert_allclose(found[0], mean, rtol=1e-9)
    np.testing.assert_allclose(found[1], variance, rtol=1e-9)


def test_the_reference_implementation_measures_what_was_set(monkeypatch: pytest.MonkeyPatch) -> None:
    process = pytest.importorskip("emva1288.process", reason="pip install emva1288, the standard's own program")
    routines = pytest.importorskip("emva1288.process.routines")
    monkeypatch.setattr(np, "asfarray", np.asarray, raising=False)  # a name that numpy 2 has no longer
    sensor = pf.Sensor(
        pattern="mono", quantum_efficiency=0.5, dark_e_s=200.0, dsnu_e=6.0, prnu=0.01, read_noise_e=8.0, seed=9
    )
    numbers = itertools.count()

    def taken(photons: float, count: int) -> dict[str, Any]:
        light = flat(photons / photons_per_radiance(sensor))
        return routines.get_int_imgs([sensor.expose(light, EXPOSURE_S, F_NUMBER, next(numbers)) for _ in range(count)])

    def summed(images: dict[str, Any]) -> dict[str, Any]:
        return {**images, "sum": int(images["sum"].sum()), "pvar": int(images["pvar"].sum())}

    full = 10_500.0 / 0.5
    points = np.linspace(0.0, 1.1, 34) * full
    exposure_ns = EXPOSURE_S * 1e9
    data = process.Data1288(
        {
            "width": SIZE[1],
            "height": SIZE[0],
            "temporal": {exposure_ns: {float(photons): summed(taken(photons, 2)) for photons in points}},
            "spatial": {exposure_ns: {photons: taken(photons, 40) for photons in (0.0, 0.5 * full)}},
        }
    ).data
    found = process.Results1288(data, pixel_area=(sensor.pixel_pitch_m * 1e6) ** 2)
    assert pytest.approx(0.38, rel=0.01) == found.K
    assert pytest.approx(50.0, rel=0.01) == found.QE  # per cent
    assert found.sigma_d == pytest.approx(math.hypot(8.0, math.sqrt(200.0 * EXPOSURE_S)), rel=0.01)
    assert pytest.approx(1.0, rel=0.02) == found.PRNU1288  # per cent, of 48 000 pixels
    assert pytest.approx(6.0, rel=0.02) == found.DSNU1288
    assert found.u_e_sat == pytest.approx(10_500.0, rel=0.04)  # the nearest of the points


def test_the_same_seed_and_frame_give_the_same_bits() -> None:
    light = flat(0.001) + 0.001
    sensor, twin = pf.Sensor(seed=7), pf.Sensor(seed=7)
    first = sensor.expose(light, EXPOSURE_S, F_NUMBER, 3)
    sensor.expose(light, EXPOSURE_S, F_NUMBER, 2)  # an order of frames leaves nothing behind
    np.testing.assert_array_equal(first, twin.expose(light, EXPOSURE_S, F_NUMBER, 3))
    assert (first != twin.expose(light, EXPOSURE_S, F_NUMBER, 4)).mean() > 0.8
    assert (first != pf.Sensor(seed=8).expose(light, EXPOSURE_S, F_NUMBER, 3)).mean() > 0.8


def test_the_fixed_pattern_is_the_same_in_every_frame() -> None:
    sensor = pf.Sensor(pattern="mono", prnu=0.05, dsnu_e=20.0)

    def mean_of(value: float, first: int) -> NDArray[np.float64]:
        frames = range(first, first + FRAMES)
        return np.mean([sensor.expose(flat(value), EXPOSURE_S, F_NUMBER, n) for n in frames], axis=0)

    for value in (0.0, 0.002):
        a, b = mean_of(value, 0), mean_of(value, FRAMES)
        assert np.corrcoef(a.ravel(), b.ravel())[0, 1] > 0.95


@pytest.mark.parametrize("pattern", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_mosaics_are_those_that_opencv_undoes(pattern: str) -> None:
    cv2 = pytest.importorskip("cv2", reason="pip install opencv-python-headless")
    # OpenCV names a mosaic by its second row's second and third pixel.
    code = {"RGGB": "BG", "BGGR": "RG", "GRBG": "GB", "GBRG": "GR"}[pattern]
    bands = (1.0, 1.0, 1.0)
    sensor = pf.Sensor(
        pattern=pattern, prnu=0, dsnu_e=0, read_noise_e=0, dark_e_s=0, black_level_dn=0, bits=16, gain_dn_e=1.0,
        full_well_e=60_000, band_nm=bands,
    )  # fmt: skip
    light = np.broadcast_to((4.0, 2.0, 1.0), (32, 48, 3)) * 0.1
    numbers = sensor.expose(light, EXPOSURE_S, F_NUMBER)
    assert numbers.shape == (32, 48) and numbers.dtype == np.uint16
    colors = cv2.cvtColor(numbers, getattr(cv2, f"COLOR_Bayer{code}2RGB"))[4:-4, 4:-4]
    prism = pf.Sensor(pattern="rgb", gain_dn_e=1.0, bits=16, full_well_e=60_000, band_nm=bands, black_level_dn=0.0)
    mean, _ = prism.predicted(light, EXPOSURE_S, F_NUMBER)
    dark = prism.dark_e_s * EXPOSURE_S
    np.testing.assert_allclose(colors.mean(axis=(0, 1)), mean[0, 0] - dark, rtol=0.01)
    assert prism.expose(light, EXPOSURE_S, F_NUMBER).shape == (32, 48, 3)


def test_filters_that_leak_and_lenses_that_darken() -> None:
    leaky = np.array([[0.6, 0.1, 0.0], [0.05, 0.5, 0.1], [0.0, 0.1, 0.4]])
    clean = pf.Sensor(pattern="rgb", quantum_efficiency=1.0)
    sensor = pf.Sensor(pattern="rgb", quantum_efficiency=leaky)
    light = np.random.default_rng(1).uniform(0.0, 0.1, (6, 8, 3))
    all_photons = clean.electrons(light, 0.01, 4.0)
    np.testing.assert_allclose(sensor.electrons(light, 0.01, 4.0), all_photons @ leaky.T, rtol=1e-12)
    falloff = np.linspace(0.3, 1.0, 48).reshape(6, 8)
    darkened = sensor.electrons(light, 0.01, 4.0, transmission=falloff)
    np.testing.assert_allclose(darkened, sensor.electrons(light, 0.01, 4.0) * falloff[..., None], rtol=1e-12)
    mono = pf.Sensor(pattern="mono", quantum_efficiency=(0.2, 0.4, 0.6))
    np.testing.assert_allclose(mono.electrons(light, 0.01, 4.0), all_photons @ (0.2, 0.4, 0.6), rtol=1e-12)
    np.testing.assert_allclose(sensor.electrons(light, 0.01, 8.0), sensor.electrons(light, 0.01, 4.0) / 4.0)


def test_what_is_too_bright_is_full() -> None:
    bright = np.full((4, 4, 3), np.inf)
    assert (pf.Sensor(bits=10).expose(bright, 1.0, 1.0) == 1023).all()
    small = pf.Sensor(full_well_e=1000.0, read_noise_e=0.0, dsnu_e=0.0, gain_dn_e=1.0, black_level_dn=10.0)
    assert (small.expose(bright, 1.0, 1.0) == 1010).all()
    assert pf.Sensor(bits=8, gain_dn_e=0.02, black_level_dn=2.0).expose(bright, 1.0, 1.0).dtype == np.uint8


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"pattern": "rggb"}, "Sensor.pattern: expected one of mono, rgb, RGGB"),
        ({"bits": 17}, "Sensor.bits: expected a whole number from 1 to 16, found 17"),
        ({"bits": 11.5}, "Sensor.bits"),
        ({"full_well_e": 1e300}, "Sensor.full_well_e: expected a number above 0, at most 1e+12, found 1e+300"),
        ({"bits": True}, "Sensor.bits: expected a whole number from 1 to 16, found True"),
        ({"full_well_e": 0.0}, "Sensor.full_well_e: expected a number above 0, at most 1e+12, found 0.0"),
        ({"read_noise_e": float("nan")}, "Sensor.read_noise_e: expected a number from 0 up, found nan"),
        ({"gain_dn_e": "high"}, "Sensor.gain_dn_e"),
        ({"prnu": 6.0}, "Sensor.prnu: expected a number from 0 up, at most 1, found 6.0"),
        ({"black_level_dn": 5000.0}, "Sensor.black_level_dn: expected at most 4095"),
        ({"quantum_efficiency": 60}, "Sensor.quantum_efficiency: expected 0 to 1"),
        ({"quantum_efficiency": np.eye(3), "pattern": "mono"}, "no colour filters"),
        ({"wavelengths_nm": (440.0, 550.0, 610.0)}, "red first"),
        ({"band_nm": (60.0, 0.0, 60.0)}, "Sensor.band_nm: expected three numbers above 0"),
        ({"seed": -1}, "Sensor.seed"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(pf.SettingError, match=re.escape(words)):
        pf.Sensor(**settings)


def test_a_picture_that_cannot_be_is_refused() -> None:
    sensor, light = pf.Sensor(), np.ones((4, 6, 3))
    for radiance, words in (
        (light[..., 0], "expected \\(H, W, 3\\)"),
        (-light, "radiance\\[0, 0, 0\\]"),
        ("x", "shape"),
    ):
        with pytest.raises(pf.SettingError, match=words):
            sensor.expose(radiance, 0.01, 4.0)
    for arguments, words in (
        ((0.0, 4.0), "exposure_s: expected a number above 0"),
        ((0.01, -4.0), "f_number"),
        ((0.01, 4.0, -1), "frame: expected a whole number"),
        ((0.01, 4.0, 0, 2.0), "transmission: expected 0 to 1"),
        ((0.01, 4.0, 0, np.ones((6, 4))), "transmission"),
    ):
        with pytest.raises(pf.SettingError, match=words):
            sensor.expose(light, *arguments)
