"""The sum of all orders of scattering from the first few of them.

Light of order j + 1 comes from light of order j by one linear operator K: the whole is the solution of I = I_1 + K I.
In thick air its series converges slowly, and light sinks in as it goes on: near the ground each order may be brighter
than the one before, and no ratio of two orders says what is still to come. So the sum is taken for
X = a_1 I_1 + ... + a_(J-1) I_(J-1), with those a that leave the least of the equation's residual
I_1 + sum a_j (I_(j+1) - I_j): minimal residuals in the Krylov space of K (reduced rank extrapolation; Eddy 1979, Mesina
1977; equivalent to GMRES, Saad and Schultz 1986). K once more costs nothing, as K I_j is known, and smooths the rest:

    I = I_1 + sum over j < J of a_j I_(j+1)

Each colour has its own a. `tests/systems/test_air_closing.py` holds it against equations that can be solved, and
against the sum of 40 orders; `planetfall bench atmosphere.thick` against paths of light.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["closing_weights", "moved"]

Floats = NDArray[np.float64]

_LEAST = 1e-30
_RANK = 1e-5
"""Singular values below this share of the largest are rounding: orders are float32."""
_LIT = 1e-3
"""Places with less than this share of the brightest have no say in whether the sum moves any more."""


def closing_weights(means: Floats) -> Floats:
    """Weights (J, ..., 3) of orders whose weighted sum stands for all.

    means: (J, ..., 3), the mean light of each order by place and colour, 0 or more.

    Places where that would be less than the orders that are known (far in the night, where the first orders say little)
    have weights of 1.
    """
    count = len(means)
    flat = np.asarray(means, np.float64).reshape(count, -1, 3)
    weights = np.ones_like(flat)
    known = flat.sum(axis=0)
    for color in range(3):
        light, sum_of = flat[..., color], known[:, color]
        if not np.isfinite(sum_of).all():
            continue
        # By the square root: neither the bright places alone nor the dark ones.
        scale = 1.0 / np.sqrt(np.maximum(sum_of, _LEAST))
        steps, first = (np.diff(light, axis=0) * scale).T, -light[0] * scale
        sizes = np.maximum(np.linalg.norm(steps, axis=0), _LEAST)
        found = np.linalg.lstsq(steps / sizes, first, rcond=_RANK)[0] / sizes
        total = light[0] + found @ light[1:]
        ahead = total > sum_of
        weights[1:, :, color] = np.where(ahead, found[:, None], 1.0)
    return weights.reshape(np.shape(means))


def moved(means: Floats) -> float:
    """How much the last order has moved the sum of all: 95th percentile over lit places of |now / before - 1|, of the
    worst colour. inf for a single order, of which nothing can be said."""
    if len(means) < 2:
        return float("inf")
    now = (closing_weights(means) * means).sum(axis=0).reshape(-1, 3)
    before = (closing_weights(means[:-1]) * means[:-1]).sum(axis=0).reshape(-1, 3)
    lit = (now > _LIT * now.max(axis=0)) & (before > 0.0)
    apart = np.abs(now / np.maximum(before, _LEAST) - 1.0)
    return max((float(np.quantile(apart[lit[:, k], k], 0.95)) for k in range(3) if lit[:, k].any()), default=0.0)
