"""Benches of clouds in pictures: the curve of error against time, and times in flight."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack

from ... import Renderer
from ..measure import air_speed, cloud_flown, cloud_light, cloud_memory, cloud_relief, clouds
from ..measure import cloud_pictures as measure
from ..session import Session
from ..target import at_most

__all__ = ["curve", "flown", "memory", "opacity", "relief", "speed", "sunlight"]

SIZE = (640, 360)
JUDGED = ("low", "medium", "high", "ultra")
PROMISED_MS = {"low": 35.0, "high": 250.0}
PROMISED_AT = ("ground", "10 km", "2000 km")


def curve(session: Session) -> None:
    """Weather clouds: pictures at each quality against `reference`, and the time of the passes that draw them in a
    flight at 640 x 360. First the reference against itself with halved steps, along rays and as pictures: it judges
    where it is within half of what is promised."""
    quick = session.extent == "quick"
    size = (48, 27) if session.small else (96, 54)
    timed = (320, 180) if quick else SIZE
    views = ["10 km"] if quick else [name for name in measure.CAMERAS if name != "2000 km"]
    qualities = ("low", "high", "ultra") if quick else JUDGED
    session.release()
    _converged(session, views, (8, 5) if session.small else (16, 9), 72)
    truth = measure.pictures("reference", views, size)
    found = {quality: measure.pictures(quality, views, size) for quality in qualities}
    errors = {
        (quality, name): measure.errors_of(truth[name], made[name]) for quality, made in found.items() for name in views
    }
    # Twice the time of the reference's own pictures; the rays above say the same.
    again = {} if quick else measure.pictures("reference", views, size, measure.halved())
    for name, made in again.items():
        mean, worst = measure.errors_of(truth[name], made)
        least = min(errors[quality, name][0] for quality in qualities)
        session.row(
            "weather clouds: reference against itself with halved steps", name, size, error=mean,
            error_unit="mean FLIP of reference", p99=worst, target=at_most(0.5 * least),
        )  # fmt: skip
    costs = _costs(qualities, views, session.runs(2, 1), size=timed)
    for name in views:
        for quality in qualities:
            mean, worst = errors[quality, name]
            cost = costs[quality, name]
            session.row(
                f"weather clouds: picture at {quality}", name, timed, cost.wall, error=mean, error_unit="mean FLIP",
                p99=worst, cpu_ms=cost.cpu_ms,
            )  # fmt: skip


def _converged(session: Session, views: Sequence[str], rays: tuple[int, int], rows: int) -> None:
    """Whether `reference` may judge: within half of each limit of the table of promises. The march of pictures through
    even shells against closed form and quadrature, then through weather against itself with steps half as long."""
    quick = session.extent == "quick"
    for name, shells in {key: clouds.SHELLS[key] for key in ("depth 1", "depth 50")[: 1 if quick else 2]}.items():
        found = clouds.errors_of(shells, "reference", session.runs(300, 60), as_pictures=True)
        what = f"reference: pictures, shell, {name}"
        session.row(f"{what}, scattered once", error=found.median, error_unit="rel median", target=at_most(0.5 * 1e-2))
        session.row(f"{what}, scattered once", error=found.p95, error_unit="rel p95", target=at_most(0.5 * 5e-2))
        session.row(f"{what}, transmittance", error=found.transmittance, error_unit="abs max",
            target=at_most(0.5 * 1e-4),
        )  # fmt: skip
    for name, found in measure.converged(views, rays, rows).items():
        what = "weather clouds: rays at reference, steps halved"
        for kind, errors, limits in (
            ("clouds and air", found.light, (2e-2, 0.1)), ("scattered once", found.once, (1e-2, 5e-2)),
        ):  # fmt: skip
            for unit, error, limit in zip(("rel median", "rel p95"), errors, limits, strict=True):
                session.row(f"{what}, {kind}", name, error=error, error_unit=unit, target=at_most(0.5 * limit))
        session.row(
            f"{what}, transmittance", name, error=found.transmittance, error_unit="abs p95",
            target=at_most(measure.HALF_STEP),
        )  # fmt: skip


def speed(session: Session) -> None:
    """Clouds and air without ground, in flight at 640 x 360: all passes that draw them, and the march alone."""
    qualities = tuple(PROMISED_MS) if session.small else JUDGED
    views = PROMISED_AT if session.small else tuple(measure.CAMERAS)
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


def flown(session: Session) -> None:
    """A turning camera at `medium`: a ray for each block in every frame or for every second one, time of what is done
    for rays and the difference from pictures that have settled."""
    views = ("10 km",) if session.small else ("ground", "10 km", "2000 km")
    session.release()
    costs = cloud_flown.costs(views, SIZE, session.runs(16, 3))
    for name in views:
        for step_deg in (0.3,) if session.small else (0.03, 0.3):
            errors = cloud_flown.errors(name, step_deg, (320, 180))
            for every in cloud_flown.EVERY:
                cost = costs[str(every), name]
                session.row(
                    f"medium, turning {step_deg:g} degrees a frame, a ray for {cloud_flown.pixels_a_ray(every)} pixels",
                    name, SIZE, cost.wall, error=errors[every], error_unit="rms steps of 8 bits", cpu_ms=cost.cpu_ms,
                )  # fmt: skip


def relief(session: Session) -> None:
    """Share of a deck's relief of 1.2 to 8 pixels that is shown while frames go on, and processor time of a frame."""
    session.release()
    exact = cloud_relief.truth()
    for quality in ("medium", "high"):
        cases = {
            "settled": lambda q=quality: cloud_relief.settled(q),
            "80 frames, stands": lambda q=quality: cloud_relief.while_running(q, 0.0),
            "80 frames, flies 8 m in each": lambda q=quality: cloud_relief.while_running(q, 8.0),
        }
        for name, shown in cases.items():
            found = shown()
            session.row(
                f"{quality}, {name}", "cloud_sea", cloud_relief.SIZE, error=cloud_relief.kept(found.light, exact),
                error_unit="of the truth's relief", frame_ms=found.frame_ms,
            )  # fmt: skip


