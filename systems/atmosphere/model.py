"""AirModel: what a planet's air consists of, in float64, checked as a whole.

Gas and haze thin out exponentially, an absorbing layer has a linear peak (Bruneton 2017, density profiles); the phase
functions are Rayleigh's and Cornette and Shanks' (1992). Heights count from the reference sphere, the air's floor.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.settings import SettingError

__all__ = ["AirModel", "AirSettings"]

Array = NDArray[np.float64]

LEAST_SHARE, MOST_SHARE = 1.0e-5, 1.0
"""Thickness of air as a share of the planet's radius. Thinner is a film that no view shows; thicker is no shell."""
MOST_DEPTH = 1.0e3
"""Vertical optical depth: at 1000 nothing is left of light (e^-1000 is no float64), so more is a mistake in units."""
MOST_ASYMMETRY = 0.99
"""At 1 the phase function is infinite ahead and zero elsewhere."""
_SLACK = 1.0e-6  # extinction that was computed in float32 from scattering may be this much lower


class AirSettings(Protocol):
    """What is read from the Atmosphere component."""

    thickness_m: float
    rayleigh_scattering_per_m: tuple[float, float, float]
    rayleigh_scale_height_m: float
    mie_scattering_per_m: tuple[float, float, float]
    mie_extinction_per_m: tuple[float, float, float]
    mie_scale_height_m: float
    mie_asymmetry: float
    absorption_per_m: tuple[float, float, float]
    absorption_center_m: float
    absorption_half_width_m: float
    ground_albedo: tuple[float, float, float]


class _Sphere(Protocol):
    radius_m: float


@dataclass(frozen=True, eq=False)
class AirModel:
    """Everything that light in the air depends on, but for the sun's strength. Compare models by `key()`.

    Coefficients are (3,) per metre at the three wavelengths: scattering and extinction at the floor, absorption at the
    layer's centre; arrays are read-only. Making one raises SettingError that lists all that doesn't fit.
    """

    radius_m: float
    thickness_m: float
    rayleigh_scattering: Array
    rayleigh_height_m: float
    mie_scattering: Array
    mie_extinction: Array
    mie_height_m: float
    asymmetry: float
    absorption: Array
    absorption_center_m: float
    absorption_half_width_m: float
    ground_albedo: Array
    sun_angular_radius_rad: float

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = np.array(getattr(self, field.name), dtype=np.float64)
            value.setflags(write=False)
            object.__setattr__(self, field.name, value if field.name in _VECTORS else float(value))
        problems = _single_problems(self) or _joint_problems(self)
        if problems:
            raise SettingError("; ".join(problems))
        # An extinction within the slack would make the haze glow.
        enough = np.maximum(self.mie_extinction, self.mie_scattering)
        enough.setflags(write=False)
        object.__setattr__(self, "mie_extinction", enough)

    @staticmethod
    def from_components(planet: _Sphere, atmosphere: AirSettings, sun_angular_radius_rad: float) -> AirModel:
        """The air of a Planet and an Atmosphere under a sun of this size; SettingError where they don't fit."""
        return AirModel(
            radius_m=planet.radius_m,
            sun_angular_radius_rad=sun_angular_radius_rad,
            **{name: getattr(atmosphere, field) for name, field in _FIELDS.items()},
        )

    @property
    def top_radius_m(self) -> float:
        """From the planet's centre to the top of the air."""
        return self.radius_m + self.thickness_m

    @property
    def longest_path_m(self) -> float:
        """From the floor along the horizon to the top of the air."""
        return math.sqrt(self.thickness_m * (2.0 * self.radius_m + self.thickness_m))

    def density(self, height_m: ArrayLike) -> Array:
        """(..., 3): gas, haze, absorbing layer at heights (...), relative to where their coefficients hold.

        Below the floor it is that of the floor, above the top 0.
        """
        h = np.asarray(height_m, dtype=np.float64)
        low = np.maximum(h, 0.0)
        parts = (
            np.exp(-low / self.rayleigh_height_m),
            np.exp(-low / self.mie_height_m),
            np.maximum(1.0 - np.abs(low - self.absorption_center_m) / self.absorption_half_width_m, 0.0),
        )
        return np.stack(parts, axis=-1) * (h <= self.thickness_m)[..., None]

    def vertical_optical_depth(self) -> Array:
        """(3,): from the floor straight up to the top, in closed form."""
        return np.sum(_depths(self), axis=0)

    def key(self) -> str:
        """SHA-256 of all values, in hexadecimal: equal for equal air, to name what was computed from it."""
        digest = hashlib.sha256()
        for field in dataclasses.fields(self):
            # + 0.0 makes -0.0 the 0.0 that it equals.
            values = np.atleast_1d(np.asarray(getattr(self, field.name), dtype="<f8")) + 0.0
            digest.update(f"{field.name}:{len(values)}:".encode() + values.astype("<f8").tobytes())
        return digest.hexdigest()


