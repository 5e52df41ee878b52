"""Suite atmosphere: errors of the air against the float64 reference, its run time, and what is skipped."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from ... import Atmosphere, AtmosphereProbe, Camera, Planet, Renderer, Scene, Sun, view
from ..measure import air, air_speed, air_thick
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_most
from ..timing import Timing

QUALITIES = ("low", "medium", "high", "ultra", "paper")
PROMISED = "high"
BENCH, FULL_HD = (640, 360), (1920, 1080)
CAMERAS = {"100 m": (100.0, 0.0), "10 km": (1e4, -5.0), "2000 km": (2e6, -62.0)}
"""Altitude and pitch, as in the views near, high and orbit."""
TABLE_VIEWS = ("near", "high", "orbit")
PROMISED_MS = 12.0
CURVE = {
    "sky": ("single", ("sky day", "sky low"), "rel p95"),
    "twilight": ("single", ("sky set", "sky twilight"), "wrel p95"),
    "from space": ("single", ("space sun<=90",), "rel p95"),
    "aerial": ("aerial", ("sun<=85",), "rel p95"),
    "all orders": ("total", ("in atmosphere sun<=75", "in atmosphere sun 80-88"), "rel p95"),
    "sky irradiance": ("irradiance", ("sun<=75", "sun 85-88"), "rel p95"),
}


def _truths(session: Session, planet: str) -> dict[air.Quantity, air.Truth]:
    """The reference's answers: a minute or two for both planets."""
    found: dict[air.Quantity, air.Truth] = {}
    for quantity in air.KINDS:
        if quantity in ("total", "aerial total", "irradiance"):
            most = session.runs(15, 10) if quantity == "irradiance" else session.runs(60, 20)
            found[quantity] = air.truth_of(planet, quantity, most, session.runs(16_384, 2048))
        else:
            found[quantity] = air.truth_of(planet, quantity, session.runs(2000, 300))
    return found


def _accuracy(session: Session) -> None:
    """The table of promises: every class of question, on Earth and on the small planet."""
    for planet, model in air.PLANETS.items():
        truths = _truths(session, planet)
        for quality in (PROMISED,) if session.small else QUALITIES:
            with AtmosphereProbe(air.scene_of(model), quality=quality) as probe:
                found = {quantity: air.answers(probe, truth) for quantity, truth in truths.items()}
            for promise in air.PROMISES:
                errors = air.errors(truths[promise.quantity], found[promise.quantity], promise.groups)
                session.row(
                    f"{planet}, {quality}: {promise.name}",
                    error=errors.values[promise.statistic],
                    error_unit=promise.statistic,
                    target=at_most(promise.limit) if quality == PROMISED else None,
                    anchor=promise.anchor if planet == "earth" and promise.anchor > 0.0 else None,
                    worst=errors.values["wrel max" if promise.statistic.startswith("w") else "rel max"],
                    bad=errors.values["bad"],
                    noise=errors.noise_p95,
                    answers=errors.count,
                )
            session.row(
                f"{planet}, {quality}: night side from space glows",
                error=air.glow(truths["single"], found["single"]),
                error_unit="of the day",
                target=at_most(1e-3) if quality == PROMISED else None,
                anchor=None,
            )


def _speed(session: Session) -> None:
    """Sky and air without ground, sea and stars: a still camera, and one that climbs, whose tables are refilled."""
    qualities = (PROMISED,) if session.small else QUALITIES
    for size in (BENCH,) if session.small else (BENCH, FULL_HD):
        with _renderers({quality: (_bare(), quality, {}) for quality in qualities}, size) as renderers:
            views = {(name, way): _cameras(name, way) for name in CAMERAS for way in ("still", "climbing")}
            labels = {f"{name}, {way}": cameras for (name, way), cameras in views.items()}
            for (quality, label), costs in air_speed.time_passes(renderers, labels, session.runs(9, 4)).items():
                cost = air_speed.total(costs, air_speed.AIR_PASSES)
                promised = quality == PROMISED and size == BENCH
                session.row(
                    quality, label, size, cost.wall, target=at_most(PROMISED_MS, "ms") if promised else None,
                    target_on="ms", cpu_ms=cost.cpu_ms, tables_ms=_ms(costs, "atmosphere.view"),
                    sky_ms=_ms(costs, "sky.shade"), frame_ms=_ms(costs, ""),
                )  # fmt: skip


