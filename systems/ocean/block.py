"""OceanBlock: what shaders know of the water. One uniform block for drawing, shading and whoever asks the contract."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Ocean
from ...engine.gpu.layout import IVec4, Vec4
from ...engine.space import length
from ...engine.surface.nested import NESTED_BASE_M, nested_anchor
from ...engine.waves import WaveSet

__all__ = ["OceanBlock", "diffuse_mirrored", "ocean_block"]

_UNSEEN = 0.003
"""Of a white bed's light: below a step of an 8-bit picture beside what the water itself throws back."""
_LEAST_LOSS_PER_M = 1e-6
_LONGEST_RIPPLE_M, _FINEST_RIPPLE_M = 2.0, 0.01
_DRIFTS_M_S = ((0.55, 0.2), (0.4, -0.3))
"""Of ripples, along the wind and aside: waves of 20 cm run at 0.56 m/s."""


@dataclass
class OceanBlock:
    """The water. GLSL: ``generated/ocean.glsl``, instance ``ocean``."""

    absorption: Vec4
    """1/m at the three wavelengths"""
    scattering: Vec4
    """1/m at the three wavelengths"""
    bed: Vec4
    """albedo of the ground below"""
    water: Vec4
    """(roughness: Beckmann's alpha of the slopes, sine of the latitude where ice begins (above 1: none), 0, 0)"""
    ice: Vec4
    """albedo of sea ice"""
    loss: Vec4
    """1/m: absorption and scattering; w: depth in m from which on the bed cannot be seen"""
    liquid: Vec4
    """(index of refraction, its inverse square, share of diffuse light that is mirrored, 0)"""
    show: Vec4
    """(foam on crests, height that waves run up a beach in m, caustics, detail of the bed)"""
    foam: Vec4
    """albedo of foam"""
    glow: Vec4
    """the liquid's own radiance, W m^-2 sr^-1 nm^-1; w: share of dark crust on it"""
    lens: Vec4
    """the surface at the camera as a plane: xyz unit normal, w the camera's height over it in m; far away very large"""
    crest: Vec4
    """breaking crests: (squeeze from which on, its standard deviation, slope variance beyond the waves, of theirs)"""
    ripples: Vec4
    """(the longest octave below the shortest wave, share of the slopes' variance in each, 0, 0)"""
    drift_cell: IVec4
    """as anchor_cell, for ripples: their lattice drifts"""
    drift_fraction: Vec4
    drift_cell_2: IVec4
    """a second one, in another direction"""
    drift_fraction_2: Vec4
    anchor_cell: IVec4
    """the anchor's place for nested noise: whole cells"""
    anchor_fraction: Vec4
    """the rest of it"""


def ocean_block(ocean: Ocean, waves: WaveSet, anchor: Any, radius_m: float) -> OceanBlock:
    """The block of a sea and its waves around an anchor: unit vector (3,), on a planet of this radius. Ripples have not
    drifted, and no camera is near."""
    ice = math.sin(math.radians(ocean.ice_latitude_deg)) if ocean.ice_latitude_deg < 90.0 else 2.0
    loss = [max(a + s, _LEAST_LOSS_PER_M) for a, s in zip(ocean.absorption_per_m, ocean.scattering_per_m, strict=True)]
    index = ocean.refractive_index
    cell, fraction = nested_anchor(anchor, radius_m)
    return OceanBlock(
        absorption=(*ocean.absorption_per_m, 0.0),
        scattering=(*ocean.scattering_per_m, 0.0),
        bed=(*ocean.bed_albedo, 0.0),
        water=(ocean.roughness, ice, 0.0, 0.0),
        ice=(*ocean.ice_albedo, 0.0),
        loss=(*loss, -math.log(_UNSEEN) / (2.0 * min(loss))),
        liquid=(index, 1.0 / index**2, diffuse_mirrored(index), 0.0),
        show=(ocean.foam, ocean.surf_m, ocean.caustics, ocean.bed_detail),
        foam=(*ocean.foam_albedo, 0.0),
        glow=(*ocean.glow, ocean.crust),
        crest=breaking(ocean, waves),
        ripples=_ripples(waves),
        lens=(0.0, 0.0, 1.0, 1.0e9),
        drift_cell=cell,
        drift_fraction=fraction,
        drift_cell_2=cell,
        drift_fraction_2=fraction,
        anchor_cell=cell,
        anchor_fraction=fraction,
    )


def breaking(ocean: Ocean, waves: WaveSet) -> tuple[float, float, float, float]:
    """OceanBlock.crest: the squeeze, sum of Q A k sin, is nearly normal; its quantile leaves the whitecaps' share."""
    share = min(ocean.foam * whitecaps(ocean.wind_speed_m_s), 0.5)
    squeeze = math.sqrt(0.5 * float(np.sum((waves.steepness * waves.amplitude_m * waves.wave_number_per_m) ** 2)))
    limit = NormalDist().inv_cdf(1.0 - share) * squeeze if share > 1e-9 else 1e3
    return (limit, squeeze if share > 1e-9 else 0.0, waves.slope_variance_beyond, waves.slope_variance)


def whitecaps(wind_speed_m_s: float) -> float:
    """Share of the sea that whitecaps cover: 3.84e-6 U^3.41 (Monahan and O'Muircheartaigh 1980)."""
    return 3.84e-6 * wind_speed_m_s**3.41


def _ripples(waves: WaveSet) -> tuple[float, float, float, float]:
    """OceanBlock.ripples: octaves of noise from half the shortest wave down to _FINEST_RIPPLE_M share the variance."""
    shortest_m = float(waves.wavelength_m[-1]) if len(waves) else _LONGEST_RIPPLE_M
    # Noise on cells of one metre has waves of about two.
    longest = int(np.clip(math.floor(math.log2(0.25 * shortest_m / NESTED_BASE_M)), 0, 6))
    octaves = longest + math.log2(NESTED_BASE_M / _FINEST_RIPPLE_M)
    return (float(longest), 1.0 / octaves, 0.0, 0.0)


def drifted(
    anchor: NDArray[np.float64], radius_m: float, wind: NDArray[np.float64], time_s: float
) -> tuple[tuple[int, ...], tuple[float, ...], tuple[int, ...], tuple[float, ...]]:
    """The block's two lattices that drift. wind: unit heading (3,), the same all over the planet: elsewhere the noise
    goes through the surface at a slant, and changes as it passes."""
    found: list[tuple[Any, ...]] = []
    axis = np.array([wind[1], wind[2], wind[0]])
    for along, across in _DRIFTS_M_S:
        moved = anchor * radius_m - (along * wind + across * axis) * time_s
        distance = length(moved)
        (i, j, k, _), fraction = nested_anchor(moved / distance, distance)
        cell = tuple(int((v + 2**31) % 2**32 - 2**31) for v in (i, j, k))
        found += [(*cell, 0), fraction]
    return found[0], found[1], found[2], found[3]


def diffuse_mirrored(index: float) -> float:
    """Share of a uniform sky's light that a smooth level surface throws back, for an index of refraction >= 1.

    Integral of Fresnel's term over the cosine's square; 0.066 for water (Preisendorfer 1976).
    """
    cosine = (np.arange(256) + 0.5) / 256
    inside = np.sqrt(index**2 - 1.0 + cosine**2)
    s = ((cosine - inside) / (cosine + inside)) ** 2
    p = ((index**2 * cosine - inside) / (index**2 * cosine + inside)) ** 2
    return float(np.mean(cosine * (s + p)))
