"""Suite clouds: errors of the march through homogeneous clouds against float64 references."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..measure import cloud_shafts, cloud_sheets, clouds
from ..measure.cloud_cover import cover
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import Target, at_least, at_most
from .clouds_paths import pathtraced
from .clouds_pictures import curve, flown, memory, opacity, relief, speed, sunlight

QUALITIES = ("low", "medium", "high", "ultra", "reference")
MEDIANS = {"high": 3e-2, "reference": 1e-2}
"""What is promised of single scattering in shells, by quality."""


def _accuracy(session: Session) -> None:
    """The table of promises: shells in vacuum and in air, shafts of light."""
    for method in ("paper_2018", "paper_2019"):
        for name, shells in {**clouds.SHELLS, **clouds.IN_AIR}.items():
            if len(shells.layers) == 1:  # as printed
                found = clouds.errors_of(shells, "high", session.runs(300, 60), method)
                _rows(session, f"{method}: {name}", found, None, None, False)
    qualities = ("high", "reference") if session.small else QUALITIES
    for quality in qualities:
        judged = quality == "reference"
        for name, shells in clouds.SHELLS.items():
            found = clouds.errors_of(shells, quality, session.runs(1000, 300))
            median = at_most(MEDIANS[quality]) if quality in MEDIANS else None
            _rows(session, f"{quality}: shell, {name}", found, median, at_most(5e-2) if judged else None, True)
            found = clouds.errors_of(shells, quality, session.runs(1000, 300), as_pictures=True)
            _rows(session, f"{quality}: pictures, shell, {name}", found, None, None, False)
        for name, shells in clouds.IN_AIR.items():
            found = clouds.errors_of(shells, quality, session.runs(300, 60))
            limits = (at_most(2e-2), at_most(0.1)) if judged else (None, None)
            _rows(session, f"{quality}: in air, {name}", found, *limits, judged)
        for name, shells in clouds.SHAFTS.items():
            found = clouds.errors_of(shells, quality, session.runs(300, 60))
            _rows(session, f"{quality}: shafts of light, {name}", found, at_most(5e-2), None, judged)
        # As pictures have them: maps of the shadow, a few steps along a ray.
        size = (16, 10) if not session.small else (8, 5)
        for name, made, shots in (
            ("even shell", cloud_shafts.uniform_clouds(), cloud_shafts.UNIFORM),
            ("weather", cloud_shafts.weather_clouds(), cloud_shafts.WEATHER),
            ("broken sheet towards the sun", cloud_shafts.sheet_clouds(), cloud_shafts.SHEET),
        ):
            for sun in dict.fromkeys(shot.sun_deg for shot in shots):
                own = [shot for shot in shots if shot.sun_deg == sun]
                relative = cloud_shafts.shaft_errors(made, own[::2] if session.small else own, quality, size)
                session.row(
                    f"{quality}: pictures, shafts of light, {name}, sun at {sun:g} degrees",
                    error=float(np.median(relative)), error_unit="rel median",
                    target=at_most(5e-2) if judged or name != "even shell" else None,
                    p95=float(np.percentile(relative, 95)), answers=len(relative),
                )  # fmt: skip


def _slab(session: Session) -> None:
    """Light scattered any number of times in even slabs, by the exact march and by that of pictures, and in weather
    clouds as even sheets, against Monte-Carlo."""
    for quality in ("low",) if session.small else ("low", "high", "reference"):
        for depth in clouds.SLAB_DEPTHS:
            # Of the deepest slab every photon is followed through hundreds of events.
            photons = int(session.runs(640_000, 20_000) / max(depth, 1.0))
            for as_pictures in (False, True):
                found, noise = clouds.slab_errors(depth, quality, photons, as_pictures)
                session.row(
                    f"{quality}: {'pictures, ' if as_pictures else ''}all orders, slab of depth {depth:g}",
                    error=found.worst, error_unit="rel max", target=at_most(0.3), median=found.median, noise=noise,
                    answers=found.count,
                )  # fmt: skip
            sheet = cloud_sheets.sheet_errors(depth, quality, photons)
            for name, errors in (("thrown back", sheet.back), ("let through", sheet.through)):
                session.row(
                    f"{quality}: weather as a sheet of depth {depth:g}, {name}", error=errors.max(),
                    error_unit="rel max", target=at_most(0.3), median=np.median(errors), noise=sheet.noise,
                    answers=errors.size,
                )  # fmt: skip


def _rows(
    session: Session, name: str, found: clouds.Errors, median: Target | None, p95: Target | None, through: bool
) -> None:
    session.row(
        name, error=found.median, error_unit="rel median", target=median, worst=found.worst, bad=found.bad,
        answers=found.count,
    )  # fmt: skip
    session.row(name, error=found.p95, error_unit="rel p95", target=p95)
    session.row(f"{name}: transmittance", error=found.transmittance, error_unit="abs max",
        target=at_most(1e-4) if through else None,
    )  # fmt: skip


PAPER_VIEWS = ("near", "high", "orbit")
FASTER = 6.0
"""Than the printed method at no larger error, at quality low."""


def _paper(session: Session) -> None:
    """Ours and the printed march on the same clouds, the printed texture: error against our reference, and processor
    time of frames in flight with those of the same frames without clouds taken off."""
    from ... import view
    from ..measure.cloud_paper import VARIANTS, against_printed

    size = (192, 108) if session.small else (640, 360)
    session.release()
    views = {name: view(name) for name in PAPER_VIEWS}
    found = against_printed(views, size, session.runs(33, 8), session.runs(16, 5))
    for (name, place), (error, at_once, ms, alone_ms) in found.items():
        extra = {}
        if name in ("low", "high"):
            printed = found["paper_2018", place]
            extra = {"faster": printed.ms / ms, "no_worse": error <= printed.error}
        session.row(
            name, place, size, error=error, error_unit="mean FLIP", single=at_once,
            processor_ms=ms if VARIANTS[name] is not None else alone_ms, **extra,
            target=at_least(FASTER) if name == "low" else None, target_on="faster",
        )  # fmt: skip


def _repeats(session: Session) -> None:
    """Clouds seen from 36 000 km against themselves, shifted by the widths at which their noise repeats: the printed
    texture's, which is that of our finer shape as well, and that of our wider one along its own axes."""
    from ...systems.clouds.layers import frames_at
    from ..measure import cloud_paper as measure

    session.release()
    side, shift = session.runs(768, 384), 6
    straight, tilted = frames_at(0.0, 1.0, 0.0)
    widths = {"16 km": (measure.TILE_M, straight), "110 km": (measure.TILE_M * 6.871, tilted)}
    for method, quality in (("paper_2018", "paper"), ("ours", "low"), ("ours", "high")):
        name = method if quality == "paper" else quality
        with measure.renderer_of((side, side), method, quality, tiled=False) as renderer:
            for width, (tile_m, axes) in widths.items():
                repeat, plain = measure.repeats(measure.seen_from_space(renderer, tile_m / shift, axes), shift)
                session.row(
                    name, f"space, {width}", (side, side), error=repeat, error_unit="correlation", plain=plain,
                    target=at_most(0.1) if method == "ours" else None,
                )  # fmt: skip


def _cover(session: Session) -> None:
    """Earth's preset from straight above: at once, an hour and ten days later."""
    scene = preset_scene("earth", clouds=True)
    session.release()
    for name, time_s in (("at once", 0.0), ("after an hour", 3600.0), ("after ten days", 864e3)):
        found = cover(scene, time_s, session.runs(60, 24))
        session.row(
            f"earth, {name}: under cloud that hides 0.3", error=found.thin, error_unit="of the planet",
            target=Target(0.5, 0.7), mean_opacity=found.opacity, hides_half=found.thick,
        )  # fmt: skip


BENCHES: Mapping[str, Bench] = {
    "accuracy": _accuracy, "slab": _slab, "curve": curve, "speed": speed, "flown": flown, "relief": relief,
    "paper": _paper,
    "repeats": _repeats, "cover": _cover, "sunlight": sunlight, "opacity": opacity, "memory": memory,
    "pathtraced": pathtraced,
}  # fmt: skip
