"""Suite ocean: waves on the GPU against float64, their time, and how steady the picture of them is."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from ... import Ocean, Renderer, Wave, direction
from ...engine.waves import WaveSet, displacement, waves_of
from ...systems.ocean.wave_block import SeaMesh, WavePacker
from ...systems.ocean.wave_probe import WaveQuestions
from ...systems.ocean.wave_record import RecordPacker
from ..measure import waves as measure
from ..measure.flip import flip
from ..reference.waves import displaced
from ..session import Bench, Session
from ..target import at_least, at_most
from ..timing import time_variants

SEED = 20260703
SIZE, QUICK_SIZE = (640, 360), (320, 180)
RADII_M = (6.371e6, 7.0e7)
TIMES_S = (0.0, 1e5, 1e8)
ORIGIN = (20.0, 30.0)
_PLACES = {
    "open water": measure.OPEN_SEA,
    "1 km from an origin": (ORIGIN[0] - 0.009, ORIGIN[1]),
    "at an antipode": (-ORIGIN[0], ORIGIN[1] - 180.0),
    "a quarter turn from it": (-(90.0 - ORIGIN[0]), ORIGIN[1]),
}
_LINES = {
    "date line": ((10.0, 179.999), (10.0, -179.999)),
    "pole": ((89.999, 20.0), (89.999, -160.0)),
    "edge of cube faces": ((44.9995, 0.0), (45.0005, 0.0)),
    "origin": ((ORIGIN[0] - 0.002, ORIGIN[1]), (ORIGIN[0] + 0.002, ORIGIN[1])),
    "antipode": ((-ORIGIN[0] - 0.002, ORIGIN[1] - 180.0), (-ORIGIN[0] + 0.002, ORIGIN[1] - 180.0)),
}
_PRINTED = ("paper_2018", "paper_2019")
COUNTS = (20, 50, 100, 1000)
VIEWS_M = {"5 m": 5.0, "1 km": 1000.0, "400 km": 4.0e5}


def _seas(radius_m: float) -> dict[str, WaveSet]:
    near = Ocean(waves=(Wave(ORIGIN, 1.0, 60.0, 0.6), Wave((-50.0, 140.0), 0.6, 25.0, 0.5, 1.7)))
    return {"wind": waves_of(Ocean(wave_count=20), radius_m), "rings": waves_of(near, radius_m)}


def _accuracy(session: Session) -> None:
    """Displacement and normals within 1 km of the anchor; the printed formulas in float32 beside."""
    rng = np.random.default_rng(SEED)
    count = session.runs(1000, 200)
    for radius in RADII_M:
        for sea, found in _seas(radius).items():
            questions = WaveQuestions(session.gpu.scope("bench waves"), found, radius)
            for place, where in _PLACES.items():
                anchor = direction(*where)
                v = measure.around(anchor, found.radius_m, rng, count)
                for time_s in TIMES_S:
                    true = displacement(found, v, time_s)
                    ours = questions.ask(anchor, v, time_s)
                    printed = [questions.ask(anchor, v, time_s, method=m).displacement_m for m in _PRINTED]
                    off = [float(np.median(np.linalg.norm(p - true, axis=1))) for p in printed]
                    tilt = measure.degrees_between(ours.normal, measure.true_normals(found, v, time_s))
                    name = f"{radius:.3g} m, {sea}, t = {time_s:g} s"
                    session.row(
                        name, place, error=1e3 * np.linalg.norm(ours.displacement_m - true, axis=1).max(),
                        error_unit="mm", target=at_most(1.0, "mm"), printed_2018_m=off[0], printed_2019_m=off[1],
                    )  # fmt: skip
                    session.row(
                        f"{name}: normals", place, error=tilt.max(), error_unit="deg", target=at_most(0.05, "deg")
                    )
    # The float64 waves themselves, which the rows above trust, against extended precision.
    found = _seas(RADII_M[0])["wind"]
    v = measure.around(direction(*measure.OPEN_SEA), found.radius_m, rng, 50)
    for time_s in TIMES_S:
        long = displaced(
            v, found.origins, found.amplitude_m, found.wavelength_m, found.steepness, found.speed_rad_s,
            found.radius_m, time_s,
        )  # fmt: skip
        v_long = v.astype(np.longdouble)
        v_long /= np.sqrt((v_long * v_long).sum(axis=1))[:, None]
        off_m = np.asarray(long - v_long * np.longdouble(found.radius_m), np.float64) - displacement(found, v, time_s)
        session.row(f"float64 against extended precision, t = {time_s:g} s", "open water",
                    error=1e3 * float(np.abs(off_m).max()), error_unit="mm", target=at_most(0.1, "mm"))  # fmt: skip


def _arcs(session: Session) -> None:
    """The printed arcs in float32, near an origin and a quarter turn away: metres along the way; and the sea that is
    drawn with them."""
    radius = RADII_M[0]
    # Waves of a million metres show the way itself: sin and cos give their phase to 1e-6.
    length = 1e6
    found = waves_of(Ocean(waves=(Wave(ORIGIN, 1.0, length, 0.0, 0.0),)), radius)
    questions = WaveQuestions(session.gpu.scope("bench arcs"), found, radius)
    o = direction(*ORIGIN)
    side = np.cross(o, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side)
    for place, way in (("1 km from an origin", 1000.0), ("a quarter turn from it", 0.5 * np.pi * radius)):
        angles = (way + np.linspace(-500.0, 500.0, 401)) / radius
        v = np.cos(angles)[:, None] * o + np.sin(angles)[:, None] * side
        for method in _PRINTED:
            height = np.einsum("ij,ij->i", questions.ask(v[200], v, 0.0, method=method).displacement_m, v)
            true = np.sin(2.0 * np.pi * angles * radius / length)
            slope = np.abs(np.cos(2.0 * np.pi * angles * radius / length)) * 2.0 * np.pi / length
            off = np.abs(height - true) / np.maximum(slope, 0.1 * 2.0 * np.pi / length)
            session.row(f"arc {method}", place, error=off.max(), error_unit="m")
    _drawn_arcs(session)


def _drawn_arcs(session: Session) -> None:
    """A wind's sea as the printed methods draw it: by phases from an anchor, and with `Ocean.printed_arcs`."""
    scene = measure.sea_scene(20)
    sea, camera = scene.planet[Ocean], measure.open_sea(5.0)
    with session.renderer(scene, (160, 90), "medium") as renderer:
        for method in _PRINTED:
            for printed in (False, True):
                sea.method, sea.printed_arcs = method, printed
                found = waves_of(sea, RADII_M[0])
                off = measure.height_error(renderer, camera, 7.0, 100.0, found)
                session.row(f"drawn {method}{', printed_arcs' if printed else ''}", "open water",
                            error=float(np.sqrt(np.mean(off**2))), error_unit="m rms",
                            significant_height_m=found.significant_height_m)  # fmt: skip


