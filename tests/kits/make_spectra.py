"""Computes tests/data/spectra_light.csv: light of skies, limbs, suns and lit ground as spectra. Takes some minutes.

    python tests/kits/make_spectra.py

Light is as a share of sunlight outside the air. Single scattering is by quadrature, the rest by paths that all
wavelengths share (benchmarks/reference), so that noise is in the brightness more than in the colour.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from planetfall.benchmarks.reference.air_irradiance import irradiance
from planetfall.benchmarks.reference.air_medium import EARTH_BRUNETON, AirParameters
from planetfall.benchmarks.reference.air_multiple import sky_multiple
from planetfall.benchmarks.reference.air_transmittance import transmittance
from planetfall.benchmarks.reference.spectrum import WAVELENGTHS_NM, spectral_air

TABLE = Path(__file__).parents[1] / "data" / "spectra_light.csv"
CLEAR = EARTH_BRUNETON
HAZY = replace(CLEAR, mie_scattering_per_m=(2.0e-5,) * 3, mie_extinction_per_m=(2.22e-5,) * 3)
"""The preset `earth`."""
PATHS = 8192
Row = tuple[str, str, float, float, float, np.ndarray]


def _direction(elevation_deg: float, azimuth_deg: float = 0.0) -> np.ndarray:
    e, a = np.radians([elevation_deg, azimuth_deg])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def _sky(name: str, air: AirParameters) -> Iterator[Row]:
    """From 10 m above the ground; azimuths from the sun's."""
    place = [0.0, 0.0, air.radius_m + 10.0]
    for sun in (30.0, 10.0, 3.0, 0.0, -2.0, -4.0, -6.0):
        views = [(e, a) for e in (1.0, 4.0, 10.0, 20.0, 40.0) for a in (5.0, 60.0, 180.0)] + [(90.0, 0.0)]
        found = sky_multiple(air, [place], [_direction(*v) for v in views], _direction(sun)[None], paths=PATHS)
        for view, light in zip(views, found.radiance, strict=True):
            yield "sky", name, sun, *view, np.pi * light


def _limb(name: str, air: AirParameters) -> Iterator[Row]:
    """From 400 km: rays whose lowest point is at a height, given in km as the elevation; sunrise and day."""
    place = [0.0, 0.0, air.radius_m + 400e3]
    heights_km = (2.0, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 38.0, 46.0)
    dips = [-np.degrees(np.arccos((air.radius_m + 1e3 * h) / place[2])) for h in heights_km]
    for sun, azimuth in ((-18.6, 4.0), (-19.6, 4.0), (-20.5, 4.0), (-22.0, 4.0), (-20.5, 40.0), (40.0, 90.0)):
        directions = [_direction(dip, azimuth) for dip in dips]
        found = sky_multiple(air, [place], directions, _direction(sun)[None], paths=PATHS)
        for height, light in zip(heights_km, found.radiance, strict=True):
            yield "limb", name, sun, height, azimuth, np.pi * light


def _lit(name: str, air: AirParameters) -> Iterator[Row]:
    """Light on level ground, of sun and sky and of the sky alone; the sun itself, over its own irradiance."""
    place, up = [[0.0, 0.0, air.radius_m + 1.0]], [[0.0, 0.0, 1.0]]
    for sun in (60.0, 30.0, 10.0, 3.0, 0.0, -2.0, -4.0, -6.0):
        found = irradiance(air, place, up, _direction(sun)[None], paths=4 * PATHS, nodes=6)
        yield "ground", name, sun, 0.0, 0.0, found.direct[0] + found.sky[0]
        if sun > 0.0:
            yield "shade", name, sun, 0.0, 0.0, found.sky[0]
    for sun in (10.0, 5.0, 3.0, 1.0, 0.2):
        yield "sun", name, sun, 0.0, 0.0, transmittance(air, place, _direction(sun)[None])[0]


def _from_space(name: str, air: AirParameters) -> Iterator[Row]:
    """What air adds and leaves of the ground seen from 400 km straight down: `haze`, and `through` (of ground's E)."""
    place = [[0.0, 0.0, air.radius_m + 400e3]]
    for sun in (60.0, 30.0, 10.0):
        found = sky_multiple(air, place, [[0.0, 0.0, -1.0]], _direction(sun)[None], paths=4 * PATHS)
        yield "haze", name, sun, -90.0, 0.0, np.pi * found.radiance[0]
        yield "through", name, sun, -90.0, 0.0, found.transmittance[0]


def main() -> None:
    shapes = ",".join(f"per_550_{nm:.0f}" for nm in WAVELENGTHS_NM)
    lines = [f"kind,air,sun_deg,elevation_deg,azimuth_deg,at_550,{shapes}"]
    middle = int(np.searchsorted(WAVELENGTHS_NM, 550.0))
    for name, air in (("clear", CLEAR), ("hazy", HAZY)):
        many = spectral_air(air)
        parts = [_sky, _lit, _from_space] + ([_limb] if name == "hazy" else [])
        for part in parts:
            for kind, of, sun, elevation, azimuth, light in part(name, many):
                shape = ",".join(f"{v:.4g}" for v in light / light[middle])
                lines.append(f"{kind},{of},{sun:g},{elevation:g},{azimuth:g},{light[middle]:.4e},{shape}")
            TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