def _shading(session: Session) -> None:
    """What the air adds to a frame with ground and sea, against the same planet without it."""
    qualities = (PROMISED,) if session.small else ("paper", "low", PROMISED)
    for size in (BENCH,) if session.small else (BENCH, FULL_HD):
        airless = preset_scene("earth")
        airless.planet.remove(Atmosphere)
        scenes = {quality: (preset_scene("earth"), quality, {}) for quality in qualities}
        scenes["none"] = (airless, PROMISED, {})
        with _renderers(scenes, size) as renderers:
            views = {name: [view(name)] for name in TABLE_VIEWS}
            found = air_speed.time_passes(renderers, views, session.runs(7, 3))
        for (quality, name), costs in found.items():
            without = found["none", name]
            parts: dict[str, Any] = {key: _ms(costs, f"{key}.shade") for key in ("sky", "terrain", "ocean")}
            added = {f"{key}_added_ms": value - _ms(without, f"{key}.shade") for key, value in parts.items()}
            times = {f"{key}_ms": value for key, value in parts.items()} | ({} if quality == "none" else added)
            session.row(
                "no air" if quality == "none" else quality, name, size, costs[""].wall, cpu_ms=costs[""].cpu_ms, **times
            )


def _tables(session: Session) -> None:
    """Precomputation by table, the small tables of a first look, and from the first picture to the last table."""
    for quality in (PROMISED,) if session.small else QUALITIES:
        for stage, cost in air_speed.time_tables(session.gpu, _bare(), quality).items():
            whole = stage == "total" and quality == PROMISED
            session.row(f"{quality}: {stage}", timing=cost.wall, cpu_ms=cost.cpu_ms,
                        target=at_most(60e3, "ms") if whole else None, target_on="ms")  # fmt: skip
    quick = air_speed.time_quick_tables(session.gpu, _bare(), PROMISED)
    session.row("small tables of a first look", timing=quick.wall, cpu_ms=quick.cpu_ms)
    session.release()
    near = view("near")
    for name, scene, camera in (("air alone", _bare(), _cameras("100 m", "still")[0]), ("earth", "earth", near)):
        made = preset_scene(scene) if isinstance(scene, str) else scene
        start = air_speed.time_start(made, BENCH, PROMISED, camera)
        rows = (("first picture, never computed before", start.first_picture_ms, 1500.0),
                ("from there to the final tables", start.final_ms, 60e3),
                ("first picture, tables from disk", start.cached_ms, None))  # fmt: skip
        for what, ms, limit in rows:
            session.row(f"{PROMISED}, {name}: {what}", size=BENCH, timing=Timing.of([ms]), target_on="ms",
                        target=at_most(limit, "ms") if limit is not None else None)  # fmt: skip


