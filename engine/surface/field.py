"""What geometry may ask of a height field, whoever provides it."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class HeightField(Protocol):
    """Ground heights above the reference sphere, float64, as a function of unit directions in planet axes."""

    @property
    def highest_m(self) -> float:
        """An upper bound of every height."""
        ...

    @property
    def lowest_m(self) -> float:
        """A lower bound of every height that is drawn (it may be negative)."""
        ...

    def height(self, directions: Array) -> Array:
        """Heights in metres, (N,), at unit directions (N, 3)."""
        ...

    def height_gradient(self, directions: Array) -> tuple[Array, Array]:
        """Heights (N,) and their tangential gradients (N, 3) in metres per metre along the reference sphere."""
        ...
