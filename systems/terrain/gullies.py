"""Gullies: relief whose furrows run down the slope and branch, in float64, as assets/shaders/terrain/gullies.glsl.

A layer of relief is noise of no direction. Where the ground is steep, water draws lines down it: there a layer becomes
waves that run along the contour, so that their crests and furrows lie across it. Each layer follows the slope of the
ground with the longer layers' furrows, so that its own lead into them.

That waves follow the slope of what is there already is what erosion filters of shaders do. The waves: gully_waves.py.

Derivatives are exact but for two things in the turning of the slope: how the ranges' weights change counts as none, and
valleys as straight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.noise import Corners
from .gully_waves import ROUND, TURN, Wave, wave_values
from .height_steps import RIDGE_SLOPE

__all__ = [
    "AMPLITUDE",
    "CREST",
    "END_BELOW_SAMPLES",
    "END_GULLY",
    "FALLING_LAYERS",
    "FIRST_GULLY",
    "FULL",
    "LEAST",
    "ROUND",
    "TURN",
    "GullyLayers",
    "crest_slopes",
    "gully_layers",
    "shader",
]

Floats = NDArray[np.float64]

FIRST_GULLY, END_GULLY = 6, 12
"""Layers of relief that may become gullies: 2 km to 64 m on Earth."""
END_BELOW_SAMPLES = 14
"""The same of layers below the samples of real ground: to 16 m, or one of SRTM would be all there is."""
FALLING_LAYERS = FIRST_GULLY
"""Layers before these say which way is down."""
AMPLITUDE = 0.3
"""Of waves, in amplitudes of the noise in whose place they stand: their root mean squares are 0.71 and 0.28."""
LEAST, FULL = 0.03, 0.2
"""Slopes from which on there are gullies, and nothing else."""
WARPED = 1
"""The first of them have the lattice of layers that the narrow warp moves."""
CREST = 0.15
"""Noise below which a ridged layer says less and less about which way is down: crests are gentle to both sides."""


def crest_slopes(n: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Of layers' values by their noise, crests rounder than `ridge_slope` has them: the slope and how it changes."""
    inside = np.clip(n * (1.0 / CREST), -1.0, 1.0)
    slope = 1.0 - np.abs(share) - share * RIDGE_SLOPE * inside
    return slope, np.where(np.abs(inside) < 1.0, share * (-RIDGE_SLOPE / CREST), 0.0)


@dataclass(frozen=True)
class GullyLayers:
    """Of the layers from FIRST_GULLY on, K of them, at N places; the derivatives, by metre, if they were asked for."""

    share: Floats
    """(K, N) 0..1, of waves; the rest is noise"""
    wave: Floats
    """(K, N) in amplitudes of the layers"""
    d_share: Floats | None = None
    """(3, K, N)"""
    d_wave: Floats | None = None
    """(3, K, N)"""


