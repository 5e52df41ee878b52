"""Quadrature of many integrals at once: Gauss-Legendre rules, and adaptive Gauss-Kronrod by a common work list."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .air_medium import Floats

# Gauss-Kronrod 7-15 (QUADPACK, Piessens et al. 1983): nodes in [0, 1), Kronrod's weights, Gauss's for every other node.
_NODES = [
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851, 0.864864423359769072789712788640926,
    0.741531185599394439863864773280788, 0.586087235467691130294144691693710, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.000000000000000000000000000000000,
]  # fmt: skip
_KRONROD = [
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
    0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714,
]  # fmt: skip
_GAUSS = [
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780, 0.381830050505118944950369775488975,
    0.417959183673469387755102040816327,
]  # fmt: skip
NODES_15 = np.concatenate([-np.array(_NODES), np.array(_NODES[-2::-1])])
KRONROD_15 = np.concatenate([_KRONROD, _KRONROD[-2::-1]])
GAUSS_7 = np.zeros(15)
GAUSS_7[1::2] = np.concatenate([_GAUSS, _GAUSS[-2::-1]])

Integrand = Callable[[NDArray[np.intp], Floats], Floats]


@lru_cache(maxsize=32)
def gauss_legendre(count: int) -> tuple[Floats, Floats]:
    """Nodes and weights (count,) on [-1, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


@dataclass(frozen=True)
class Integrals:
    """Values (N, K), estimates of their absolute errors (N, K), and how often the integrand was evaluated."""

    value: Floats
    error: Floats
    evaluations: int


def integrate(
    integrand: Integrand, breaks: Floats, width: int, rtol: float, floor: float = 1e-30, rounds: int = 40
) -> Integrals:
    """N integrals of vectors of `width` values, each over the range of its breakpoints (N, B), to a relative error.

    `integrand(owner, s)` gets the numbers (M,) of the integrals and points (M, 15), and returns (M, 15, width). Breaks
    need not be sorted; at each of them the integrand may have a kink. Intervals are halved until their Gauss-Kronrod
    differences, which are far above the true errors, sum up to less than `rtol` of each value (or to `floor`).
    RuntimeError if that takes more than `rounds` halvings.
    """
    edges = np.sort(breaks, axis=1)
    count = len(edges)
    value, error = np.zeros((count, width)), np.zeros((count, width))
    left, right = edges[:, :-1], edges[:, 1:]
    owner, piece = np.nonzero(right > left)
    a, b = left[owner, piece], right[owner, piece]
    evaluations = 0
    for _ in range(rounds):
        if owner.size == 0:
            return Integrals(value, error, evaluations)
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        f = integrand(owner, middle[:, None] + half[:, None] * NODES_15)
        evaluations += f.shape[0] * f.shape[1]
        kronrod = np.einsum("mnk,n->mk", f, KRONROD_15) * half[:, None]
        difference = np.abs(kronrod - np.einsum("mnk,n->mk", f, GAUSS_7) * half[:, None])
        estimate = value.copy()
        np.add.at(estimate, owner, kronrod)
        share = rtol / np.maximum(np.bincount(owner, minlength=count), 8)[owner]
        allowed = np.maximum(np.abs(estimate[owner]) * share[:, None], floor)
        # An interval of a few ulps cannot be halved any more: what is left there is rounding.
        ulps = half <= 1e-13 * np.maximum(np.abs(middle), 1.0)
        done = (difference <= allowed).all(axis=1) | ulps
        np.add.at(value, owner[done], kronrod[done])
        np.add.at(error, owner[done], difference[done])
        a, b, middle, owner = a[~done], b[~done], middle[~done], owner[~done]
        a, b, owner = np.concatenate([a, middle]), np.concatenate([middle, b]), np.concatenate([owner, owner])
    raise RuntimeError(f"quadrature: {len(np.unique(owner))} of {count} integrals not settled after {rounds} halvings")
