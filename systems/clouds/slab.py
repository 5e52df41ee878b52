"""Light that is scattered more than once in an even plane slab of cloud: what the march looks up.

The phase function of Henyey and Greenstein is cut after DEGREE harmonics, its forward peak of the share g^(DEGREE + 1)
counted as not scattered (delta-M, Wiscombe 1977). The moments of the scattered light in spherical harmonics then
satisfy linear integral equations over depth, one set for each order in azimuth, which are solved as they are: no order
of scattering is left out. What the peak does to light scattered once is added by the march (Nakajima and Tanaka 1988).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import factorial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.table_cache import TableCache

__all__ = ["COMPONENTS", "DEGREE", "MOST_DEPTH", "SlabTable", "packed_tables", "peak_share", "slab_table"]

Floats = NDArray[np.float64]
DEGREE = 3
COMPONENTS = (DEGREE + 1) * (DEGREE + 2) // 2
"""Moments (l, m) with m <= l, in the order of l (l + 1) / 2 + m."""
MOST_DEPTH = 200.0
"""Optical depth, peak left out, beyond which a slab is as good as endless."""
LEAST_DEPTH = 1.0e-2
LEAST_COSINE = 0.05
"""Of the sun: a plane slab under a level sun has none of its light, a shell on a planet does."""
DEPTHS, SUNS, SHARES = 14, 12, 16
_VERSION = "1"
"""Of the files; to be raised whenever `solve` gives other values."""
_NODES = 48
_ANGLES = 16


def peak_share(asymmetry: float) -> float:
    """Share of the light that counts as not scattered at all; droplets that scatter backwards have no such peak."""
    return max(asymmetry, 0.0) ** (DEGREE + 1)


@dataclass(frozen=True)
class SlabTable:
    """Moments of the source function for one kind of droplet.

    values: (depths, suns, shares, COMPONENTS): emission over extinction (peak left in), for a sun of irradiance 1 on
    top, as coefficients of P_l^m(mu) sin_s^m cos(m phi). mu: cosine of the light's way to straight down, phi: its
    azimuth from the sun's light, sin_s: sine of the sun's zenith angle. Nodes are even in the coordinates that
    depth_row, sun_row and share_row give, 0..1.
    """

    albedo: float
    asymmetry: float
    values: Floats


def depth_row(depth: ArrayLike) -> Floats:
    """Coordinate of a slab's optical depth, peak left out."""
    return np.clip(np.log(np.maximum(depth, 1e-30) / LEAST_DEPTH) / np.log(MOST_DEPTH / LEAST_DEPTH), 0.0, 1.0)


def sun_row(cosine: ArrayLike) -> Floats:
    """Coordinate of the sun's cosine to the zenith."""
    return np.sqrt((np.clip(cosine, LEAST_COSINE, 1.0) - LEAST_COSINE) / (1.0 - LEAST_COSINE))


def share_row(share: ArrayLike) -> Floats:
    """Coordinate of the share of a slab's depth that lies above a point: dense at both ends."""
    s = np.sqrt(np.clip(share, 0.0, 1.0))
    return s / (s + np.sqrt(np.clip(1.0 - np.asarray(share), 0.0, 1.0)))


@lru_cache(maxsize=16)
def slab_table(
    albedo: float, asymmetry: float, depths: int = DEPTHS, suns: int = SUNS, shares: int = SHARES
) -> SlabTable:
    """Solves for all nodes, some tenths of a second of the processor; kept on disk. ValueError for droplets that cannot
    be: an albedo outside 0..1, an asymmetry of 1 or beyond."""
    if not (0.0 <= albedo <= 1.0 and abs(asymmetry) < 1.0):
        raise ValueError(
            "slab_table: expected an albedo from 0 to 1 and an asymmetry within -1 and 1, "
            f"found {albedo} and {asymmetry}"
        )
    cache, shape = TableCache("clouds"), (depths, suns, shares, COMPONENTS)
    about = (LEAST_DEPTH, MOST_DEPTH, LEAST_COSINE, DEGREE, _NODES, _ANGLES)
    key = cache.key("slab", _VERSION, repr((albedo, asymmetry)), repr(shape), repr(about))
    held = cache.load(key, {"slab": shape})
    if held is None:
        thick = LEAST_DEPTH * (MOST_DEPTH / LEAST_DEPTH) ** (np.arange(depths) / (depths - 1))
        sun = LEAST_COSINE + (1.0 - LEAST_COSINE) * (np.arange(suns) / (suns - 1)) ** 2
        row = np.arange(shares) / (shares - 1)
        share = row * row / (row * row + (1.0 - row) ** 2)
        # In the precision of the file and of the texture, so that the first process has what the others have.
        held = {"slab": np.stack([solve(albedo, asymmetry, d, sun, share) for d in thick]).astype(np.float32)}
        cache.save(key, held)
    values = held["slab"].astype(np.float64)
    values.setflags(write=False)
    return SlabTable(albedo, asymmetry, values)


