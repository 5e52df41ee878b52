"""Makes the maps of the presets from formulas and seeds: assets/maps. No data of any mission is in them.

    python docs/make_maps.py

Mars: a dichotomy of plains and highlands, the great volcanoes, canyons and basins at the places and with the sizes that
they have (Smith et al. 2001, "Mars Orbiter Laser Altimeter", J. Geophys. Res. 106, E10, 23689-23722, and the IAU
gazetteer), as cones, troughs and bowls. Moon: basins and dark lava plains by the gazetteer's places, rays of young
craters, highlands as noise. The same machine and numpy give the same files.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from rich.console import Console

from planetfall.engine.srgb import srgb_encode
from planetfall.engine.surface.noise import gradient_noise

Floats = NDArray[np.float64]

MAPS = Path(__file__).resolve().parents[1] / "assets" / "maps"
MARS_RANGE_M, MARS_RADIUS_M = (-9000.0, 23000.0), 3.3895e6
MOON_RANGE_M, MOON_RADIUS_M = (-7000.0, 8000.0), 1.7374e6


def plate(width: int) -> Floats:
    """Unit directions (width / 2, width, 3) of an equirectangular map's pixels."""
    longitude = ((np.arange(width) + 0.5) / width * 2.0 - 1.0) * np.pi
    latitude = (0.5 - (np.arange(width // 2) + 0.5) / (width // 2)) * np.pi
    longitude, latitude = np.meshgrid(longitude, latitude)
    return direction(np.degrees(latitude), np.degrees(longitude))


def direction(latitude_deg: Any, longitude_deg: Any) -> Floats:
    a, b = np.radians(latitude_deg), np.radians(longitude_deg)
    return np.stack([np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)], axis=-1)


def noise(d: Floats, frequency: float, seed: float, octaves: int = 4, ridged: bool = False) -> Floats:
    """Sum of octaves, each half as high as the one before; about -1 to 1 (ridged: 0 to 1)."""
    flat, total, weight = d.reshape(-1, 3), np.zeros(d.shape[0] * d.shape[1]), 1.0
    for k in range(octaves):
        n = 2.0 * gradient_noise(flat * frequency * 2.0**k + (seed + 17.31 * k) * np.array([1.0, 2.3, 3.7]))
        total += weight * (1.0 - 2.0 * np.abs(n) if ridged else n)
        weight *= 0.5
    return (total / (2.0 - 2.0 * weight)).reshape(d.shape[:2])


def smooth(low: float, high: float, x: Floats) -> Floats:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def away(d: Floats, latitude_deg: float, longitude_deg: float, radius_m: float) -> Floats:
    """Distance along the ground from a place, in km."""
    chord = np.linalg.norm(d - direction(latitude_deg, longitude_deg), axis=-1)
    return 2e-3 * radius_m * np.arcsin(np.clip(0.5 * chord, 0.0, 1.0))


def save(name: str, heights: Floats, range_m: tuple[float, float], step_m: float) -> None:
    low, high = range_m
    assert low < heights.min() and heights.max() < high, (heights.min(), heights.max())
    stepped = np.rint(heights / step_m) * step_m  # whole steps make a smaller file
    words = np.rint((stepped - low) / (high - low) * 65535.0).astype(np.uint16)
    Image.fromarray(words).save(MAPS / name, optimize=True)


def volcano(km: Floats, radius_km: float, rise_m: float, caldera_km: float, depth_m: float, scarp_m: float) -> Floats:
    """A shield: gentle above, steeper below, a scarp around its foot and a caldera with a flat floor on top."""
    x = km / radius_km
    body = (rise_m - scarp_m) * np.clip(1.0 - x, 0.0, 1.0) ** 1.15 + scarp_m * smooth(1.02, 0.94, x)
    return body - depth_m * smooth(1.15, 0.85, km / caldera_km)


def mars(width: int = 1280) -> None:
    d = plate(width)
    latitude, longitude = (
        np.degrees(np.arcsin(d[..., 2])),
        np.degrees(np.arctan2(d[..., 1], d[..., 0])),
    )
    rough, broad = noise(d, 9.0, 1.0, 5), noise(d, 2.2, 5.0, 4)
    # Highlands in the south, plains in the north; the border wanders between 10 S and 40 N.
    border = latitude - 12.0 - 22.0 * broad - 14.0 * np.cos(np.radians(longitude - 30.0))
    south = smooth(14.0, -14.0, border + 5.0 * rough)
    h = -4200.0 + 5600.0 * south + (250.0 + 750.0 * south) * rough + 500.0 * broad
    h += 420.0 * south * noise(d, 40.0, 9.0, 3)

    def basin(lat: float, lon: float, radius_km: float, floor_m: float, rim_m: float) -> None:
        nonlocal h
        x = away(d, lat, lon, MARS_RADIUS_M) / radius_km * (1.0 + 0.10 * rough)
        inside = smooth(1.0, 0.62, x)
        h += rim_m * np.exp(-(((x - 1.12) / 0.16) ** 2)) * (1.0 + 0.5 * rough)
        h = h * (1.0 - inside) + (floor_m + 150.0 * rough) * inside

    basin(-42.4, 70.5, 1050.0, -7300.0, 1300.0)  # Hellas
    basin(-49.7, -44.0, 520.0, -3200.0, 900.0)  # Argyre
    basin(12.9, 87.0, 680.0, -3900.0, 500.0)  # Isidis

    # Tharsis: a bulge 5000 km wide, and what stands on it.
    swell = away(d, -3.0, -107.0, MARS_RADIUS_M) * (1.0 + 0.08 * broad)
    h += 6200.0 * smooth(2700.0, 300.0, swell) * (0.75 + 0.25 * south)
    h = h * (1.0 - 0.6 * smooth(2200.0, 900.0, swell)) + 0.6 * 4600.0 * smooth(2200.0, 900.0, swell)
    lava = noise(d, 60.0, 3.0, 3)
    for lat, lon, radius, top, caldera, depth, scarp in (
        (18.65, -133.8, 310.0, 21300.0, 40.0, 2800.0, 5200.0),  # Olympus
        (11.92, -104.1, 235.0, 17600.0, 25.0, 3000.0, 900.0),  # Ascraeus
        (1.48, -112.9, 190.0, 13700.0, 24.0, 3200.0, 700.0),  # Pavonis
        (-8.26, -120.1, 235.0, 17200.0, 58.0, 1200.0, 800.0),  # Arsia
        (25.02, 147.2, 190.0, 13400.0, 10.0, 0.0, 400.0),  # Elysium
        (40.5, -109.6, 700.0, 6400.0, 60.0, 700.0, 300.0),  # Alba
    ):
        km = away(d, lat, lon, MARS_RADIUS_M) * (1.0 + 0.035 * rough + 0.02 * lava)
        foot = float(np.median(h[np.abs(km - 1.1 * radius) < 30.0]))
        flat = smooth(1.25, 0.9, km / radius)
        h = h * (1.0 - flat) + foot * flat + volcano(km, radius, top - foot, caldera, depth, scarp) + 90.0 * lava * flat
    # Canyons: troughs along lines, with walls 30 km wide that wind, from Noctis in the west to the chaos in the east.
    wind = 0.9 * noise(d, 14.0, 7.0, 4) + 0.35 * noise(d, 60.0, 8.0, 3)
    for west, east, lat0, lat1, half_km, depth_m in (
        (-95.0, -58.0, -6.8, -11.8, 62.0, 6800.0),  # Tithonium to Coprates
        (-92.0, -62.0, -7.8, -13.0, 40.0, 5200.0),
        (-79.0, -66.0, -5.6, -6.6, 52.0, 5600.0),  # Ophir and Candor
        (-77.0, -64.0, -12.6, -11.6, 78.0, 7200.0),  # Melas
        (-60.0, -42.0, -13.6, -12.4, 74.0, 5200.0),  # Eos
        (-44.0, -30.0, -11.5, -1.0, 90.0, 3000.0),  # the outflow
        (-101.0, -94.0, -8.5, -6.8, 70.0, 3000.0),  # Noctis
    ):
        t = np.clip((longitude - west) / (east - west), 0.0, 1.0)
        middle = lat0 + (lat1 - lat0) * t
        across = (latitude - middle) * 59.2 + 70.0 * wind
        beyond = np.maximum(np.maximum(west - longitude, longitude - east), 0.0) * 59.2
        km = np.hypot(across, beyond)
        taper = 0.55 + 0.45 * smooth(0.0, 0.25, t) * smooth(1.0, 0.85, t)
        floor = smooth(half_km * taper + 16.0, half_km * taper - 16.0, km)
        h = np.minimum(h, h * (1.0 - floor) + floor * (4300.0 - depth_m - 2500.0 * t**2 + 350.0 * rough))
    # Ice, in two kilometres of layers.
    for pole in (1.0, -1.0):
        cap = smooth(980.0, 1000.0, 1000.0 * pole * d[..., 2] + 6.0 * rough) * smooth(
            978.0, 999.0, 1000.0 * pole * d[..., 2]
        )
        h += 2200.0 * cap
    save("mars_relief.png", h, MARS_RANGE_M, 16.0)


SEAS = (
    # latitude, longitude, radius in km, depth of the basin in m
    (33.0, -16.0, 570.0, 2600.0),  # Imbrium
    (28.0, 17.5, 340.0, 2400.0),  # Serenitatis
    (8.5, 31.0, 430.0, 1700.0),  # Tranquillitatis
    (17.0, 59.0, 270.0, 3200.0),  # Crisium
    (-7.8, 51.0, 420.0, 1500.0),  # Fecunditatis
    (-15.0, 35.0, 170.0, 2300.0),  # Nectaris
    (-24.0, -39.0, 210.0, 2300.0),  # Humorum
    (-21.0, -17.0, 360.0, 1300.0),  # Nubium
    (18.0, -57.0, 800.0, 1300.0),  # Procellarum
    (-10.0, -32.0, 330.0, 1300.0),  # Cognitum, Insularum
    (56.0, 1.0, 340.0, 1400.0),  # Frigoris, its middle
    (-20.0, -95.0, 170.0, 3200.0),  # Orientale
    (27.0, 148.0, 140.0, 3500.0),  # Moscoviense
    (13.0, 3.6, 130.0, 900.0),  # Vaporum
)


def moon(width: int = 1024) -> None:
    d = plate(width)
    bays = noise(d, 3.4, 26.0, 3)
    rough, broad, fine = noise(d, 7.0, 21.0, 5), noise(d, 2.0, 22.0, 3), noise(d, 45.0, 23.0, 4)
    relief = 500.0 + 1500.0 * broad + 900.0 * rough
    # The far side's great southern basin, and the highlands north of it.
    x = away(d, -53.0, -169.0, MOON_RADIUS_M) / 1150.0 * (1.0 + 0.08 * rough)
    relief -= 4800.0 * smooth(1.05, 0.55, x)
    relief += 1800.0 * smooth(1700.0, 300.0, away(d, 8.0, -160.0, MOON_RADIUS_M))
    lava = np.zeros(d.shape[:2])
    for lat, lon, radius, depth in SEAS:
        x = away(d, lat, lon, MOON_RADIUS_M) / radius * (1.0 + 0.30 * bays + 0.14 * rough + 0.04 * fine)
        inside = smooth(1.06, 0.80, x)
        relief = relief * (1.0 - inside) - depth * inside
        relief += 0.35 * depth * np.exp(-(((x - 1.18) / 0.12) ** 2)) * (1.0 + 0.6 * fine)
        lava = np.maximum(lava, smooth(1.02, 0.90, x))
    highland = (1.0 - lava) * (0.6 + 0.4 * smooth(-0.4, 0.6, rough))
    kept = relief[::2, ::2] + (260.0 * highland * noise(d, 120.0, 24.0, 2) + 12.0 * lava * fine)[::2, ::2]
    save("moon_relief.png", 0.93 * kept, MOON_RANGE_M, 4.0)

    # Albedos: highlands 0.12 to 0.17, lava 0.06 to 0.075 with provinces of its own.
    color = 0.145 + 0.020 * rough + 0.014 * fine + 0.010 * broad
    dark = 0.066 + 0.009 * noise(d, 5.0, 27.0, 3) + 0.004 * fine
    color = color * (1.0 - lava) + dark * lava
    for lat, lon, size, reach in (
        (-43.3, -11.2, 43.0, 1500.0),  # Tycho
        (9.6, -20.1, 46.0, 600.0),  # Copernicus
        (8.1, -38.0, 16.0, 400.0),  # Kepler
        (23.7, -47.5, 20.0, 300.0),  # Aristarchus
        (-8.9, 61.1, 36.0, 450.0),  # Langrenus
        (36.0, 102.9, 11.0, 700.0),  # Giordano Bruno
        (-40.0, 172.0, 30.0, 800.0),
        (-20.7, -150.0, 30.0, 600.0),
    ):
        km = away(d, lat, lon, MOON_RADIUS_M)
        center = direction(lat, lon)
        east = np.cross([0.0, 0.0, 1.0], center)
        east /= np.linalg.norm(east)
        azimuth = np.arctan2(d @ np.cross(center, east), d @ east)
        ring = np.stack([np.cos(azimuth), np.sin(azimuth), 0.002 * km + lat], axis=-1)
        streak = smooth(0.0, 0.45, noise(ring, 4.0, 31.0 + lon, 3)) * smooth(
            reach, 0.15 * reach, km * (1.0 - 0.25 * fine)
        )
        halo = smooth(3.2 * size, 1.1 * size, km * (1.0 + 0.2 * fine))
        color += (0.13 * streak * np.exp(-km / (0.6 * reach)) + 0.07 * halo) * (1.0 + 0.4 * fine)
    warm = np.stack([1.06 + 0.02 * broad, np.ones_like(broad), 0.93 - 0.02 * broad + 0.03 * lava], axis=-1)
    encoded = np.rint(255.0 * srgb_encode(color[..., None] * warm)).astype(np.uint8)
    Image.fromarray(encoded).save(MAPS / "moon_color.jpg", quality=88, subsampling=0)


if __name__ == "__main__":
    console = Console()
    MAPS.mkdir(parents=True, exist_ok=True)
    mars()
    moon()
    for file in sorted(MAPS.iterdir()):
        console.print(f"{file.name}: {file.stat().st_size / 1024:.0f} KiB")