def _seams(session: Session) -> None:
    """The largest step across places where a map would tear, over the largest step around them."""
    for radius in RADII_M:
        found = _seas(radius)["rings"]
        questions = WaveQuestions(session.gpu.scope("bench seams"), found, radius)
        for place, (first, last) in _LINES.items():
            a, b = direction(*first), direction(*last)
            line = a + np.linspace(0.0, 1.0, 2001)[:, None] * (b - a)
            line /= np.linalg.norm(line, axis=1, keepdims=True)
            got = questions.ask(line[1000], line, 1e5)
            for what, values in (("displacement", got.displacement_m), ("normal", got.normal)):
                steps = np.linalg.norm(np.diff(values, axis=0), axis=1)
                beside = max(np.delete(steps[950:1050], slice(45, 55)).max(), 1e-4)
                session.row(f"{radius:.3g} m: {what}", place, error=steps[995:1005].max() / beside,
                            error_unit="of its neighbours", target=at_most(1.5))  # fmt: skip


def _bytes(session: Session) -> None:
    """Memory of a wave in float32: what describes it, and what the GPU reads of it each frame."""
    found = _seas(RADII_M[0])["wind"]
    parts = (found.origins, found.amplitude_m, found.wavelength_m, found.steepness, found.speed_rad_s)
    describes = sum(4 * part.size for part in parts) / len(found)
    sizes = []
    for waves in (found, waves_of(Ocean(wind_speed_m_s=0.0, swell_height_m=0.0), RADII_M[0])):
        block = WavePacker()
        block.place(waves, direction(*measure.OPEN_SEA), RADII_M[0], SeaMesh())
        sizes.append(block.used_bytes)
    session.row("parameters of a wave", error=describes, error_unit="bytes", target=at_most(28, "bytes"))
    session.row("a wave at an anchor, on the GPU", error=(sizes[0] - sizes[1]) / len(found), error_unit="bytes")
    for name, printed in (("a wave of the printed sea at an anchor", False), ("a wave with printed_arcs", True)):
        records = RecordPacker(printed)
        records.place(found, direction(*measure.OPEN_SEA), RADII_M[0], SeaMesh())
        session.row(f"{name}, on the GPU", error=records.records.nbytes / len(found), error_unit="bytes",
                    target=at_most(28, "bytes"))  # fmt: skip
    session.row("all of no waves", error=sizes[1], error_unit="bytes")