def solve(albedo: float, g: float, depth: float, sun: Floats, share: Floats) -> Floats:
    """(suns, shares, COMPONENTS) of one slab; depth: peak left out."""
    peak = peak_share(g)
    kept = 1.0 - albedo * peak
    bare = albedo * (1.0 - peak) / kept
    moments = np.array([(g**n - peak) / (1.0 - peak) for n in range(DEGREE + 1)])
    nodes = _depth_nodes(depth)
    count = len(nodes)
    x, w = np.polynomial.legendre.leggauss(_ANGLES)
    mu, weight = 0.5 * x + 0.5, 0.5 * w
    down = _transport(nodes, mu).reshape(len(mu), -1)
    up = _transport(depth - nodes[::-1], mu)[:, ::-1, ::-1].reshape(len(mu), -1)
    beam = np.exp(-nodes[None, :] / sun[:, None])
    out = np.zeros((len(sun), len(share), COMPONENTS))
    for m in range(DEGREE + 1):
        degrees = range(m, DEGREE + 1)
        # Of the sun without its sine to the power of m, which would be 0 / 0 at the zenith.
        here = np.sqrt(1.0 - mu * mu) ** m * _polynomials(m, mu)
        there = _polynomials(m, sun)
        scale = {n: bare * moments[n] * (2 * n + 1) * factorial(n - m) / factorial(n + m) for n in degrees}
        size = len(here)
        pairs = (here[:, None] * here[None] * weight).reshape(size * size, -1)
        # Upwards, P_l^m(-mu) = (-1)^(l + m) P_l^m(mu).
        signs = np.array([[(-1.0) ** (n + k) for k in degrees] for n in degrees]).reshape(-1, 1)
        kernel = (pairs @ down + signs * (pairs @ up)).reshape(size, size, count, count)
        factors = np.array([0.5 * scale[k] for k in degrees])
        system = (kernel * factors[None, :, None, None]).transpose(0, 2, 1, 3)
        matrix = system.reshape(size * count, -1)
        # Moments of the beam itself: (degrees, suns) times its light at the nodes.
        direct = (there[:, :, None] * beam[None]).transpose(0, 2, 1).reshape(size * count, -1)
        light = np.linalg.solve(np.eye(len(matrix)) - matrix, matrix @ direct).reshape(size, count, -1)
        for i, n in enumerate(degrees):
            factor = kept * scale[n] * (1.0 if m == 0 else 2.0) / (4.0 * np.pi)
            for s in range(len(sun)):
                out[s, :, n * (n + 1) // 2 + m] = factor * np.interp(share * depth, nodes, light[i, :, s])
    return out


def _depth_nodes(depth: float) -> Floats:
    """Depths, dense at both ends, from a thousandth of what dims light to the whole."""
    half = np.geomspace(1.0, 1.0 + 0.5 * depth / 2e-3, _NODES // 2) - 1.0
    half *= 0.5 * depth / half[-1]
    return np.concatenate([half, depth - half[-2::-1]])


def _transport(nodes: Floats, mu: Floats) -> Floats:
    """(angles, nodes, nodes): light that goes down at each node from sources at the nodes, linear between them."""
    count = len(nodes)
    found = np.zeros((len(mu), count, count))
    for i in range(1, count):
        d = (nodes[i] - nodes[i - 1]) / mu
        passes = np.exp(-d)
        # Of a source that runs linearly: weights of its far and near end.
        thin = d < 1e-3
        mean = np.where(thin, 1.0 - 0.5 * d, -np.expm1(-d) / d)
        far = np.where(thin, 0.5 * d - d * d / 3.0, mean - passes)
        near = -np.expm1(-d) - far
        found[:, i] = passes[:, None] * found[:, i - 1]
        found[:, i, i - 1] += far
        found[:, i, i] += near
    return found


def _polynomials(m: int, mu: Floats) -> Floats:
    """(DEGREE + 1 - m, N): P_l^m(mu) / (1 - mu^2)^(m / 2) for l from m on, without the sign of Condon and Shortley."""
    p, before = np.full_like(mu, float(np.prod(np.arange(1, 2 * m, 2)))), np.zeros_like(mu)
    rows = [p]
    for n in range(m, DEGREE):
        p, before = ((2 * n + 1) * mu * p - (n + m) * before) / (n + 1 - m), p
        rows.append(p)
    return np.array(rows)


def packed_tables(tables: Sequence[SlabTable], layers: int) -> NDArray[np.float32]:
    """(layers * 3 * DEPTHS, SUNS, SHARES, 4) f32: the texture that clouds/scattered.glsl reads."""
    packed = np.zeros((layers, 3, DEPTHS, SUNS, SHARES, 4), np.float32)
    for layer, table in enumerate(tables):
        for moment in range(COMPONENTS):
            packed[layer, moment // 4, ..., moment % 4] = table.values[..., moment]
    return packed.reshape(layers * 3 * DEPTHS, SUNS, SHARES, 4)
