"""How different two pictures look: FLIP, "A Difference Evaluator for Alternating Images" (Andersson et al. 2020)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PIXELS_PER_DEGREE = 67.0
"""FLIP's own default: a 4K screen of 0.7 m width seen from 0.7 m."""


def flip(reference: NDArray[np.uint8], test: NDArray[np.uint8]) -> NDArray[np.float32]:
    """FLIP (H, W) between two u8 pictures (H, W, 3) of one size: 0 the same, 1 as different as black and white.

    ValueError for different sizes; ImportError without the package flip-evaluator (it comes with the extra `dev`).
    """
    if reference.shape != test.shape:
        raise ValueError(f"pictures of different size: {reference.shape} and {test.shape}")
    if np.array_equal(reference, test):  # FLIP takes 0.1 s, and gives 0
        return np.zeros(reference.shape[:2], np.float32)
    import flip_evaluator

    first, second = (np.ascontiguousarray(p, np.float32) / np.float32(255.0) for p in (reference, test))
    error, _, _ = flip_evaluator.evaluate(
        first, second, "LDR", applyMagma=False, computeMeanError=False, parameters={"ppd": PIXELS_PER_DEGREE}
    )
    return np.asarray(error, np.float32)[..., 0]