def _skipping(session: Session) -> None:
    """What is not to be done, is not done."""
    with session.renderer("moon", BENCH, "low") as renderer:
        renderer.render(Camera.at(20.0, 10.0, 1e4))
        names = [p.name for p in renderer.passes() if p.name.startswith("atmosphere")]
        session.row("moon: passes of air", error=len(names), target=at_most(0))
        session.row("moon: OpenGL objects of air", error=len(renderer.gpu.counts().get("atmosphere", {})),
                    target=at_most(0))  # fmt: skip
    with session.renderer(_bare(), BENCH, "low") as renderer:
        for name in CAMERAS:
            again = air_speed.air_passes_run(renderer, _cameras(name, "still")[0])
            session.row("unchanged frame: passes of air", name, error=len(again), target=at_most(0),
                        which=", ".join(again))  # fmt: skip
        pixels = BENCH[0] * BENCH[1]
        views = {
            # Away from the sun as well: its disc is the sky's own.
            "2000 km, away from the planet": (Camera.at(20.0, 10.0, 2e6, heading_deg=200.0, pitch_deg=40.0), 0),
            "2000 km, planet in half of it": (_cameras("2000 km", "still")[0], pixels),
            "36 000 km, full disc": (Camera.at(20.0, 10.0, 36e6, pitch_deg=-90.0), pixels // 20),
        }
        for name, (camera, most) in views.items():
            drawn = air_speed.sky_fragments(renderer, camera)
            session.row("fragments of sky", name, BENCH, error=drawn, target=at_most(most))
        far = Camera.at(20.0, 10.0, 3.1e9, pitch_deg=-90.0)
        drawn, ran = air_speed.sky_fragments(renderer, far), air_speed.air_passes_run(renderer, far)
        session.row("planet smaller than a pixel: fragments and passes", "3.1 million km", BENCH,
                    error=drawn + len(ran), target=at_most(0))  # fmt: skip


def air_curve(
    session: Session, more: Mapping[str, tuple[str, Mapping[str, Any]]] | None = None
) -> Iterator[tuple[str, air_speed.Cost, dict[str, float]]]:
    """By quality: cost of sky and air of a climbing camera at 10 km, and errors of each class of CURVE, on Earth.

    more: further settings by name, each a quality and its overrides.
    """
    truths = _truths(session, "earth")
    label = {"climbing": _cameras("10 km", "climbing")}
    settings = {**{quality: (quality, {}) for quality in QUALITIES}, **(more or {})}
    with _renderers({name: (_bare(), *setting) for name, setting in settings.items()}, BENCH) as renderers:
        found = air_speed.time_passes(renderers, label, session.runs(9, 4))
    for name, (quality, overrides) in settings.items():
        with AtmosphereProbe(air.scene_of(air.PLANETS["earth"]), quality=quality, overrides=overrides) as probe:
            answers = {quantity: air.answers(probe, truth) for quantity, truth in truths.items()}
        errors = {
            one: air.errors(truths[quantity], answers[quantity], groups).values[statistic]
            for one, (quantity, groups, statistic) in CURVE.items()
        }
        yield name, air_speed.total(found[name, "climbing"], air_speed.AIR_PASSES), errors


def _curve(session: Session) -> None:
    """Run time against error."""
    for quality, cost, errors in air_curve(session):
        first = next(iter(CURVE))
        others: dict[str, Any] = {name: errors[name] for name in CURVE if name != first}
        session.row(
            quality, "10 km, climbing", BENCH, cost.wall, error=errors[first], error_unit=f"p95, {first}",
            cpu_ms=cost.cpu_ms, **others,
        )  # fmt: skip


def _thick(session: Session) -> None:
    """The air of the preset hazy, in which most light has been scattered many times, against paths followed one by one;
    and what its tables cost beside those of Earth's air."""
    truth = air_thick.thick_truth(session.runs(65_536, 16_384))
    for quality in QUALITIES[:-1]:
        cost = air_speed.time_tables(session.gpu, preset_scene("hazy"), quality)["total"]
        clear = air_speed.time_tables(session.gpu, _bare(), quality)["total"]
        session.release()
        for name, error in air_thick.thick_errors(truth, quality).items():
            session.row(
                f"{quality}: {name}", timing=cost.wall, error=error.all_colors, error_unit="of all light",
                target=at_most(0.1), worst_color=error.worst_color, noise=error.noise, clear_ms=clear.wall.ms,
            )  # fmt: skip


def _bare() -> Scene:
    """A planet of nothing but air: Earth's, as wide as Bruneton's."""
    scene = Scene("bare", {"planet": Planet(radius_m=6.36e6), "atmosphere": Atmosphere()})
    scene.sun = Sun(direction=(0.6, 0.0, 0.8))
    return scene


def _cameras(name: str, way: str) -> list[Camera]:
    """One that stands still, or four that take turns, each a thousandth higher: the tables are filled for each."""
    altitude, pitch = CAMERAS[name]
    steps = (0.0,) if way == "still" else (0.0, 1e-3, 2e-3, 3e-3)
    return [Camera.at(20.0, 10.0, altitude * (1.0 + s), heading_deg=30.0, pitch_deg=pitch) for s in steps]


@contextmanager
def _renderers(
    scenes: Mapping[str, tuple[Scene, str, Mapping[str, Any]]], size: tuple[int, int]
) -> Iterator[dict[str, Renderer]]:
    """Renderers that live side by side, to take turns: each has a context of its own."""
    made: dict[str, Renderer] = {}
    try:
        for name, (scene, quality, overrides) in scenes.items():
            made[name] = Renderer(scene, size, quality, overrides)
        yield made
    finally:
        for renderer in made.values():
            renderer.release()


def _ms(costs: Mapping[str, air_speed.Cost], name: str) -> float:
    return costs[name].wall.ms if name in costs else 0.0


BENCHES: Mapping[str, Bench] = {
    "accuracy": _accuracy, "curve": _curve, "speed": _speed, "shading": _shading, "tables": _tables,
    "skipping": _skipping, "thick": _thick,
}  # fmt: skip
