"""What tests of the flight share: cheap grounds with answers that can be worked out by hand, and poses over them."""

from __future__ import annotations

import math

import numpy as np

from planetfall.engine.space import direction, heading_pitch_axes
from planetfall.systems.flight import Ground, Pose

EARTH = 6.371e6


class Ramp:
    """Level until latitude 0, then rising to the north with a constant slope."""

    def __init__(self, slope: float, radius_m: float = EARTH) -> None:
        self.steepest, self.radius_m = slope, radius_m
        self.highest_m = slope * radius_m * math.pi / 2.0

    def height(self, directions: np.ndarray) -> np.ndarray:
        return np.maximum(np.arcsin(directions[:, 2]), 0.0) * (self.steepest * self.radius_m)


class Step(Ramp):
    """Level, but for one edge of `height_m` at latitude 0."""

    def __init__(self, height_m: float) -> None:
        super().__init__(1e3)
        self.highest_m = height_m

    def height(self, directions: np.ndarray) -> np.ndarray:
        return np.where(directions[:, 2] > 0.0, self.highest_m, 0.0)


class Flat:
    """Ground of one height."""

    steepest = 0.0

    def __init__(self, height_m: float) -> None:
        self.highest_m = height_m

    def height(self, directions: np.ndarray) -> np.ndarray:
        return np.full(len(directions), self.highest_m)


def pose_at(
    latitude: float, longitude: float, altitude: float, heading: float = 0.0, pitch: float = 0.0, radius: float = EARTH
) -> Pose:
    up = direction(latitude, longitude)
    forward, above = heading_pitch_axes(up, heading, pitch)
    return Pose(up * (radius + altitude), forward, above, 60.0)


def moved_m(before: np.ndarray, after: np.ndarray) -> float:
    return float(np.linalg.norm(after - before))


def level_ground(radius_m: float = EARTH, **more: float) -> Ground:
    return Ground(radius_m, None, **more)
