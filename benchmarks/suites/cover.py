"""Suite cover: trees: what a frame with them costs, how a forest's far colour compares with them, and the sampler."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack

import numpy as np

from ... import Clouds, Cover, CoverSampler, Scene, load_scene, view
from ...engine.frame.gbuffer import Surface
from ..measure.frames import RUN_UP, turning
from ..session import Bench, Session
from ..target import Target, at_most
from ..timing import time_variants

__all__ = ["BENCHES"]

UNDER_TREES = ("forest", "meadow")
VIEWS, QUICK_VIEWS = (
    (*UNDER_TREES, "canopy", "treeline", "near", "valley", "fair", "high"),
    ("forest", "canopy", "near"),
)
MOST: Mapping[str, tuple[float, float]] = {"low": (1.6, 1.25), "medium": (2.0, 1.4)}
"""By quality: of the views under trees, and of others, a frame with trees over the same without."""


def _woods(trees: bool) -> Scene:
    scene = load_scene("woods")
    if not trees:
        scene.planet.remove(Cover)
    return scene


def _cost(session: Session) -> None:
    """A turning camera's frames, with trees and without by turns."""
    size = (640, 360)
    for quality, (under, other) in MOST.items():
        with ExitStack() as stack:
            bare, wooded = (stack.enter_context(session.renderer(_woods(on), size, quality)) for on in (False, True))
            for name in QUICK_VIEWS if session.extent == "quick" else VIEWS:
                frames = {"bare": turning(bare, view(name)), "wooded": turning(wooded, view(name))}
                found = time_variants(frames, session.runs(30, 8), RUN_UP)
                session.row(
                    quality, name, size, found["wooded"], error=found["wooded"].ms / found["bare"].ms,
                    error_unit="times", target=at_most(under if name in UNDER_TREES else other, "times"),
                    bare_ms=found["bare"].ms, trees=wooded.stats.get("trees", 0),
                )  # fmt: skip


def _far(session: Session) -> None:
    """Mean radiance of forest within 500 m as the ground's far colour over that of trees as solids."""
    scene = _woods(True)
    if scene.planet.has(Clouds):
        scene.planet.remove(Clouds)
    for name in ("canopy", "treeline", "near", "valley"):
        out = {}
        for reach_m in (700.0, 20.0):
            with session.renderer(scene, (320, 180), "medium", {"cover.reach_m": reach_m}) as renderer:
                wanted = ("radiance", "surface", "distance")
                out[reach_m] = renderer.render(view(name, scene.planet), outputs=wanted)
        solids, far = out[700.0], out[20.0]
        shown = np.isin(solids["surface"], (Surface.TERRAIN, Surface.COVER)) & (solids["distance"] < 500.0)
        shown &= far["surface"] == Surface.TERRAIN
        ratio = far["radiance"][shown].mean() / solids["radiance"][shown].mean()
        session.row("far colour over trees", name, (320, 180), error=float(ratio), target=Target(0.97, 1.03),
                    pixels=int(shown.sum()))  # fmt: skip


def _sampler(session: Session) -> None:
    """CoverSampler.within 300 m of a forest."""
    scene = _woods(True)
    sampler, place = CoverSampler(scene), view("canopy", scene.planet).camera.resolve(scene).position_m
    timing = time_variants({"within": lambda: sampler.within(place, 300.0)}, session.runs(10, 4), 1)["within"]
    session.row("within 300 m", "canopy", timing=timing, trees=len(sampler.within(place, 300.0)))


BENCHES: Mapping[str, Bench] = {"cost": _cost, "far": _far, "sampler": _sampler}