def _made(stack: ExitStack, waves: int, size: tuple[int, int], method: str = "ours", **overrides: float) -> Renderer:
    keys = {name.replace("__", "."): value for name, value in overrides.items()}
    return stack.enter_context(Renderer(measure.sea_scene(waves, method), size, "medium", keys))


def _speed(session: Session) -> None:
    """The printed method and ours by number of waves: time of what makes the sea's shape, FLIP to a converged picture.

    Ours stands in the table with pixels and edges of several widths. `no_worse`: the fastest of these that is nowhere
    farther from the converged picture than the printed one.
    """
    size = QUICK_SIZE if session.small else SIZE
    runs = session.runs(7, 3)
    for view, altitude in (("1 km", 1000.0),) if session.small else (("5 m", 5.0), ("1 km", 1000.0)):
        camera = measure.open_sea(altitude)
        for waves in (20, 100, 1000) if session.small else COUNTS:
            seen, times = measure.against_printed(camera, size, waves, runs)
            for name, timing in times.items():
                session.row(f"{waves} waves, {name}", view, size, timing.shape, seen[name], "FLIP",
                            frame_ms=timing.frame.ms)  # fmt: skip
            for paper in ("paper", "paper, edges of 4 px"):
                able = [n for n in times if n.startswith("ours") and seen[n] <= seen[paper]]
                best = min(able, key=lambda n: times[n].shape.ms, default="")
                ratio = times[paper].shape.ms / times[best].shape.ms if best else float("nan")
                session.row(
                    f"{waves} waves, {paper} over ours no farther off", view, size, error=ratio, error_unit="times",
                    target=at_least(2.0) if waves >= 100 else None, no_worse=best,
                )  # fmt: skip


def _frame(session: Session) -> None:
    """Whole frames of moving water with its sky."""
    size = QUICK_SIZE if session.small else SIZE
    for waves, most in ((20, 30.0), (1000, 60.0)):
        for view, altitude in VIEWS_M.items():
            with ExitStack() as stack:
                side = {"": _made(stack, waves, size)}
                found = measure.sea_times(side, measure.open_sea(altitude), session.runs(9, 3))[""]
            session.row(f"{waves} waves", view, size, found.frame, target=at_most(most, "ms"), target_on="ms",
                        shape_ms=found.shape.ms)  # fmt: skip


