"""Suite maps: elevation and pictures from tiles: how fast they are found and read, how exact heights are, what a height
costs."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from ... import Camera, Scene, Terrain, direction, load_scene
from ...engine.real_ground.color_files import read_color_tile
from ...engine.real_ground.color_pixels import roots_of
from ...engine.real_ground.color_reading import real_colors
from ...engine.real_ground.lattice import directions_at
from ...engine.real_ground.limited_cubic import OVERSHOOT
from ...engine.real_ground.resident import real_ground, resident_ground
from ...engine.real_ground.streamed_color_level import StreamedColorLevel
from ...engine.real_ground.streamed_colors import StreamedColors
from ...engine.real_ground.streamed_ground import StreamedGround
from ...engine.real_ground.streamed_level import StreamedLevel
from ...engine.real_ground.tile_folders import COLORS
from ...engine.real_ground.tile_index import open_tiles
from ...engine.wavelengths import DISPLAY_NM
from ...systems.terrain.height import TerrainParams, height
from ...systems.terrain.real_colors import color_layout
from ..child import answer_of
from ..measure import descent
from ..measure.frames import RUN_UP, turning
from ..measure.pictures import first_tile, processor_times, write_pictures
from ..measure.tile_flight import along
from ..measure.tiles import hgt_heights, write_empty, write_repeated, write_tiles
from ..session import Bench, Session
from ..target import at_most
from ..timing import time_variants

_MOST_BYTES = 256_000_000
_SOUTH, _WEST = 46, 7
_FEW_BYTES = 32_000_000
"""Of which most levels of one or two tiles of 1 arc second stream."""
_ZOOM, _FEW_PIXELS = 15, 12_000_000
"""Pixels of 3.3 m; a fraction of what the tiles take."""
_COUNTRY, _COUNTRY_MB = "planetfall.benchmarks.measure.tile_flight", 48


@contextmanager
def _folder() -> Iterator[Path]:
    """A folder, and a cache of its own, that go again."""
    before = os.environ.get("PLANETFALL_CACHE")
    with tempfile.TemporaryDirectory() as found:
        os.environ["PLANETFALL_CACHE"] = f"{found}/cache"
        try:
            yield Path(found) / "tiles"
        finally:
            if before is None:
                del os.environ["PLANETFALL_CACHE"]
            else:
                os.environ["PLANETFALL_CACHE"] = before


def maps_index(session: Session) -> None:
    """An index of many tiles: looked at for the first time, and opened again."""
    count = 100_000
    with _folder() as folder:
        write_empty(folder, count)
        for name, target in (("first look", None), ("opened again", at_most(1000.0, "ms"))):
            start = time.perf_counter()
            found = open_tiles(str(folder), "bench")
            ms = 1e3 * (time.perf_counter() - start)
            session.row(f"{count} tiles, {name}", error=ms, error_unit="ms", target=target, tiles=sum(map(len, found)))


def maps_reading(session: Session) -> None:
    """Tiles of 1 arc second into levels of pages, whole; and of 3 seconds into a sixteenth of the memory they want."""
    for name, side, tiles, most in (("1 arc second", 3601, 2, _MOST_BYTES), ("3, at 1/4", 1201, 4, 4_000_000)):
        with _folder() as folder:
            write_tiles(folder, _SOUTH, _WEST, 1, tiles, side)
            sets = open_tiles(str(folder), "bench")
            start = time.process_time()
            ground = resident_ground(sets, most, "bench")
            seconds = time.process_time() - start
            memory = sum(level.heights.nbytes + level.weights.nbytes for level in ground.levels)
            session.row(
                name, error=tiles / seconds, error_unit="tiles/s", megabytes=memory / 1e6,
                million_samples_per_s=tiles * side**2 / seconds / 1e6,
            )  # fmt: skip


def maps_heights(session: Session) -> None:
    """Heights at samples, and between them against the range of a cell's corners; 1000 heights beside the procedural
    ground's."""
    side = 1201
    with _folder() as folder:
        write_tiles(folder, _SOUTH, _WEST, 1, 1, side)
        ground = resident_ground(open_tiles(str(folder), "bench"), _MOST_BYTES, "bench")
    samples = hgt_heights(_SOUTH, _WEST, side).astype(float)
    rng = np.random.default_rng(1)
    count = session.runs(100_000, 20_000)
    row, column = rng.integers(0, side - 1, (2, count))
    step = side - 1.0
    found, _ = ground.heights(directions_at(_SOUTH + 1.0 - row / step, _WEST + column / step))
    worst_mm = 1e3 * np.abs(found - samples[row, column]).max()
    session.row("at samples", error=worst_mm, error_unit="mm", target=at_most(1.0, "mm"))
    f, g = rng.random((2, count))
    found, _ = ground.heights(directions_at(_SOUTH + 1.0 - (row + f) / step, _WEST + (column + g) / step))
    corners = np.stack([samples[row + b, column + a] for a in (0, 1) for b in (0, 1)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    over = np.maximum(found - high, low - found) / np.maximum(high - low, 1.0)
    session.row("between, beyond the corners' range", error=100.0 * max(float(over.max()), 0.0), error_unit="%",
                target=at_most(100.0 * OVERSHOOT, "%"))  # fmt: skip
    plain = TerrainParams()
    grounds = {
        "procedural": plain,
        "tiles": replace(plain, real=ground, height_map_detail=0.0),
        "tiles, relief below samples": replace(plain, real=ground),
    }
    places = directions_at(_SOUTH + rng.uniform(0.1, 0.9, 1000), _WEST + rng.uniform(0.1, 0.9, 1000)).T
    runs = {name: lambda p=params: height(places, p) for name, params in grounds.items()}
    for name, timing in time_variants(runs, session.runs(40, 10), 3).items():
        session.row(f"1000 heights, {name}", timing=timing)


def maps_frame(session: Session) -> None:
    """A turning camera's frames 300 m above a tile of 1 arc second, with the tile and without by turns."""
    with _folder() as folder, ExitStack() as stack:
        write_tiles(folder, _SOUTH, _WEST, 1, 1, 3601)
        size, renderers, camera = (640, 360), [], None
        for tiles in ("", str(folder)):
            scene = load_scene("earth")
            ground = scene.planet[Terrain]
            ground.rivers, ground.height_map = 0.0, tiles
            renderers.append(stack.enter_context(session.renderer(scene, size, "medium")))
            # Of the tiled ground in the end: both see the same sky and as much ground.
            above_m = float(scene.planet.ground_height_m(direction(_SOUTH + 0.5, _WEST + 0.5)[None])[0]) + 300.0
            camera = Camera.at(_SOUTH + 0.5, _WEST + 0.5, above_m, pitch_deg=-10.0)
        assert camera is not None
        frames = {name: turning(renderer, camera) for name, renderer in zip(("bare", "tiled"), renderers, strict=True)}
        found = time_variants(frames, session.runs(30, 8), RUN_UP)
        session.row(
            "300 m above a tile", size=size, timing=found["tiled"], error=found["tiled"].ms / found["bare"].ms,
            error_unit="times", bare_ms=found["bare"].ms,
        )  # fmt: skip


def maps_pages(session: Session) -> None:
    """Tiles of 1 arc second in a fraction of the memory they want: read for the first time, pages made from them one by
    one and by the square, and read from files that were kept."""
    tiles, count = session.runs(2, 1), session.runs(128, 32)
    with _folder() as folder:
        write_tiles(folder, _SOUTH, _WEST, 1, tiles, 3601)
        start = time.process_time()
        ground = real_ground(str(folder), _FEW_BYTES, "bench", streams=True)
        seconds = time.process_time() - start
        assert isinstance(ground, StreamedGround)
        level = ground.levels[0]
        assert isinstance(level, StreamedLevel)
        session.row(
            "tiles read once", error=tiles / seconds, error_unit="tiles/s", megabytes=ground.resident_bytes / 1e6,
            budget_mb=_FEW_BYTES / 1e6,
        )  # fmt: skip
        inner = np.flatnonzero(~level.maybe_weighed)[: 3 * count]
        for name, ahead, first in (("made", False, 0), ("made by the square", True, 1), ("read again", True, 1)):
            start, files = time.process_time(), level.source
            for number in inner[first * count : (first + 1) * count].tolist():
                files.page(*level.where[number].tolist(), ahead=ahead)
            session.row(f"pages {name}", error=count / (time.process_time() - start), error_unit="pages/s")


def maps_flight(session: Session) -> None:
    """300 m/s, 100 m above tiles of 1 arc second of which a tenth is in memory, and of which all is: how even frames
    are, how far ground moves on screen from one to the next but by the camera, and what is taken in in a frame."""
    size, frames, frame_s = (320, 180), session.runs(450, 60), 1.0 / 30.0
    with _folder() as folder:
        write_tiles(folder, _SOUTH, _WEST, 1, session.runs(2, 1), 3601)
        for name, most_mb in (("streamed", 1e-6 * _FEW_BYTES), ("in memory", 256.0)):
            scene = load_scene("earth")
            ground = scene.planet[Terrain]
            ground.rivers, ground.height_map_most_mb, ground.height_map = 0.0, most_mb, str(folder)
            flight = along(scene, _SOUTH + 0.5, _WEST + 0.2, frames, frame_s)
            with session.renderer(scene, size, "medium") as renderer:
                flown = descent.fly_timed(renderer, flight)
            clock, used = (descent.percentiles(flown, frame_s, cpu) for cpu in (False, True))
            most = descent.most(flown[1:])
            session.row(
                f"{name}: worst frame over the median", size=size, error=clock.worst_over_median,
                of_cpu=used.worst_over_median, p99=clock.p99_over_median, p50_ms=clock.p50_ms, frames=frames,
                most_upload_mb=most["upload_bytes"] / 1e6,
            )  # fmt: skip
            with session.renderer(scene, size, "medium") as renderer:
                moved = [step for step in descent.pops(renderer, flight) if step.pixels]
            session.row(
                f"{name}: ground moves", size=size, error=float(np.median([step.p999_px for step in moved])),
                error_unit="px", target=at_most(1.0, "px"), worst_px=max(step.worst_px for step in moved),
                p999_px=max(step.p999_px for step in moved), frames=frames,
            )  # fmt: skip
            scene.release()


def maps_pictures(session: Session) -> None:
    """Tiles of pictures in a fraction of the memory that they want: decoded, read once, pages of them as in
    maps.pages; a frame's processor time with them and without by turns; and the flight of maps.flight over them."""
    across, down = session.runs(36, 16), session.runs(20, 12)
    with _folder() as folder:
        x, y = first_tile(_ZOOM, _SOUTH + 0.5, _WEST + 0.2)
        write_tiles(folder.parent / "heights", _SOUTH, _WEST, 1, 1, 1201)
        write_pictures(folder, _ZOOM, (x - 4, y - down // 2), across, down)
        tiles = open_tiles(str(folder), "bench", kind=COLORS)[0]
        start, count = time.process_time(), min(len(tiles), 64)
        for number in range(count):
            roots_of(read_color_tile(*tiles.tile(number)), DISPLAY_NM)
        session.row("tiles decoded", error=count / (time.process_time() - start), error_unit="tiles/s", tiles=count)
        start = time.process_time()
        colors = real_colors(str(folder), DISPLAY_NM, _FEW_PIXELS, "bench", streams=True)
        assert isinstance(colors, StreamedColors)
        seconds = time.process_time() - start
        session.row(
            "tiles read once", error=len(tiles) / seconds, error_unit="tiles/s", megabytes=colors.resident_bytes / 1e6,
            whole_mb=5.33e-6 * tiles.samples, budget_mb=_FEW_PIXELS / 1e6,
        )  # fmt: skip
        _picture_pages(session, colors)
        _picture_frames(session, folder)
        _picture_flight(session, folder, colors)


def _picture_pages(session: Session, colors: StreamedColors) -> None:
    level, count = colors.sets[0].levels[0], session.runs(128, 32)
    assert isinstance(level, StreamedColorLevel)
    inner = np.arange(len(level.where))[len(level.where) // 4 :]
    for name, ahead, first in (("made", False, 0), ("made by the square", True, 1), ("read again", True, 1)):
        start = time.process_time()
        for number in inner[first * count : (first + 1) * count].tolist():
            level.source.page(*level.where[number].tolist(), ahead=ahead)
        session.row(f"pages {name}", error=count / (time.process_time() - start), error_unit="pages/s")


def _pictured(folder: Path, most_mb: float) -> Scene:
    scene = load_scene("earth")
    ground = scene.planet[Terrain]
    ground.rivers, ground.height_map = 0.0, str(folder.parent / "heights")  # land for pictures to lie on
    if most_mb:
        ground.color_map_most_mb, ground.color_map = most_mb, str(folder)
    return scene


def _picture_frames(session: Session, folder: Path) -> None:
    size, camera = (640, 360), Camera.at(_SOUTH + 0.5, _WEST + 0.25, 300.0, pitch_deg=-25.0, above="ground")
    with ExitStack() as stack:
        frames = {}
        for name, most_mb in (("bare", 0.0), ("in memory", 256.0), ("streamed", 1e-6 * _FEW_PIXELS)):
            renderer = stack.enter_context(session.renderer(_pictured(folder, most_mb), size, "medium"))
            frames[name] = turning(renderer, camera)
        found = processor_times(frames, session.runs(30, 8), RUN_UP)
        for name in ("in memory", "streamed"):
            session.row(
                f"frame with pictures {name} over without", size=size, error=found[name] / found["bare"],
                error_unit="times", target=at_most(1.5, "times"), cpu_ms=found[name], bare_cpu_ms=found["bare"],
            )  # fmt: skip


def _picture_flight(session: Session, folder: Path, colors: StreamedColors) -> None:
    size, frames, frame_s = (320, 180), session.runs(300, 60), 1.0 / 30.0
    for name, most_mb in (("streamed", 1e-6 * _FEW_PIXELS), ("in memory", 256.0), ("bare", 0.0)):
        scene = _pictured(folder, most_mb)
        flight = along(scene, _SOUTH + 0.5, _WEST + 0.2, frames, frame_s)
        with session.renderer(scene, size, "medium") as renderer:
            flown = descent.fly_timed(renderer, flight)[1:]
        clock, used = (descent.percentiles(flown, frame_s, cpu) for cpu in (False, True))
        session.row(
            f"flight, pictures {name}: worst frame over the median", size=size, error=clock.worst_over_median,
            of_cpu=used.worst_over_median, p99=clock.p99_over_median, p50_ms=clock.p50_ms, frames=frames,
            upload_mb=float(np.mean([work.upload_bytes for work in flown])) / 1e6,
            most_upload_mb=max(work.upload_bytes for work in flown) / 1e6,
            resident_mb=colors.resident_bytes / 1e6 if name == "streamed" else 0.0,
            gpu_mb=4e-6 * _texels(colors) if name == "streamed" else 0.0,
        )  # fmt: skip
        scene.release()


def _texels(colors: StreamedColors) -> int:
    layout = color_layout(colors)
    return layout.rows << layout.width_bits


def maps_country(session: Session) -> None:
    """Tiles of 1 arc second, 10 GB of them, in 48 MB: how long reading them once takes, and a flight of 300 m/s 100
    m above them and without tiles, clouds or trees, each in a process of its own: how even frames are, and the most
    memory it ever had; its own, at the end, is without pages of files, which are libraries'. The second run of each
    counts: its shaders are kept."""
    across, frames = session.runs(20, 2), session.runs(300, 60)
    with _folder() as folder:
        write_repeated(folder, _SOUTH - across // 2, _WEST - min(across // 2, 3), across, across)
        tiles = len(list(folder.iterdir()))
        start = time.perf_counter()
        prepared = answer_of("-m", _COUNTRY, str(folder), str(_COUNTRY_MB), "0", timeout_s=3600.0)
        session.row(
            f"{tiles} tiles made ready", error=time.perf_counter() - start, error_unit="s",
            of_cpu=prepared["cpu_s"], peak_mib=prepared["peak_bytes"] / 2**20,
        )  # fmt: skip
        peak = {}
        for name, there in (("bare", ""), ("streamed", str(folder))):
            flown = ("-m", _COUNTRY, there, str(_COUNTRY_MB), str(frames))
            answer_of(*flown, timeout_s=3600.0)
            found = answer_of(*flown, timeout_s=3600.0)
            peak[name] = found["peak_bytes"] / 2**20
            session.row(
                f"{name}: worst frame over the median", size=tuple(found["size"]), error=found["worst_of_cpu"],
                target=at_most(2.0, "") if there else None, p99=found["p99_of_cpu"], p50_cpu_ms=found["p50_cpu_ms"],
                first_frame_s=found["first_frame_s"], peak_mib=peak[name], frames=frames,
            )  # fmt: skip
            if there and peak[name]:
                session.row(
                    "streamed: the process's own memory", size=tuple(found["size"]),
                    error=found["own_bytes"] / 2**20, error_unit="MiB", target=at_most(450.0, "MiB"),
                )  # fmt: skip
        if not all(peak.values()):  # a system that doesn't tell
            return
        session.row(
            "memory that tiles add", error=peak["streamed"] - peak["bare"], error_unit="MiB",
            target=at_most(2.0 * _COUNTRY_MB * 1e6 / 2**20, "MiB"), of_gb=tiles * 2.0 * 3601**2 / 1e9,
        )  # fmt: skip


BENCHES: Mapping[str, Bench] = {
    "index": maps_index,
    "reading": maps_reading,
    "heights": maps_heights,
    "frame": maps_frame,
    "pages": maps_pages,
    "flight": maps_flight,
    "pictures": maps_pictures,
    "country": maps_country,
}
