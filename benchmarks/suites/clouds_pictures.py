"""Benches of clouds in pictures: the curve of error against time, and times in flight."""

from __future__ import annotations

from contextlib import ExitStack

from ... import Renderer
from ..measure import air_speed
from ..measure import cloud_pictures as measure
from ..session import Session
from ..target import at_most

__all__ = ["curve", "speed"]

SIZE = (640, 360)
JUDGED = ("low", "medium", "high", "ultra")
PROMISED_MS = {"low": 35.0, "high": 250.0}
PROMISED_AT = ("ground", "10 km", "2000 km")


def curve(session: Session) -> None:
    """Weather clouds: pictures at each quality against `reference`, and the time of the passes that draw them in a
    flight at 640 x 360. First the reference against itself with halved steps: it judges errors that are larger."""
    size = (64, 36) if session.quick else (160, 90)
    views = ["ground", "10 km", "36 000 km"] if session.quick else [n for n in measure.CAMERAS if n != "2000 km"]
    qualities = ("low", "high") if session.quick else JUDGED
    session.release()
    truth = measure.pictures("reference", views, size)
    found = {quality: measure.pictures(quality, views, size) for quality in qualities}
    errors = {
        (quality, name): measure.errors_of(truth[name], made[name]) for quality, made in found.items() for name in views
    }
    again = measure.pictures("reference", views[:1] if session.quick else views, size, measure.halved())
    own = {name: measure.errors_of(truth[name], made) for name, made in again.items()}
    for name, (mean, worst) in own.items():
        least = min(errors[quality, name][0] for quality in qualities)
        session.row(
            "weather clouds: reference against itself with halved steps", name, size, error=mean,
            error_unit="mean FLIP of reference", p99=worst, target=at_most(0.5 * least),
        )  # fmt: skip
    costs = _costs(qualities, views, session.runs(7, 2))
    for name in views:
        for quality in qualities:
            mean, worst = errors[quality, name]
            cost = costs[quality, name]
            session.row(
                f"weather clouds: picture at {quality}", name, SIZE, cost.wall, error=mean, error_unit="mean FLIP",
                p99=worst, cpu_ms=cost.cpu_ms,
            )  # fmt: skip


def speed(session: Session) -> None:
    """Clouds and air without ground, in flight at 640 x 360: all passes that draw them, and the march alone."""
    qualities = tuple(PROMISED_MS) if session.quick else JUDGED
    views = PROMISED_AT if session.quick else tuple(measure.CAMERAS)
    session.release()
    found = _costs(qualities, views, session.runs(9, 3), parts=True)
    for quality in qualities:
        for name in views:
            cost, march = found[quality, name], found[f"{quality} march", name]
            promised = quality in PROMISED_MS and name in PROMISED_AT
            session.row(
                quality, name, SIZE, cost.wall, cpu_ms=cost.cpu_ms, march_ms=march.wall.ms, march_cpu_ms=march.cpu_ms,
                target=at_most(PROMISED_MS[quality], "ms") if promised else None, target_on="ms",
            )  # fmt: skip


def _costs(
    qualities: tuple[str, ...], views: tuple[str, ...] | list[str], runs: int, parts: bool = False
) -> dict[tuple[str, str], air_speed.Cost]:
    """Cost of a frame's clouds and air by quality and view; parts: of the march as well, as "<quality> march"."""
    cameras = {name: [measure.camera_at(name, 1e-4 * k) for k in range(4)] for name in views}
    with ExitStack() as stack:
        renderers: dict[str, Renderer] = {}
        for quality in qualities:
            renderers[quality] = Renderer(measure.scene_of_weather(), SIZE, quality, {"clouds.samples": 1})
            stack.callback(renderers[quality].release)
        passes = air_speed.time_passes(renderers, cameras, runs)
    found = {key: air_speed.total(costs, measure.CLOUD_PASSES) for key, costs in passes.items()}
    if parts:
        for (quality, name), costs in passes.items():
            found[f"{quality} march", name] = air_speed.total(costs, ("clouds.classify", "clouds.march"))
    return found
