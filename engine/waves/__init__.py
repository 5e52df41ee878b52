"""Waves on a sphere in float64: sets of waves, spectra, Gerstner displacement, and their reduction to an anchor."""

from .anchor import AnchoredWaves, at_anchor, phases
from .gerstner import METHODS, Surface, displacement, normal, surface
from .inverse import RESIDUAL_M, at_directions
from .set import MOST_WAVES, SeaState, WaveError, WaveSet, make_waves, waves_of
from .shoaling import footprint_weight, shoaling

__all__ = [
    "METHODS",
    "MOST_WAVES",
    "RESIDUAL_M",
    "AnchoredWaves",
    "SeaState",
    "Surface",
    "WaveError",
    "WaveSet",
    "at_anchor",
    "at_directions",
    "displacement",
    "footprint_weight",
    "make_waves",
    "normal",
    "phases",
    "shoaling",
    "surface",
    "waves_of",
]
