"""OceanBlock: what shaders know of the water. One uniform block for drawing, shading and whoever asks the contract."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...components import Ocean
from ...engine.blocks.layout import Vec3, array
from ...engine.display import reflectance
from ...engine.space import length
from ...engine.surface.nested import NESTED_BASE_M, NestedAnchor, nested_anchor
from ...engine.wavelengths import Nanometres, carried_water
from ...engine.waves import WaveSet
from .lens import FAR_M, LensPlane

__all__ = ["OceanBlock", "diffuse_mirrored", "ocean_block"]

_UNSEEN = 0.003
"""Of a white bed's light: below a step of an 8-bit picture beside what the water itself throws back."""
_LEAST_LOSS_PER_M = 1e-6
_LONGEST_RIPPLE_M, _FINEST_RIPPLE_M = 2.0, 0.01
_DRIFTS_M_S = ((0.55, 0.2), (0.4, -0.3))
"""Of ripples, along the wind and aside: waves of 20 cm run at 0.56 m/s."""
_WHITECAP_LENGTH = 2.5
"""Of a whitecap, along its crest, by its width."""
_WHITECAP_SPEED = 0.75
"""By the wind's: crests run about as fast as the wind, and leave their foam behind."""


@dataclass
class Crests:
    """Where crests break."""

    squeeze: Annotated[float, "of the surface, from which on they do: 1 - Jacobian"]
    deviation: Annotated[float, "standard deviation of the squeeze; 0: nothing breaks"]
    slope_variance: Annotated[float, "of the waves"]
    variance_beyond: Annotated[float, "of slopes shorter than those"]


@dataclass
class Whitecaps:
    """The noise that they are taken from: drawn out along crests, and drifting."""

    heading: Annotated[Vec3, "unit, downwind, planet axes"]
    per_length: Annotated[float, "their width by their length along the crest"]
    anchor: NestedAnchor


@dataclass
class OceanBlock:
    """The water. GLSL: ``generated/ocean.glsl``, instance ``ocean``. Vec3 are at the three wavelengths."""

    scattering_per_m: Vec3
    roughness: Annotated[float, "Beckmann's alpha of the slopes"]
    loss_per_m: Annotated[Vec3, "absorption and scattering"]
    unseen_depth_m: Annotated[float, "from which on the bed cannot be seen"]
    bed_albedo: Vec3
    bed_detail: float
    ice_albedo: Vec3
    ice_sine: Annotated[float, "of the latitude where ice begins; above 1: none"]
    foam_albedo: Vec3
    surf_m: Annotated[float, "how high waves run up a beach"]
    glow_radiance: Annotated[Vec3, "the liquid's own, W m^-2 sr^-1 nm^-1"]
    crust_share: Annotated[float, "of dark crust on it"]
    refractive_index: float
    per_index_squared: Annotated[float, "1 / refractive_index^2"]
    diffuse_mirrored: Annotated[float, "share of diffuse light"]
    caustics: Annotated[float, "their strength"]
    crests: Crests
    whitecaps: Whitecaps
    lens: Annotated[LensPlane, "the surface at the camera"]
    ripple_octave: Annotated[int, "the longest below the shortest wave"]
    ripple_share: Annotated[float, "of the slopes' variance in each octave"]
    anchor: Annotated[NestedAnchor, "for noise on the calm sea"]
    drifting: Annotated[Any, array(NestedAnchor, 2), "the same for ripples, whose two lattices drift"]


def ocean_block(
    ocean: Ocean, waves: WaveSet, anchor: NDArray[np.float64], radius_m: float, nm: Nanometres
) -> OceanBlock:
    """The block of a sea and its waves around an anchor: unit vector (3,), on a planet of this radius, for light at the
    wavelengths `nm`. Ripples have not drifted, and no camera is near."""
    ocean = carried_water(ocean, nm)
    loss = [max(a + s, _LEAST_LOSS_PER_M) for a, s in zip(ocean.absorption_per_m, ocean.scattering_per_m, strict=True)]
    index, place = ocean.refractive_index, nested_anchor(anchor, radius_m)
    octave, share = _ripples(waves)
    return OceanBlock(
        scattering_per_m=tuple(ocean.scattering_per_m),
        roughness=ocean.roughness,
        loss_per_m=tuple(loss),
        unseen_depth_m=-math.log(_UNSEEN) / (2.0 * min(loss)),
        bed_albedo=_reflectance(ocean.bed_albedo, nm),
        bed_detail=ocean.bed_detail,
        ice_albedo=_reflectance(ocean.ice_albedo, nm),
        ice_sine=math.sin(math.radians(ocean.ice_latitude_deg)) if ocean.ice_latitude_deg < 90.0 else 2.0,
        foam_albedo=_reflectance(ocean.foam_albedo, nm),
        surf_m=ocean.surf_m,
        glow_radiance=tuple(ocean.glow),
        crust_share=ocean.crust,
        refractive_index=index,
        per_index_squared=1.0 / index**2,
        diffuse_mirrored=diffuse_mirrored(index),
        caustics=ocean.caustics,
        crests=breaking(ocean, waves),
        whitecaps=Whitecaps((1.0, 0.0, 0.0), 1.0 / _WHITECAP_LENGTH, place),
        lens=LensPlane((0.0, 0.0, 1.0), FAR_M),
        ripple_octave=octave,
        ripple_share=share,
        anchor=place,
        drifting=[place, place],
    )


