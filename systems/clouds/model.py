"""CloudModel: what a planet's clouds consist of, in float64, checked as a whole."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from ...components import MOST_CLOUD_LAYERS
from ...engine.settings import SettingError

__all__ = ["CloudModel", "CloudSettings", "LayerModel", "LayerSettings"]

LEAST_SHARE, MOST_SHARE = 1.0e-8, 1.0
"""Thickness and top of a layer as shares of the planet's radius: single precision has no thinner shells, and one as
thick as the planet is none."""
MOST_ASYMMETRY = 0.99
"""At 1 the phase function is infinite ahead and zero elsewhere."""


_PRINTED = {"ours": 0, "paper_2018": 2018, "paper_2019": 2019}


class LayerSettings(Protocol):
    """What is read from a CloudLayer."""

    base_m: float
    top_m: float
    extinction_per_m: float
    albedo: float
    asymmetry: float
    density_model: str
    height_profile: str
    coverage: float
    wind_speed_m_s: float


class CloudSettings(LayerSettings, Protocol):
    """What is read from the Clouds component."""

    method: str

    @property
    def layers(self) -> Sequence[LayerSettings]:
        """The layers beside its own."""
        ...


class _Sphere(Protocol):
    radius_m: float


class _Air(Protocol):
    thickness_m: float


@dataclass(frozen=True)
class LayerModel:
    """One layer; fields as those of components.CloudLayer."""

    base_m: float
    top_m: float
    extinction_per_m: float
    albedo: float
    asymmetry: float
    density_model: str
    height_profile: str
    coverage: float
    wind_speed_m_s: float

    @property
    def empty(self) -> bool:
        """Whether it takes no light anywhere."""
        return self.extinction_per_m == 0.0 or self.coverage == 0.0

    @property
    def vertical_optical_depth(self) -> float:
        """From base to top, where the cloud is densest all the way."""
        mean = 2.0 / 3.0 if self.height_profile == "parabola" else 1.0
        return mean * self.extinction_per_m * (self.top_m - self.base_m)


@dataclass(frozen=True)
class CloudModel:
    """All cloud layers of one planet. Making one raises SettingError that lists all that doesn't fit.

    air_thickness_m: of the air that they float in; infinite where the planet has none.
    """

    radius_m: float
    layers: tuple[LayerModel, ...]
    air_thickness_m: float = math.inf
    method: str = "ours"

    def __post_init__(self) -> None:
        problems = _problems(self)
        if problems:
            raise SettingError("; ".join(problems))

    @staticmethod
    def from_components(planet: _Sphere, clouds: CloudSettings, atmosphere: _Air | None) -> CloudModel:
        """The clouds of a Planet, a Clouds and perhaps an Atmosphere; SettingError where they don't fit."""
        names = [f.name for f in dataclasses.fields(LayerModel)]
        layers = (clouds, *clouds.layers)
        return CloudModel(
            float(planet.radius_m),
            tuple(LayerModel(**{name: getattr(layer, name) for name in names}) for layer in layers),
            math.inf if atmosphere is None else float(atmosphere.thickness_m),
            clouds.method,
        )

    @property
    def printed(self) -> int:
        """The year of the source whose march it is as printed; 0: ours."""
        return _PRINTED[self.method]

    @property
    def uniform(self) -> bool:
        """Whether no layer has weather: optical depths are then known in closed form."""
        return all(layer.density_model == "uniform" for layer in self.layers if not layer.empty)

    @property
    def present(self) -> tuple[LayerModel, ...]:
        """The layers that take light somewhere."""
        return tuple(layer for layer in self.layers if not layer.empty)

    @property
    def lowest_m(self) -> float:
        """The lowest base of what is present; infinite without any."""
        return min((layer.base_m for layer in self.present), default=math.inf)

    @property
    def highest_m(self) -> float:
        """The highest top of what is present; minus infinity without any."""
        return max((layer.top_m for layer in self.present), default=-math.inf)


def _problems(clouds: CloudModel) -> list[str]:
    problems: list[str] = []
    if len(clouds.layers) > MOST_CLOUD_LAYERS:
        problems.append(
            f"Clouds.layers: expected at most {MOST_CLOUD_LAYERS - 1} further layers, found {len(clouds.layers) - 1}; "
            "join those that lie above one another"
        )
    for number, layer in enumerate(clouds.layers):
        where = "Clouds" if number == 0 else f"Clouds.layers[{number - 1}]"
        problems += [f"{where}.{text}" for text in _layer_problems(layer, clouds.radius_m, clouds.air_thickness_m)]
    return problems


def _layer_problems(layer: LayerModel, radius_m: float, air_m: float) -> list[str]:
    numbers = {f.name: getattr(layer, f.name) for f in dataclasses.fields(layer) if f.type == "float"}
    bad = [f"{name}: expected a finite number, found {value!r}" for name, value in numbers.items()
           if not math.isfinite(value)]  # fmt: skip
    if bad:
        return bad
    problems = []
    if layer.base_m < 0.0:
        problems.append(f"base_m: expected at least 0 m (the reference sphere), found {layer.base_m:g} m")
    if layer.top_m <= layer.base_m:
        problems.append(f"base_m ({layer.base_m:g} m) has to be below top_m ({layer.top_m:g} m); swap them")
    elif layer.top_m - layer.base_m < LEAST_SHARE * radius_m:
        problems.append(
            f"top_m: expected at least {LEAST_SHARE:g} of Planet.radius_m ({radius_m:g} m) above base_m "
            f"({layer.base_m:g} m), found {layer.top_m:g} m"
        )
    if layer.top_m > air_m:
        problems.append(
            f"top_m: expected at most Atmosphere.thickness_m ({air_m:g} m), found {layer.top_m:g} m: clouds float in "
            "air. Lower the layer, or raise the air"
        )
    elif layer.top_m > MOST_SHARE * radius_m:
        problems.append(
            f"top_m: expected at most Planet.radius_m ({radius_m:g} m), found {layer.top_m:g} m. Lower the layer"
        )
    if layer.extinction_per_m < 0.0:
        problems.append(f"extinction_per_m: expected at least 0, found {layer.extinction_per_m:g}")
    for name in ("albedo", "coverage"):
        if not 0.0 <= getattr(layer, name) <= 1.0:
            problems.append(f"{name}: expected a number from 0 to 1, found {getattr(layer, name):g}")
    if abs(layer.asymmetry) > MOST_ASYMMETRY:
        problems.append(
            f"asymmetry: expected a number from {-MOST_ASYMMETRY:g} to {MOST_ASYMMETRY:g}, found {layer.asymmetry:g}. "
            "Nearer to 1 the glow around the sun grows without limit"
        )
    return problems
