"""Stress suite descent: the flight from 36 000 km to 2 m, every pair of frames compared; and pieces of other flights.

The first cases are always the same: the whole descent over Earth. In 600 frames and, ten times as fast, in 60: how far
ground moves on screen and how much the picture's brightness changes from one frame to the next for a camera that is
held. In 600 frames, without clouds and with them: how the brightness of the same ground changes beyond its trend, the
camera moving; with clouds, beyond what pictures by themselves show too. All others are drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Exposure
from ..measure import descent
from ..scenes import preset_scene
from ..session import Session
from .runner import Case, Found, Kind

Floats = NDArray[np.float64]

P999_PX, WORST_PX = 1.0, 4.0
STEP = 0.01
"""Brightness beyond the smooth trend."""
_SIZE, _SMALL = (320, 180), (160, 90)
_WHOLE: Case = {"planet": "earth", "path": "descent", "size": list(_SIZE), "quality": "high"}

FIXED: tuple[Case, ...] = (
    {"kind": "pops", **_WHOLE, "frames": 600},
    {"kind": "pops", **_WHOLE, "frames": 60},
    {"kind": "brightness", **_WHOLE, "frames": 600},
    {"kind": "brightness", **_WHOLE, "frames": 600, "clouds": True},
)
COUNT = len(FIXED)
"""Cases of a sweep that says no number."""


def _draw(rng: np.random.Generator) -> Case:
    """Some frames from anywhere in a flight over any planet."""
    first_s = float(rng.uniform(0.0, 56.0))
    return {
        "planet": str(rng.choice(["earth", "mars", "moon", "small", "hazy"])),
        "path": str(rng.choice(["descent", "descent", "low"])),
        "backend": str(rng.choice(["grid", "quadtree", "icosphere"])),
        "quality": str(rng.choice(["low", "medium", "high"])),
        "size": list(_SMALL),
        "frames": 20,
        "first_s": first_s,
        "last_s": first_s + float(rng.choice([0.3, 1.0, 2.0])),
    }


def _flight(case: Case, scene: Any) -> descent.Flight:
    return descent.descent(scene, case["frames"], case.get("first_s", 0.0), case.get("last_s"), case["path"])


def _check_pops(case: Case, session: Session) -> Found:
    """How far ground moves on screen between frames, the camera's motion apart. Clouds show no ground: without them."""
    found, scene = Found(), preset_scene(case["planet"])
    overrides = {"terrain.backend": case["backend"]} if "backend" in case else None
    with session.renderer(scene, tuple(case["size"]), case["quality"], overrides) as renderer:
        flight = _flight(case, scene)
        steps = descent.pops(renderer, flight)
    scene.release()
    found.note("p99.9 of a pair", max(s.p999_px for s in steps), "px", P999_PX)
    found.note("most of a pair", max(s.worst_px for s in steps), "px", WORST_PX)
    found.note("brightness, camera held", max(abs(s.brighter) for s in steps), "", STEP)
    found.note("pairs", len(steps))
    found.series = {
        "altitude_m": [s.altitude_m for s in steps],
        "p999_px": [s.p999_px for s in steps],
        "worst_px": [s.worst_px for s in steps],
        "brighter": [s.brighter for s in steps],
    }
    return found


def _check_brightness(case: Case, session: Session) -> Found:
    """How much brighter the same ground grows from frame to frame, beyond the smooth trend."""
    found, scene = Found(), preset_scene(case["planet"], case.get("clouds", False))
    exposure = scene.environment[Exposure]
    exposure.mode, exposure.ev100 = "fixed", 14.5
    overrides = {"terrain.backend": case["backend"]} if "backend" in case else None
    with session.renderer(scene, tuple(case["size"]), case["quality"], overrides) as renderer:
        flight = _flight(case, scene)
        steps = descent.brightness_steps(renderer, flight)
        smooth = descent.trend(steps)
        beyond = np.abs(steps - smooth)
        if case.get("clouds", False):
            found.note("step beyond the trend, clouds and all", _most(beyond), "")
            beyond = descent.beyond(renderer, flight, steps, STEP)
    scene.release()
    found.note("step beyond the trend", _most(beyond), "", STEP)
    found.note("pairs that show the same ground", float(np.isfinite(steps).sum()))
    found.series = {
        "altitude_m": flight.altitudes_m[1:].tolist(), "step": steps.tolist(), "trend": smooth.tolist(),
    }  # fmt: skip
    return found


def _most(values: Floats) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else 0.0


KINDS: Mapping[str, Kind] = {"pops": Kind(_draw, _check_pops, 2.0), "brightness": Kind(_draw, _check_brightness)}
