"""What goes wrong in space, and the checks that say so."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .vectors import length


class SpaceError(ValueError):
    """A position, direction or angle that cannot be used. The message names it, what was expected and found."""


def finite_vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """A finite float64 vector (3,), or a SpaceError that names it."""
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SpaceError(f"{name}: expected three numbers, found {value!r}") from error
    if vector.shape != (3,):
        raise SpaceError(f"{name}: expected three numbers, found shape {vector.shape}: {value!r}")
    if not all(map(math.isfinite, vector.tolist())):
        raise SpaceError(f"{name}: expected finite numbers, found {vector.tolist()}; check what computes it for NaN")
    return vector


def unit_vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """A unit vector (3,) in the direction of `value`, or a SpaceError if that has none."""
    vector = finite_vector(name, value)
    largest = max(map(abs, vector.tolist()))
    if largest == 0.0:
        raise SpaceError(f"{name}: expected a direction, found the zero vector {vector.tolist()}")
    # Scaled first, so that neither tiny nor huge vectors under- or overflow when squared.
    vector /= largest
    return vector / length(vector)


def finite_number(name: str, value: float, low: float = -np.inf, high: float = np.inf) -> float:
    """A finite number strictly between low and high, or a SpaceError that names it."""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise SpaceError(f"{name}: expected a number, found {value!r}") from error
    if not (math.isfinite(number) and low < number < high):
        raise SpaceError(f"{name}: expected a finite number between {low:g} and {high:g}, found {value!r}")
    return number
