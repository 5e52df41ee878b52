"""Many objects moved at once, from arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..components import Transform
from ..engine.settings import SettingError, assign_many

__all__ = ["set_places"]


def set_places(transforms: Sequence[Transform], positions_m: ArrayLike, orientations: ArrayLike | None) -> None:
    """Positions (N, 3) in metres and quaternions (N, 4) (x, y, z, w); None leaves those as they are. SettingError for
    wrong shapes, numbers that aren't finite, and quaternions of zero: nothing has moved then."""
    places, turned = _rows("positions_m", positions_m, len(transforms), 3), None
    if orientations is not None:
        turned = _rows("orientations", orientations, len(transforms), 4)
        zero = next((k for k, q in enumerate(turned) if not any(q)), None)
        if zero is not None:
            raise SettingError(f"move: orientations[{zero}] is all zero; no rotation has that quaternion")
    assign_many(transforms, "position_m", places)
    if turned is not None:
        assign_many(transforms, "orientation", turned)


def _rows(name: str, values: ArrayLike, count: int, width: int) -> list[tuple[float, ...]]:
    """Checked rows of an array as tuples of plain floats."""
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape != (count, width):
        raise SettingError(f"move: {name}: expected shape ({count}, {width}), found {rows.shape}")
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if bad.size:
        raise SettingError(f"move: {name}[{bad[0]}]: expected finite numbers, found {rows[bad[0]].tolist()}")
    return list(map(tuple, rows.tolist()))
