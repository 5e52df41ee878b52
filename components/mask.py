"""What a function of a game's own says of places, checked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["mask_problem", "mask_share"]

Floats = NDArray[np.float64]

_WHERE = "Cover.mask: "
_PROBES = np.array([(1.0, 0.0, 0.0), (0.0, -0.6, 0.8), (0.0, 0.0, -1.0)])


def mask_share(mask: Callable[[Floats], Floats], directions: Floats) -> Floats:
    """(N,) what a mask gives for unit directions (N, 3): the share, 0..1, of what would grow there that may.

    ValueError that says what was expected and what it gave.
    """
    name = getattr(mask, "__name__", type(mask).__name__)
    found = mask(directions.copy())  # whatever it does with them
    count = f"each of {len(directions)} directions (N, 3)"
    expected = f"{_WHERE}the function {name!r} has to give one number from 0 to 1 for {count}"
    try:
        shares = np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{expected}, found {found!r:.80}. Return an array (N,)") from None
    if shares.shape != (len(directions),):
        advice = "Return an array (N,), such as np.ones(len(directions))"
        raise ValueError(f"{expected}, found shape {shares.shape}. {advice}")
    bad = np.flatnonzero(~((shares >= 0.0) & (shares <= 1.0)))
    if bad.size:
        k = int(bad[0])
        where = f"for directions[{k}] = {directions[k].tolist()}"
        raise ValueError(f"{expected}, found {shares[k]:g} {where}. Clip it with np.clip(share, 0.0, 1.0)")
    return shares


def mask_problem(mask: Callable[[Floats], Floats]) -> str:
    """What is wrong with what it gives for some directions, or ""."""
    try:
        mask_share(mask, _PROBES)
    except ValueError as error:
        return str(error).removeprefix(_WHERE)
    return ""
