"""One layer's waves, in float64: they run in a direction that each place is given.

A wave's phase is that of the eight corners of a lattice cell, each with a hashed amplitude and phase of its own, summed
as complex numbers and divided by their length (phasor noise, Tricard et al. 2019, "Procedural Phasor Noise").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.noise import GRADIENT_SCALE, Corners, quintic, quintic_slope

__all__ = ["ROUND", "TURN", "Wave", "wave_values"]

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

TURN = 2.0 * np.pi
"""Radians of phase by the lattice coordinate: a wave a cell."""
ROUND = 0.02
"""Squared length below which the sum of a cell's waves says little about their phase."""


def wave_values(cells: Corners, along: Floats) -> tuple[Floats, Floats]:
    """The wave (N,), and the one a quarter further on, of one layer's cells at N places, in directions (3, N): as
    `Wave.value`, without what derivatives need and in half of its time."""
    f = cells.fraction[:, 0]
    far = quintic(f)
    angles = np.empty((4, f.shape[1]))  # by which corners on the far sides are behind, and the place is ahead
    np.multiply(along, TURN, out=angles[:3])
    np.einsum("an,an->n", angles[:3], f, out=angles[3])
    cosine, sine = np.cos(angles), np.sin(angles)
    near = 1.0 - far
    turned, across = far * cosine[:3], far * sine[:3]
    waves = cells.gradients[:2, :, 0]  # real and imaginary parts of corners, those along x next to each other
    for axis in range(3):
        first, other = waves[:, 0::2], waves[:, 1::2]
        both, part = first * near[axis], other * turned[axis]
        both += part
        np.multiply(other, across[axis], out=part)
        both[0] += part[1]
        both[1] -= part[0]
        waves = both
    real, imaginary = waves[:, 0] * GRADIENT_SCALE
    inverse = 1.0 / np.sqrt(real * real + imaginary * imaginary + ROUND)
    cosine, sine = cosine[3] * inverse, sine[3] * inverse
    return real * cosine - imaginary * sine, real * sine + imaginary * cosine


class Wave:
    """The waves of one layer's cells at N places, by the direction in which they run."""

    def __init__(self, cells: Corners, along: Floats) -> None:
        f = self._fraction = cells.fraction[:, 0]
        u = self._u = quintic(f)
        corners = cells.gradients[:, :, 0] * GRADIENT_SCALE
        sums: Complex = (corners[0] + 1j * corners[1]).reshape(2, 2, 2, -1)  # z, y, x
        step = _circle(-TURN * along)
        sums[:, :, 1] *= step[0]
        sums[:, 1] *= step[1]
        sums[1] *= step[2]
        self._dx = sums[:, :, 1] - sums[:, :, 0]
        x = sums[:, :, 0] + u[0] * self._dx
        self._dy = x[:, 1] - x[:, 0]
        y = x[:, 0] + u[1] * self._dy
        self._dz = y[1] - y[0]
        self._total = y[0] + u[2] * self._dz
        self._along = along
        self._there = _circle(TURN * (along * f).sum(axis=0))
        self._length = np.sqrt(self._total.real**2 + self._total.imag**2 + ROUND)
        self.value = self._total * self._there / self._length
        """(N,) complex: the wave, and the one a quarter further on"""

    def derivative(self, turning: Floats, bent: Floats | None) -> Complex:
        """(3, N) of the value by the place, in cells. turning (3, 3, N): of `along` [a] by it [b]. bent (3, 3, N): of
        the lattice coordinate [a], if a warp moves that."""
        u, f, total = self._u, self._fraction, self._total
        by_x = self._dx[:, 0] + u[1] * (self._dx[:, 1] - self._dx[:, 0])
        by = np.stack(
            [by_x[0] + u[2] * (by_x[1] - by_x[0]), self._dy[0] + u[2] * (self._dy[1] - self._dy[0]), self._dz]
        )
        further = u * (total + (1.0 - u) * by)  # of the corners on the far side along each axis
        straight, across = by * quintic_slope(f), self._along
        if bent is not None:
            straight, across = (np.einsum("abn,an->bn", bent, v) for v in (straight, across))
        change = straight - (1j * TURN) * np.einsum("jkn,jn->kn", turning, further)
        whole = change + (1j * TURN) * total * (across + np.einsum("jkn,jn->kn", turning, f))
        longer = (np.conj(total) * change).real
        return whole * (self._there / self._length) - self.value * (longer / self._length**2)


def _circle(angle: Floats) -> Complex:
    found = np.empty(angle.shape, dtype=np.complex128)
    np.cos(angle, out=found.real)
    np.sin(angle, out=found.imag)
    return found
