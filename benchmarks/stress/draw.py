"""Random but telling values: logarithmic ranges, exact boundaries, places where axes degenerate."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

RADII_M = (1e3, 7e7)
ALTITUDES_M = (1e-2, 1e9)


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """All orders of magnitude alike; now and then exactly an end."""
    pick = rng.random()
    if pick < 0.04:
        return low
    if pick > 0.96:
        return high
    return float(10.0 ** rng.uniform(np.log10(low), np.log10(high)))


def unit(rng: np.random.Generator) -> list[float]:
    """A direction; one in four is an axis, an edge or a corner of the cube, or within a hair of one."""
    if rng.random() < 0.25:
        v = rng.integers(-1, 2, 3).astype(float)
        if not v.any():
            v[2] = 1.0
        if rng.random() < 0.5:
            v += rng.normal(size=3) * 10.0 ** rng.uniform(-16.0, -3.0)
    else:
        v = rng.normal(size=3)
    return [float(x) for x in v / np.linalg.norm(v)]


ALL_FOVS_DEG = (0.01, 1.0, 30.0, 60.0, 100.0, 150.0)


def camera(
    rng: np.random.Generator, radius_m: float, altitude_m: float, fovs_deg: tuple[float, ...] = ALL_FOVS_DEG
) -> dict[str, Any]:
    """Position, forward, up and field of view, or an off-axis frustum; straight down and degenerate ups included."""
    zenith = np.array(unit(rng))
    position = zenith * (radius_m + altitude_m)
    way = rng.random()
    forward: NDArray[np.float64]
    if way < 0.15:
        forward = -zenith
    elif way < 0.2:
        forward = zenith
    elif way < 0.5:  # along the horizon
        side = np.cross(zenith, np.array(unit(rng)))
        side = side / np.linalg.norm(side) if np.linalg.norm(side) > 1e-6 else np.cross(zenith, _other(zenith))
        dip = np.arctan2(np.sqrt(max(altitude_m, 0.0)) * np.sqrt(2 * radius_m + altitude_m), radius_m)
        forward = side * np.cos(dip) - zenith * np.sin(dip)
    else:
        forward = np.array(unit(rng))
        if rng.random() < 0.6:  # at the planet
            forward = forward * 0.4 - zenith
    forward = forward / np.linalg.norm(forward)
    up = forward if rng.random() < 0.1 else zenith if rng.random() < 0.5 else np.array(unit(rng))
    case: dict[str, Any] = {
        "position_m": [float(x) for x in position],
        "forward": [float(x) for x in forward],
        "up": [float(x) for x in up],
    }
    if rng.random() < 0.2:
        left, bottom = rng.uniform(-60.0, 40.0, 2)
        case["frustum_deg"] = [
            float(x) for x in (left, left + rng.uniform(5.0, 40.0), bottom, bottom + rng.uniform(5.0, 40.0))
        ]
    else:
        case["fov_y_deg"] = float(rng.choice(fovs_deg))
    return case


def _other(v: NDArray[np.float64]) -> NDArray[np.float64]:
    axis = np.zeros(3)
    axis[int(np.argmin(np.abs(v)))] = 1.0
    side = np.cross(v, axis)
    return side / np.linalg.norm(side)