def gully_layers(
    layers: Callable[[int], Corners],
    frequency: Floats,
    amplitude_m: Floats,
    falls: Floats,
    up: Floats,
    rough: Floats,
    strength: float,
    d_falls: Floats | None = None,
    bent: Floats | None = None,
) -> GullyLayers:
    """layers: of each octave, by its number from the first on, the corners around the places. frequency (K,),
    amplitude_m (K,) or (K, N) of them. falls (3, N): slope of the ground without them. rough (N,): metres by metre of
    relief. d_falls (3, 3, N): how the slope [a] changes with the place [b], for derivatives. bent (3, 3, N): how the
    place [a] that the warped layers are asked at changes with it [b]."""
    count, places = len(frequency), falls.shape[1]
    # What a wave adds to the slope where its phase alone changes.
    steers = -AMPLITUDE * TURN * amplitude_m.reshape(count, -1) * frequency[:, None]
    share, wave = np.zeros((count, places)), np.zeros((count, places))
    d_share = np.zeros((3, count, places)) if d_falls is not None else None
    d_wave = np.zeros((3, count, places)) if d_falls is not None else None
    whole = GullyLayers(share, wave, d_share, d_wave)
    # Gentle ground has none, and so nothing that could make it steeper.
    level = falls - up * (up * falls).sum(axis=0)
    at = np.flatnonzero((level * level).sum(axis=0) > LEAST * LEAST)
    if not at.size:
        return whole
    some = at.size < places
    if some:
        falls, up, rough = (v.take(at, axis=-1) for v in (falls, up, rough))
        d_falls = None if d_falls is None else d_falls.take(at, axis=-1)
        bent = None if bent is None else bent.take(at, axis=-1)
        steers = steers.take(at, axis=-1) if amplitude_m.ndim == 2 else steers
        share, wave = np.empty((count, at.size)), np.empty((count, at.size))
        d_share = None if d_share is None else np.empty((3, count, at.size))
        d_wave = None if d_wave is None else np.empty((3, count, at.size))
    if d_falls is None:

        def corners(k: int) -> Corners:
            return layers(k).at(at) if some else layers(k)

        _follow(corners, falls, up, rough, strength, steers, share, wave)
        if some:
            whole.share[:, at], whole.wave[:, at] = share, wave
        return whole
    for k in range(count):
        level = falls - up * (up * falls).sum(axis=0)
        steep = np.sqrt((level * level).sum(axis=0))
        inverse = 1.0 / np.maximum(steep, 1e-6)
        along = _cross(up, level) * inverse
        cells = layers(k)
        if some:
            cells = cells.at(at)
        found = Wave(cells, along)
        t = np.clip((steep - LEAST) * (1.0 / (FULL - LEAST)), 0.0, 1.0)
        share[k] = strength * (t * t * (3.0 - 2.0 * t))
        wave[k] = AMPLITUDE * found.value.real
        steering = rough * steers[k]
        pull = share[k] * found.value.imag
        if d_falls is not None and d_share is not None and d_wave is not None:
            d_level = d_falls - up[:, None] * np.einsum("an,abn->bn", up, d_falls)
            down = level * inverse
            d_steep = np.einsum("an,abn->bn", down, d_level)
            turning = np.stack([_cross(up, d_level[:, b] - down * d_steep[b]) for b in range(3)], axis=1) * inverse
            change = found.derivative(turning * (1.0 / frequency[k]), bent if k < WARPED else None) * frequency[k]
            d_share[:, k] = (strength / (FULL - LEAST)) * (6.0 * t * (1.0 - t)) * d_steep
            d_wave[:, k] = AMPLITUDE * change.real
            d_pull = d_share[:, k] * found.value.imag + share[k] * change.imag
            d_falls = d_falls + steering * (along[:, None] * d_pull[None] + pull * turning)
        falls = falls + steering * pull * along
    if some:
        whole.share[:, at], whole.wave[:, at] = share, wave
        if whole.d_share is not None and whole.d_wave is not None:
            whole.d_share[:, :, at], whole.d_wave[:, :, at] = d_share, d_wave
    return whole


def _follow(
    layers: Callable[[int], Corners], falls: Floats, up: Floats, rough: Floats, strength: float, steers: Floats,
    share: Floats, wave: Floats,
) -> None:  # fmt: skip
    """Fills share and wave (K, N), without derivatives: the slope along the ground as two numbers, by axes of which the
    first points where it falls without gullies. steers (K, 1) or (K, N): slope by what of each layer turns with its
    phase."""
    level = falls - up * np.einsum("an,an->n", up, falls)
    steep = np.sqrt(np.einsum("an,an->n", level, level))
    ahead = level * (1.0 / np.maximum(steep, 1e-6))
    aside, p, q = _cross(up, ahead), steep, np.zeros_like(steep)
    for k in range(len(share)):
        t = np.minimum(np.maximum((steep - LEAST) * (1.0 / (FULL - LEAST)), 0.0), 1.0)
        np.multiply(t * t * (3.0 - 2.0 * t), strength, out=share[k])
        inverse = 1.0 / np.maximum(steep, 1e-6)
        a, b = q * -inverse, p * inverse
        found, pull = wave_values(layers(k), a * ahead + b * aside)
        np.multiply(found, AMPLITUDE, out=wave[k])
        if k + 1 < len(share):
            pull *= share[k]
            pull *= rough
            pull *= steers[k]
            p, q = p + pull * a, q + pull * b
            steep = np.sqrt(p * p + q * q)


def shader() -> str:
    """GLSL: the numbers that both sides share."""
    whole = {"FIRST": FIRST_GULLY, "END": END_GULLY, "END_BELOW_SAMPLES": END_BELOW_SAMPLES}
    numbers = {
        "AMPLITUDE": AMPLITUDE, "TURN": TURN, "LEAST": LEAST, "FULL": FULL, "CREST": CREST, "ROUND": ROUND,
        "RIDGE_SLOPE": RIDGE_SLOPE,
    }  # fmt: skip
    return "".join(
        [f"const int GULLY_{name} = {v};\n" for name, v in whole.items()]
        + [f"const float GULLY_{name} = {v!r};\n" for name, v in numbers.items()]
    )


def _cross(a: Floats, b: Floats) -> Floats:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