def _reflectance(color: tuple[float, float, float], nm: Nanometres) -> tuple[float, float, float]:
    red, green, blue = reflectance(color, nm).tolist()
    return red, green, blue


def breaking(ocean: Ocean, waves: WaveSet) -> Crests:
    """The squeeze, sum of Q A k sin, is nearly normal; its quantile leaves the whitecaps' share."""
    share = min(ocean.foam * whitecaps(ocean.wind_speed_m_s), 0.5)
    squeeze = math.sqrt(0.5 * float(np.sum((waves.steepness * waves.amplitude_m * waves.wave_number_per_m) ** 2)))
    limit = NormalDist().inv_cdf(1.0 - share) * squeeze if share > 1e-9 else 1e3
    return Crests(limit, squeeze if share > 1e-9 else 0.0, waves.slope_variance, waves.slope_variance_beyond)


def whitecaps(wind_speed_m_s: float) -> float:
    """Share of the sea that whitecaps cover: 3.84e-6 U^3.41 (Monahan and O'Muircheartaigh 1980)."""
    return 3.84e-6 * wind_speed_m_s**3.41


def _ripples(waves: WaveSet) -> tuple[int, float]:
    """The longest octave and each one's share: noise from half the shortest wave down to _FINEST_RIPPLE_M shares the
    variance evenly."""
    shortest_m = float(waves.wavelength_m[-1]) if len(waves) else _LONGEST_RIPPLE_M
    # Noise on cells of one metre has waves of about two.
    longest = int(np.clip(math.floor(math.log2(0.25 * shortest_m / NESTED_BASE_M)), 0, 6))
    octaves = longest + math.log2(NESTED_BASE_M / _FINEST_RIPPLE_M)
    return longest, 1.0 / octaves


def drifted(
    anchor: NDArray[np.float64], radius_m: float, wind: NDArray[np.float64], time_s: float
) -> list[NestedAnchor]:
    """The block's two lattices that drift. wind: unit heading (3,), the same all over the planet: elsewhere the noise
    goes through the surface at a slant, and changes as it passes."""
    axis = np.array([wind[1], wind[2], wind[0]])
    return [_anchor_at(anchor * radius_m - (along * wind + across * axis) * time_s) for along, across in _DRIFTS_M_S]


def whitecap_anchor(
    anchor: NDArray[np.float64], radius_m: float, wind: NDArray[np.float64], speed_m_s: float, time_s: float
) -> NestedAnchor:
    """Whitecaps.anchor under a wind of this unit heading (3,) and speed."""
    moved = anchor * radius_m - (_WHITECAP_SPEED * speed_m_s * time_s) * wind
    along = (moved @ wind) * wind
    return _anchor_at(along + (moved - along) / _WHITECAP_LENGTH)


def _anchor_at(place_m: NDArray[np.float64]) -> NestedAnchor:
    """Of noise at a place (3,), however far it has drifted: cells are numbered modulo 2^32."""
    distance = max(length(place_m), 1e-9)
    place = nested_anchor(place_m / distance, distance)
    place.cell = tuple(int((v + 2**31) % 2**32 - 2**31) for v in place.cell)
    return place


def diffuse_mirrored(index: float) -> float:
    """Share of a uniform sky's light that a smooth level surface throws back, for an index of refraction >= 1.

    Integral of Fresnel's term over the cosine's square; 0.066 for water (Preisendorfer 1976).
    """
    cosine = (np.arange(256) + 0.5) / 256
    inside = np.sqrt(index**2 - 1.0 + cosine**2)
    s = ((cosine - inside) / (cosine + inside)) ** 2
    p = ((index**2 * cosine - inside) / (index**2 * cosine + inside)) ** 2
    return float(np.mean(cosine * (s + p)))
