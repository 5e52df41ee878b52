"""Waves on a sphere in float64: sets of waves, spectra, Gerstner displacement, and their reduction to an anchor."""

from .anchor import AnchoredWaves, at_anchor, phases
from .gerstner import METHODS, Surface, WaveMethod, displacement, normal, surface, wave_method
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
    "WaveMethod",
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
    "wave_method",
    "waves_of",
]