def sunlight(session: Session) -> None:
    """Optical depth towards the sun from maps of the shadow, with a few steps before them, against steps alone."""
    session.release()
    size = (64, 36) if session.small else (160, 90)
    shots = cloud_light.SHOTS[::2] if session.small else cloud_light.SHOTS
    for quality in ("low",) if session.small else ("low", "medium", "high"):
        for shot, error in zip(shots, cloud_light.sun_depth_error(quality, shots, size), strict=True):
            session.row(
                f"{quality}, sun at {shot[3]:g} degrees", shot[0], size, error=error, error_unit="rms over mean"
            )


def opacity(session: Session) -> None:
    """The same clouds with pixels of many widths: how opaque they are on the mean must not depend on it."""
    session.release()
    sides = (64, 16, 4) if session.small else (320, 64, 16, 4)
    for extinction in (0.02, 0.06):
        found = cloud_light.opacity(extinction, sides, session.runs(8, 3))
        for side, mean in zip(sides, found, strict=True):
            wide_km = 1e-3 * cloud_light.REGION_M / side
            session.row(
                f"extinction {extinction:g}, pixels of {wide_km:g} km", "1000 km", (side, side),
                error=abs(mean - found[0]), error_unit="of the sky", opacity=mean,
                target=at_most(0.05) if side != sides[0] else None,
            )  # fmt: skip


def memory(session: Session) -> None:
    """What clouds hold on the GPU, and how long their volumes of noise take to be made."""
    for name, mb in cloud_memory.gpu_memory("high", SIZE).items():
        session.row(f"high: {name}", size=SIZE, mb=mb, target=at_most(128.0) if name == "all" else None, target_on="mb")
    session.release()
    for texels, most_s in ((128, 2.0), (256, 20.0)):
        cost = cloud_memory.volume_cost(texels)
        session.row(
            f"volume of {texels}^3", timing=cost.wall, cpu_ms=cost.cpu_ms, target=at_most(1e3 * most_s), target_on="ms"
        )


def _costs(
    qualities: tuple[str, ...], views: tuple[str, ...] | list[str], runs: int, parts: bool = False,
    size: tuple[int, int] = SIZE,
) -> dict[tuple[str, str], air_speed.Cost]:  # fmt: skip
    """Cost of a frame's clouds and air by quality and view; parts: of the march as well, as "<quality> march"."""
    cameras = {name: [measure.camera_at(name, 1e-4 * k) for k in range(4)] for name in views}
    with ExitStack() as stack:
        renderers: dict[str, Renderer] = {}
        for quality in qualities:
            renderers[quality] = Renderer(measure.scene_of_weather(), size, quality, {"clouds.samples": 1})
            stack.callback(renderers[quality].release)
        passes = air_speed.time_passes(renderers, cameras, runs)
    found = {key: air_speed.total(costs, measure.CLOUD_PASSES) for key, costs in passes.items()}
    if parts:
        for (quality, name), costs in passes.items():
            found[f"{quality} march", name] = air_speed.total(costs, ("clouds.classify", "clouds.march"))
    return found
