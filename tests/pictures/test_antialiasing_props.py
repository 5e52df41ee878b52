"""Anti-aliasing of bodies that move by themselves: they are followed, and leave nothing behind."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, binary_erosion

import planetfall as pf
from planetfall.benchmarks.measure.antialiasing import display_values, supersampled

SIZE = (160, 90)
FRAME_S = 1.0 / 30.0
STEP_M = 0.7
"""A frame: 2.7 pixels at 20 m."""
FRAMES, COUNTED = 14, 6


@pytest.fixture(scope="module")
def crossing() -> dict[str, Any]:
    """A sphere crosses the picture: its last frames without and with anti-aliasing minus the supersampled ones, in
    steps of an 8-bit picture, and where it is seen."""
    view = pf.view("noon", "earth")
    found: dict[str, Any] = {}
    for kind in ("truth", "none", "temporal"):
        scene = pf.load_scene("earth")
        exposure = scene.environment[pf.Exposure]
        exposure.mode, exposure.ev100 = "fixed", view.ev100
        overrides = {"composite.antialiasing": "temporal" if kind == "temporal" else "none", "composite.samples": 17}
        with pf.Renderer(scene, SIZE, "medium", overrides) as renderer:
            state = renderer.camera_state(view)
            start = state.position_m + 20.0 * state.forward - 5.0 * state.right
            body = scene.add(pf.Transform(tuple(start)), pf.Shape("sphere", (5.0, 5.0, 5.0), (0.8, 0.5, 0.2)))
            renderer.settle(view)
            pictures, surfaces = [], []
            for k in range(FRAMES):
                body[pf.Transform].position_m = tuple(start + STEP_M * k * state.right)
                if kind != "truth":
                    pictures.append(renderer.render(view, dt_s=FRAME_S)["color"] / np.float32(255.0))
                elif k >= FRAMES - COUNTED - 1:
                    pictures.append(display_values(supersampled(renderer, view, 4, sun=view.sun, time_s=view.time_s)))
                    surfaces.append(renderer.render(view, outputs=("surface",))["surface"] == 3)
        found[kind] = 255.0 * np.stack(pictures[-COUNTED:])
        if kind == "truth":
            found["seen"] = np.stack(surfaces)
    for kind in ("none", "temporal"):
        found[kind] = found[kind] - found["truth"]
    return found


def rms(errors: Any) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


def test_ground_that_a_sphere_has_left_shows_nothing_of_it(crossing):
    """A history that isn't tested for being the same surface, clipped as ever, leaves a sixth of the sphere."""
    seen = crossing["seen"]
    left = seen[:-1] & np.stack([~binary_dilation(s, iterations=2) for s in seen[1:]])
    assert left.sum() > 50, "pixels that it has just left"
    truth = crossing["truth"]
    # Not from each pixel's truth: what is blurred errs against its own truth.
    sphere = np.median(truth[seen[1:]], axis=0) - np.mean(truth[left], axis=0)
    by_sphere = {kind: np.sum(crossing[kind][left] * sphere, axis=-1) for kind in ("none", "temporal")}
    # What is left of the sphere, as a share of its light; its error by chance is that of single samples.
    share, chance = by_sphere["temporal"].sum(), np.sqrt(np.sum(np.square(by_sphere["none"])))
    assert share < 3.0 * chance, (share, chance)
    # Ground that has just come out has had a single sample: its errors are no larger but by chance.
    more = np.mean(np.square(crossing["temporal"][left]) - np.square(crossing["none"][left]), axis=-1)
    assert more.mean() < 3.0 * more.std() / np.sqrt(more.size)


def test_a_moving_sphere_is_followed(crossing):
    """Its past taken from where it was. Fetched from the same pixels instead, errors are 6 steps inside and twice those
    of a single sample along the outline."""
    seen = crossing["seen"][1:]
    inside = np.stack([binary_erosion(s, iterations=2) for s in seen])
    outline = np.stack([binary_dilation(s) & ~binary_erosion(s) for s in seen])
    assert inside.sum() > 500 and outline.sum() > 500
    assert rms(crossing["temporal"][inside]) < 2.0
    assert rms(crossing["temporal"][outline]) < 1.3 * rms(crossing["none"][outline])
