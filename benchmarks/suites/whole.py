"""Suite whole: every planet preset with all it has, at every quality: time against the error to `reference`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ... import planets, view
from ...camera.views import views
from ..measure.frames import time_passes
from ..measure.whole import reference_of, whole_frame
from ..scenes import preset_scene
from ..session import Bench, Session

__all__ = ["BENCHES"]

SIZE, QUICK_SIZE = (320, 180), (96, 54)
QUALITIES, QUICK_QUALITIES = ("low", "medium", "high", "ultra"), ("low", "medium")
VIEWS, QUICK_VIEWS = ("near", "high", "orbit"), ("near",)
MORE_VIEWS = ("ground", "coast", "limb", "dusk", "sunset")
"""With --full: a minute and more goes into the reference's picture of a planet with sea, air and clouds."""


def _wanted(session: Session, planet: Any) -> tuple[tuple[int, int], tuple[str, ...], list[str]]:
    """Size, qualities, and those of the views that the planet has."""
    if session.extent == "quick":
        return QUICK_SIZE, QUICK_QUALITIES, list(QUICK_VIEWS)
    names = VIEWS + MORE_VIEWS if session.extent == "full" else VIEWS
    return SIZE, QUALITIES, [name for name in names if name in views(planet)]


def _planet(session: Session, preset: str) -> None:
    """Time with the camera turning; mean FLIP and radiance error to the settled picture of `reference`."""
    session.release()
    scene = preset_scene(preset, clouds=True)
    size, qualities, names = _wanted(session, scene.planet)
    references = {name: reference_of(scene, view(name, scene.planet), size) for name in names}
    for quality in qualities:
        with session.renderer(scene, size, quality) as renderer:
            for name in names:
                found = whole_frame(renderer, view(name, scene.planet), references[name], session.runs(9, 5))
                session.row(
                    quality, name, size, found.cost.timing, error=found.mean_flip, error_unit="FLIP",
                    worst_flip=found.worst_flip, radiance_error=found.radiance_error, cpu_ms=found.cost.cpu_ms,
                    passes=found.passes, gpu_mib=found.gpu_bytes / 2**20, triangles=found.triangles,
                )  # fmt: skip
    scene.release()


def _passes(session: Session) -> None:
    """Milliseconds of each pass of the same frames by quality, each waited for."""
    for preset in planets():
        session.release()
        scene = preset_scene(preset, clouds=True)
        size, qualities, names = _wanted(session, scene.planet)
        cost: dict[tuple[str, str], dict[str, float | None]] = {}
        for quality in qualities:
            with session.renderer(scene, size, quality) as renderer:
                for name in names:
                    for one, timing in time_passes(renderer, view(name, scene.planet), session.runs(9, 4)).items():
                        cost.setdefault((name, one), dict.fromkeys(qualities))[quality] = timing.ms
        for (name, one), by_quality in sorted(cost.items(), key=lambda item: names.index(item[0][0])):
            columns: dict[str, Any] = {f"{quality}_ms": ms for quality, ms in by_quality.items()}
            session.row(f"{preset}: {one}", name, size, **columns)
        scene.release()


def _bench_of(preset: str) -> Bench:
    return lambda session: _planet(session, preset)


BENCHES: Mapping[str, Bench] = {**{preset: _bench_of(preset) for preset in planets()}, "passes": _passes}
