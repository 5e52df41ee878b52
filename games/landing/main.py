"""A controller that lands: it slows down as the ground comes near, and takes away what goes sideways."""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from .lander import ASIDE_M_S2, GRAVITY_M_S2, STEP_S, THRUST_M_S2, Lander


def control(state: NDArray[np.float32]) -> NDArray[np.float32]:
    """The action (3,) for an observation's state (4,)."""
    height, east, north, up = (float(v) for v in state)
    wanted = -float(np.clip(0.12 * height, 1.0, 15.0))
    push = GRAVITY_M_S2 + (wanted - up) / (2.0 * STEP_S)
    aside = np.array([east, north]) / (-2.0 * STEP_S * ASIDE_M_S2)
    return np.clip([*aside, 2.0 * push / THRUST_M_S2 - 1.0], -1.0, 1.0).astype(np.float32)


def main(episodes: int = 10) -> int:
    """Exit code 1 if one of them ends in a crash."""
    lander, landed = Lander(), 0
    for seed in range(episodes):
        seen, told = lander.reset(seed=seed)
        over = False
        while not over:
            seen, _, down, late, told = lander.step(control(seen["state"]))
            over = down or late
        landed += told["landed"]
        sys.stdout.write(f"seed {seed}: {'landed' if told['landed'] else 'crashed'} at {told['speed_m_s']:.1f} m/s\n")
    lander.close()
    return int(landed < episodes)
