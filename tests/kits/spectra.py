"""Light of skies, limbs, low suns and lit ground as spectra (tests/data), and how far shown colours are from seen ones.

Spectra are shares of sunlight outside the air, at the wavelengths of planetfall.benchmarks.reference.spectrum.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from planetfall.benchmarks.reference.spectrum import delta_e_2000, lab, seen_colour

DATA = Path(__file__).parents[1] / "data"
GREY = 0.3
"""Luminance to which every sample is exposed before colours are compared, white being 1."""
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class Light:
    """A row of spectra_light.csv; tests/data/README.md says what the kinds are."""

    kind: str
    air: str
    sun_deg: float
    elevation: float
    azimuth_deg: float
    spectrum: np.ndarray


@lru_cache(maxsize=1)
def lights() -> tuple[Light, ...]:
    with (DATA / "spectra_light.csv").open(newline="") as file:
        rows = list(csv.reader(file))[1:]
    found = []
    for kind, air, *numbers in rows:
        sun, elevation, azimuth, middle, *shape = map(float, numbers)
        found.append(Light(kind, air, sun, elevation, azimuth, middle * np.array(shape)))
    return tuple(found)


@lru_cache(maxsize=1)
def grounds() -> dict[str, np.ndarray]:
    """Reflectance by name."""
    with (DATA / "spectra_ground.csv").open(newline="") as file:
        return {name: np.array(values, dtype=float) for name, _, *values in list(csv.reader(file))[1:]}


@lru_cache(maxsize=1)
def samples() -> tuple[np.ndarray, np.ndarray]:
    """Kinds (N,) and spectra (N, W): skies, limbs, suns; every ground in sun and in shade, and from space by day."""
    kinds, spectra = [], []
    for light in lights():
        if light.kind in ("sky", "limb", "sun"):
            kinds.append(light.kind)
            spectra.append(light.spectrum)
        elif light.kind in ("ground", "shade"):
            for reflectance in grounds().values():
                kinds.append(light.kind)
                spectra.append(light.spectrum * reflectance)
        elif light.kind == "haze":
            here = {o.kind: o.spectrum for o in lights() if (o.air, o.sun_deg) == (light.air, light.sun_deg)}
            for reflectance in grounds().values():
                kinds.append("space")
                spectra.append(light.spectrum + here["through"] * here["ground"] * reflectance)
    return np.array(kinds), np.array(spectra)


def colour_errors(shown: np.ndarray, spectra: np.ndarray) -> np.ndarray:
    """CIEDE2000 (N,) of linear sRGB (N, 3) to what an eye sees of spectra (N, W), both cut to what displays show."""
    seen = seen_colour(spectra)
    exposure = (GREY / (seen @ LUMINANCE))[:, None]
    return delta_e_2000(lab(np.maximum(shown * exposure, 0.0)), lab(np.maximum(seen * exposure, 0.0)))