def _footprint(session: Session) -> None:
    """What a pixel counts as, swept: time against the distance from the converged picture."""
    size = QUICK_SIZE if session.small else SIZE
    for view, altitude in (("5 m", 5.0), ("1 km", 1000.0)):
        camera = measure.open_sea(altitude)
        wanted = measure.converged(camera, size, 100, 7.0, finer=3)
        with ExitStack() as stack:
            sides = {f"{px:g} px": _made(stack, 100, size, ocean__footprint_px=px) for px in (0.5, 1.0, 2.0, 4.0, 8.0)}
            seen = {}
            for name, renderer in sides.items():
                with renderer.ctx:
                    seen[name] = float(flip(wanted, renderer.render(camera, time_s=7.0)["color"]).mean())
            times = measure.sea_times(sides, camera, session.runs(5, 2))
        for name, timing in times.items():
            session.row(f"pixels of {name}", view, size, timing.shape, seen[name], "FLIP")
    for waves in (20, 100, 1000):
        with session.renderer(measure.sea_scene(waves), size) as renderer:
            found = waves_of(renderer.scene.planet[Ocean], RADII_M[0])
            off = measure.height_error(renderer, measure.open_sea(5.0), 7.0, 200.0, found)
            session.row(f"{waves} waves: drawn height against float64", "5 m", size,
                        error=1e3 * float(np.sqrt(np.mean(off**2))), error_unit="mm rms",
                        worst_mm=1e3 * float(np.abs(off).max()))  # fmt: skip


def _flicker(session: Session) -> None:
    """A fixed camera over moving water: how much pixels vary in time, over what supersampled ones do."""
    size, finer = (160, 90), 4
    frames = session.runs(12, 6)
    for view, altitude in (("1 km", 1.0e3), ("10 km", 1.0e4), ("400 km", 4.0e5)):
        camera = measure.open_sea(altitude)
        spread: dict[str, float] = {}
        for name, factor in (("drawn", 1), ("true", finer)):
            overrides = {"ocean.footprint_px": 0.5} if factor > 1 else None
            scaled = (size[0] * factor, size[1] * factor)
            with session.renderer(measure.sea_scene(100), scaled, "medium", overrides) as renderer:
                shown = [
                    _averaged(renderer.render(camera, time_s=0.37 * k, outputs=("radiance",))["radiance"], factor)
                    for k in range(frames)
                ]
            stack = np.stack(shown)
            spread[name] = float(np.sqrt(np.mean(np.var(stack, axis=0))) / np.mean(stack))
        session.row(
            "change in time beyond the true one", view, size, error=max(spread["drawn"] - spread["true"], 0.0),
            error_unit="of the mean", target=at_most(0.005), drawn=spread["drawn"], true=spread["true"],
        )  # fmt: skip


def _averaged(picture: NDArray[np.float32], factor: int) -> NDArray[np.float64]:
    height, width = picture.shape[0] // factor, picture.shape[1] // factor
    return picture.reshape(height, factor, width, factor, 3).astype(np.float64).mean(axis=(1, 3))


def _python(session: Session) -> None:
    """Reducing the waves to a moment in float64, once a frame."""
    for waves in (20, 1000):
        found = waves_of(Ocean(wave_count=waves), RADII_M[0])
        anchor, block = direction(*measure.OPEN_SEA), WavePacker()
        block.place(found, anchor, RADII_M[0], SeaMesh())
        timing = time_variants({"": lambda b=block, f=found: b.at(f, 1e5)}, session.runs(50, 10), 3)[""]
        session.row(f"phases of {waves} waves", timing=timing)


WAVE_BENCHES: Mapping[str, Bench] = {
    "waves": _accuracy,
    "arcs": _arcs,
    "seams": _seams,
    "bytes": _bytes,
    "speed": _speed,
    "frame": _frame,
    "footprint": _footprint,
    "flicker": _flicker,
    "python": _python,
}
