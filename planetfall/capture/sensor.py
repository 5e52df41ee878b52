"""Sensor: the digital numbers that a camera's image sensor gives of a picture's radiance, after EMVA 1288."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..engine.wavelengths import DISPLAY_NM
from ..errors import SettingError

__all__ = ["Sensor"]

Floats = NDArray[np.float64]

PATTERNS = ("mono", "rgb", "RGGB", "BGGR", "GRBG", "GBRG")
PLANCK_J_S, LIGHT_M_S = 6.62607015e-34, 299792458.0
"""Exact by definition (SI, 2019)."""
_LARGEST_SEED = 2**64
_LARGEST_WELL_E = 1e12  # numpy's Poisson numbers are of 64 bits
_FIXED, _TEMPORAL = 0, 1
"""Which of a seed's streams of random numbers is meant."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensor:
    """An image sensor of the linear model of EMVA 1288 (release 4.0 linear, sections 2 and 4). Needs no GPU.

    `expose` makes digital numbers of `Renderer.render(..., outputs=("radiance",))["radiance"]`. The defaults are about
    those of an industrial camera with 5 megapixels of 3.45 um, its gain such that a full well is the largest number.

    pixel_pitch_m: side of a square pixel. quantum_efficiency: electrons per photon that falls on a pixel, 0..1: one
    number; (3,), one for each wavelength; or (3, 3), a row for each colour filter red, green, blue, a column for each
    wavelength. With one number or three a colour filter lets its own wavelength through alone, and a pixel of a
    "mono" sensor counts all three.
    full_well_e: electrons that a pixel holds. dark_e_s: dark current. read_noise_e: standard deviation of what is read
    of a pixel that holds nothing. dsnu_e, prnu: standard deviations from pixel to pixel of the dark signal, in
    electrons, and of the response to light, as a share (DSNU1288, PRNU1288): the fixed pattern.
    gain_dn_e: digital numbers per electron (K). black_level_dn: added to all; less than some 3 gain_dn_e read_noise_e
    cuts the noise of dark pixels at 0. bits: 1..16; numbers above 2^bits - 1 become that.
    pattern: "mono"; "rgb", three numbers a pixel as of three sensors behind a prism; or a Bayer mosaic "RGGB", "BGGR",
    "GRBG", "GBRG", the first two letters being the picture's top row.
    seed: chooses the noise. Of the same seed and frame come the same bits (with the same release of numpy), and the
    fixed pattern is the same in all frames of a size.
    wavelengths_nm: of the radiance, red first: `Renderer.wavelengths_nm`. band_nm: how wide a band of the spectrum each
    of them stands for; None: up to halfway to the next one, and as far on the outer side.

    SettingError for what cannot be.
    """

    pixel_pitch_m: float = 3.45e-6
    quantum_efficiency: ArrayLike = 0.6
    full_well_e: float = 10_500.0
    dark_e_s: float = 3.0
    read_noise_e: float = 2.3
    dsnu_e: float = 1.0
    prnu: float = 0.006
    gain_dn_e: float = 0.38
    black_level_dn: float = 64.0
    bits: int = 12
    pattern: str = "RGGB"
    seed: int = 0
    wavelengths_nm: tuple[float, float, float] = DISPLAY_NM
    band_nm: tuple[float, float, float] | None = None
    _response: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.pattern not in PATTERNS:
            raise SettingError(f"Sensor.pattern: expected one of {', '.join(PATTERNS)}, found {self.pattern!r}")
        for name in ("pixel_pitch_m", "gain_dn_e"):
            _number(f"Sensor.{name}", getattr(self, name), above=True)
        _number("Sensor.full_well_e", self.full_well_e, above=True, most=_LARGEST_WELL_E)
        for name in ("dark_e_s", "read_noise_e", "dsnu_e", "black_level_dn"):
            _number(f"Sensor.{name}", getattr(self, name))
        _number("Sensor.prnu", self.prnu, most=1.0)
        _whole("Sensor.bits", self.bits, 1, 16)
        _whole("Sensor.seed", self.seed, 0, _LARGEST_SEED - 1)
        if self.black_level_dn > self.largest_dn:
            raise SettingError(
                f"Sensor.black_level_dn: expected at most {self.largest_dn}, the largest number of {self.bits} bits,"
                f" found {self.black_level_dn!r}"
            )
        # A photon has h c / wavelength joules; a band's radiance is that at its wavelength times its width.
        per_radiance = np.array(self.wavelengths) * 1e-9 / (PLANCK_J_S * LIGHT_M_S) * self.bands
        response = self._efficiency() * per_radiance
        object.__setattr__(self, "_response", response.sum(axis=0) if self.pattern == "mono" else response)

    def _efficiency(self) -> Floats:
        """(3, 3): a row for each colour filter, a column for each wavelength."""
        where = "Sensor.quantum_efficiency"
        try:
            given = np.asarray(self.quantum_efficiency, np.float64)
        except (TypeError, ValueError):
            given = np.empty(0)
        if given.shape not in ((), (3,), (3, 3)) or not ((given >= 0.0) & (given <= 1.0)).all():
            raise SettingError(
                f"{where}: expected 0 to 1, as a number, (3,) or (3, 3), found {self.quantum_efficiency!r}"
            )
        if given.ndim == 2 and self.pattern == "mono":
            raise SettingError(
                f'{where}: a "mono" sensor has no colour filters: expected a number or (3,), found {given.tolist()}'
            )
        return given if given.ndim == 2 else np.diag(np.broadcast_to(given, (3,)))

    @property
    def wavelengths(self) -> tuple[float, float, float]:
        """(3,) nm, falling; SettingError for others."""
        nm = _three("Sensor.wavelengths_nm", self.wavelengths_nm)
        if not nm[0] > nm[1] > nm[2]:
            raise SettingError(f"Sensor.wavelengths_nm: expected falling numbers, red first, found {list(nm)}")
        return nm

    @property
    def bands(self) -> Floats:
        """(3,) nm: how wide a band of the spectrum each wavelength stands for."""
        if self.band_nm is not None:
            return np.array(_three("Sensor.band_nm", self.band_nm))
        red, green, blue = self.wavelengths
        return np.array([red - green, 0.5 * (red - blue), green - blue])

    @property
    def largest_dn(self) -> int:
        """2^bits - 1."""
        return 2**self.bits - 1

    # -- the model ---------------------------------------------------------------------------------------------------

    def electrons(
        self, radiance: ArrayLike, exposure_s: float, f_number: float, transmission: ArrayLike = 1.0
    ) -> Floats:
        """Mean electrons of light (H, W), or (H, W, 3) for "rgb", without noise, and without a full well to end them.

        radiance: (H, W, 3), W m^-2 sr^-1 nm^-1. f_number: the lens's focal length over its entrance pupil's width,
        focused far away: a pixel's irradiance is pi / (4 f_number^2) times the radiance (the sine condition).
        transmission: of the lens, 0..1: a number, or (H, W) with its vignetting. Natural vignetting is cos^4.
        """
        light = self._light(radiance)
        shape = light.shape[:2]
        _number("exposure_s", exposure_s, above=True)
        _number("f_number", f_number, above=True)
        passed = np.asarray(transmission, np.float64)
        if passed.shape not in ((), shape) or not ((passed >= 0.0) & (passed <= 1.0)).all():
            raise SettingError(f"transmission: expected 0 to 1, as a number or {shape}, found shape {passed.shape}")
        lens = passed * (0.25 * math.pi / f_number**2 * self.pixel_pitch_m**2 * exposure_s)
        if self.pattern == "mono":
            return (light @ self._response) * lens
        if self.pattern == "rgb":
            return (light @ self._response.T) * lens[..., None]
        found = np.empty(shape)
        for place, letter in enumerate(self.pattern):
            cells = np.s_[place // 2 :: 2, place % 2 :: 2]
            found[cells] = light[cells] @ self._response["RGB".index(letter)]
        return found * lens

    def predicted(
        self, radiance: ArrayLike, exposure_s: float, f_number: float, transmission: ArrayLike = 1.0
    ) -> tuple[Floats, Floats]:
        """Mean (DN) and temporal variance (DN^2) after EMVA 1288, each of the shape of what `expose` gives.

        mean = black level + K (light + dark), variance = K^2 (read noise^2 + dark + light) + 1/12, of electrons that a
        pixel without a fixed pattern has. They hold below the full well and the largest number, and well above 0.
        """
        light = self.electrons(radiance, exposure_s, f_number, transmission)
        collected = light + self.dark_e_s * exposure_s
        mean = self.black_level_dn + self.gain_dn_e * collected
        return mean, self.gain_dn_e**2 * (self.read_noise_e**2 + collected) + 1.0 / 12.0

    def expose(
        self,
        radiance: ArrayLike,
        exposure_s: float,
        f_number: float,
        frame: int = 0,
        transmission: ArrayLike = 1.0,
    ) -> NDArray[np.unsignedinteger[Any]]:
        """Digital numbers (H, W), or (H, W, 3) for "rgb", row 0 on top: uint8 up to 8 bits, uint16 above.

        frame: number of the frame, from 0, each with noise of its own; the rest as in `electrons`. Radiance may be
        infinite, as of a sun: such pixels are full. SettingError for other shapes, NaN and negative numbers.
        """
        _whole("frame", frame, 0, _LARGEST_SEED - 1)
        light = self.electrons(radiance, exposure_s, f_number, transmission)
        offset, response = _fixed_pattern(self.seed, light.shape)
        noise = _random(self.seed, _TEMPORAL, frame)
        mean = light * np.maximum(1.0 + self.prnu * response, 0.0) + self.dark_e_s * exposure_s
        # Far beyond a full well more makes no difference, and a Poisson number has to be finite.
        charge = np.minimum(noise.poisson(np.minimum(mean, 4.0 * self.full_well_e + 1e4)), self.full_well_e)
        charge = charge + self.dsnu_e * offset + self.read_noise_e * noise.standard_normal(light.shape)
        numbers = np.clip(np.rint(self.black_level_dn + self.gain_dn_e * charge), 0.0, self.largest_dn)
        return numbers.astype(np.uint8 if self.bits <= 8 else np.uint16)

    def _light(self, radiance: ArrayLike) -> Floats:
        try:
            light = np.asarray(radiance, np.float64)
        except (TypeError, ValueError):
            light = np.empty((0, 0, 0))
        if light.ndim != 3 or light.shape[-1] != 3 or not light.size:
            raise SettingError(
                f"radiance: expected (H, W, 3) in W m^-2 sr^-1 nm^-1, found shape {np.shape(radiance)}: take that of"
                ' renderer.render(camera, outputs=("radiance",))'
            )
        bad = np.argwhere(~(light >= 0.0))
        if len(bad):
            row, column, channel = bad[0].tolist()
            raise SettingError(
                f"radiance[{row}, {column}, {channel}]: expected 0 or more, found {light[row, column, channel]}"
            )
        return np.minimum(light, 1e30)  # a sum with an infinite number times 0 would be NaN


def _random(seed: int, stream: int, frame: int = 0) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(np.random.SeedSequence([seed, stream, frame])))


@lru_cache(maxsize=2)
def _fixed_pattern(seed: int, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    """Standard normal numbers of each pixel, for its dark signal and for its response."""
    made = _random(seed, _FIXED).standard_normal((2, *shape))
    made.flags.writeable = False
    return made[0], made[1]


def _number(name: str, value: object, above: bool = False, most: float = math.inf) -> None:
    """above: 0 itself is too little."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) or number > most or not (number > 0.0 if above else number >= 0.0):
        least = "a number above 0" if above else "a number from 0 up"
        limit = f", at most {most:g}" if math.isfinite(most) else ""
        raise SettingError(f"{name}: expected {least}{limit}, found {value!r}")


def _whole(name: str, value: object, least: int, most: int) -> None:
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = least - 1
    if isinstance(value, bool) or not least <= number <= most:
        raise SettingError(f"{name}: expected a whole number from {least} to {most}, found {value!r}")


def _three(name: str, values: object) -> tuple[float, float, float]:
    try:
        red, green, blue = (float(v) for v in values)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        red = green = blue = math.nan
    if not all(math.isfinite(v) and v > 0.0 for v in (red, green, blue)):
        raise SettingError(f"{name}: expected three numbers above 0, in nanometres, found {values!r}")
    return red, green, blue