_FIELDS = {
    "thickness_m": "thickness_m",
    "rayleigh_scattering": "rayleigh_scattering_per_m",
    "rayleigh_height_m": "rayleigh_scale_height_m",
    "mie_scattering": "mie_scattering_per_m",
    "mie_extinction": "mie_extinction_per_m",
    "mie_height_m": "mie_scale_height_m",
    "asymmetry": "mie_asymmetry",
    "absorption": "absorption_per_m",
    "absorption_center_m": "absorption_center_m",
    "absorption_half_width_m": "absorption_half_width_m",
    "ground_albedo": "ground_albedo",
}
"""Field of the model: field of the component. Messages speak of the component, as that is what people set."""

_NAMES = {
    "radius_m": "Planet.radius_m",
    "sun_angular_radius_rad": "Sun.angular_radius_rad",
    **{name: f"Atmosphere.{field}" for name, field in _FIELDS.items()},
}
_VECTORS = {"rayleigh_scattering", "mie_scattering", "mie_extinction", "absorption", "ground_albedo"}
_POSITIVE = {
    "radius_m", "thickness_m", "rayleigh_height_m", "mie_height_m", "absorption_half_width_m", "sun_angular_radius_rad"
}  # fmt: skip


def _single_problems(air: AirModel) -> list[str]:
    """What one value alone shows. Components refuse most of it already when it is assigned."""
    problems = []
    for name, where in _NAMES.items():
        value = getattr(air, name)
        found = f"found {_shown(value)}"
        if name in _VECTORS and np.shape(value) != (3,):
            problems.append(f"{where}: expected 3 numbers, {found}. Give one for each wavelength")
        elif not np.all(np.isfinite(value)):
            problems.append(f"{where}: expected finite numbers, {found}. Give a finite number")
        elif name in _POSITIVE and value <= 0.0:
            problems.append(f"{where}: expected more than 0, {found}. Give a positive number")
        elif name == "ground_albedo" and not np.all((value >= 0.0) & (value <= 1.0)):
            problems.append(f"{where}: expected 3 numbers from 0 to 1, {found}. Ground gives back no more than it gets")
        elif name in _VECTORS and not np.all(value >= 0.0):
            problems.append(f"{where}: expected 3 numbers, at least 0, {found}. Air that takes nothing away has 0")
        elif name == "asymmetry" and abs(value) > MOST_ASYMMETRY:
            problems.append(
                f"{where}: expected a number from {-MOST_ASYMMETRY:g} to {MOST_ASYMMETRY:g}, {found}. Nearer to 1 the "
                "glow around the sun grows without limit"
            )
    return problems


def _joint_problems(air: AirModel) -> list[str]:
    """What only values together show."""
    problems = []
    least, most = LEAST_SHARE * air.radius_m, MOST_SHARE * air.radius_m
    # A share computed as radius * 1e-5 may come out a rounding below.
    if not least * (1.0 - 1e-9) <= air.thickness_m <= most * (1.0 + 1e-9):
        remedy = f"use at least {least:g} m" if air.thickness_m < least else f"use at most {most:g} m"
        problems.append(
            f"Atmosphere.thickness_m: expected {LEAST_SHARE:g} to {MOST_SHARE:g} of Planet.radius_m "
            f"({air.radius_m:g} m), found {air.thickness_m:g} m; {remedy}"
        )
    for channel in range(3):
        scattered, taken = float(air.mie_scattering[channel]), float(air.mie_extinction[channel])
        if taken < scattered * (1.0 - _SLACK):
            problems.append(
                f"Atmosphere.mie_extinction_per_m[{channel}]: expected at least mie_scattering_per_m[{channel}] "
                f"({scattered:g} 1/m), found {taken:g} 1/m. Extinction is scattering plus absorption: raise it, or "
                "lower the scattering"
            )
    depths = _depths(air)
    total = depths.sum(axis=0)
    if np.any(total > MOST_DEPTH):
        channel = int(np.argmax(total))
        part = ("rayleigh_scattering_per_m", "mie_extinction_per_m", "absorption_per_m")[np.argmax(depths[:, channel])]
        problems.append(
            f"Atmosphere.{part}: expected a vertical optical depth of at most {MOST_DEPTH:g} from floor to top, "
            f"found {total[channel]:.4g} at wavelength [{channel}], most of it from {part}. Lower it (the unit is 1/m, "
            "not 1/km) or the height of the air"
        )
    return problems


def _depths(air: AirModel) -> Array:
    """(3 parts, 3 wavelengths): vertical optical depths of gas, haze and absorbing layer."""
    top = air.thickness_m

    def exponential(height_m: float) -> float:
        return -height_m * math.expm1(-top / height_m)

    def below(height_m: float) -> float:
        """Integral of the tent from its foot up to a height, in half widths."""
        u = min(max((height_m - air.absorption_center_m) / air.absorption_half_width_m, -1.0), 1.0)
        return 0.5 * (1.0 + u) ** 2 if u <= 0.0 else 1.0 - 0.5 * (1.0 - u) ** 2

    return np.array(
        [
            air.rayleigh_scattering * exponential(air.rayleigh_height_m),
            air.mie_extinction * exponential(air.mie_height_m),
            air.absorption * air.absorption_half_width_m * (below(top) - below(0.0)),
        ]
    )


def _shown(value: Any) -> str:
    return repr(tuple(value.tolist())) if isinstance(value, np.ndarray) and value.ndim else f"{float(value):g}"
