"""Suite frame, bench whole: every planet preset at every quality, time against the error to `reference`."""

from __future__ import annotations

from ... import planets, view, views
from ..measure.whole import reference_of, whole_frame
from ..scenes import preset_scene
from ..session import Session

__all__ = ["bench"]

SIZE, QUICK_SIZE = (320, 180), (96, 54)
QUALITIES = ("low", "medium", "high", "ultra")
VIEWS = ("near", "high", "orbit")
QUICK_PLANETS, QUICK_QUALITIES, QUICK_VIEWS = ("moon",), ("low", "medium"), ("near",)
"""A minute and more goes into the reference's picture of a planet with sea, air and clouds."""


def bench(session: Session) -> None:
    """Time with the camera turning; mean FLIP and radiance error to the settled picture of `reference`."""
    size = QUICK_SIZE if session.small else SIZE
    for planet in QUICK_PLANETS if session.small else planets():
        session.release()
        scene = preset_scene(planet, clouds=True)
        wanted = QUICK_VIEWS if session.small else VIEWS
        names = [name for name in wanted if name in views(scene.planet)]
        references = {name: reference_of(scene, view(name, scene.planet), size) for name in names}
        for quality in QUICK_QUALITIES if session.small else QUALITIES:
            with session.renderer(scene, size, quality) as renderer:
                for name in names:
                    found = whole_frame(renderer, view(name, scene.planet), references[name], session.runs(7, 3))
                    session.row(
                        quality, f"{planet}: {name}", size, found.cost.timing, error=found.mean_flip,
                        error_unit="FLIP", cpu_ms=found.cost.cpu_ms, radiance_error=found.radiance_error,
                        worst_flip=found.worst_flip, passes=found.passes, graph_mib=found.graph_bytes / 2**20,
                        triangles=found.triangles,
                    )  # fmt: skip
        scene.release()
