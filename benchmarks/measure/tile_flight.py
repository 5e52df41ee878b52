"""A flight over tiles of elevation; as a script, in a process of its own, what it takes.

    python -m planetfall.benchmarks.measure.tile_flight FOLDER MOST_MB FRAMES    ->  a line of JSON

FOLDER "": the same ground without tiles. FRAMES 0: the tiles are read once, as `planetfall map make` does.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np

from ... import Camera, Clouds, Cover, Renderer, Scene, Sun, Terrain, direction, load_scene
from ...engine.real_ground.resident import real_ground
from ..machine import own_bytes, resident_bytes
from . import descent

__all__ = ["along"]

_SPEED_M_S, _ABOVE_M, _FRAME_S = 300.0, 100.0, 1.0 / 30.0
_LATITUDE_DEG, _LONGITUDE_DEG, _SIZE = 46.5, 7.2, (640, 360)


def along(scene: Scene, latitude_deg: float, longitude_deg: float, frames: int, frame_s: float) -> descent.Flight:
    """To the east from there at 300 m/s, 100 m above the ground."""
    step_deg = np.degrees(_SPEED_M_S * frame_s / scene.planet.radius_m) / np.cos(np.radians(latitude_deg))
    longitude = longitude_deg + step_deg * np.arange(frames)
    at = np.array([direction(latitude_deg, each) for each in longitude])
    # As smooth as a pilot flies: the mean over a kilometre.
    ground_m = scene.planet.ground_height_m(at)
    over = np.ones(101) / 101.0
    above_m = np.convolve(np.pad(ground_m, 50, mode="edge"), over, mode="valid") + _ABOVE_M
    cameras = tuple(
        Camera.at(latitude_deg, east, max(up, low + 0.3 * _ABOVE_M), heading_deg=90.0, pitch_deg=-10.0)
        for east, up, low in zip(longitude.tolist(), above_m.tolist(), ground_m.tolist(), strict=True)
    )
    return descent.Flight(cameras, frame_s, None, above_m)


def _flown(folder: str, most_mb: float, frames: int) -> dict[str, object]:
    scene = load_scene("earth")
    for kind in (Clouds, Cover):
        scene.planet.remove(kind)
    ground = scene.planet[Terrain]
    ground.rivers, ground.height_map_most_mb, ground.height_map = 0.0, most_mb, folder
    scene.sun = Sun(elevation_deg=40.0, latitude_deg=_LATITUDE_DEG, longitude_deg=_LONGITUDE_DEG)
    start = time.perf_counter()
    with Renderer(scene, _SIZE, "medium") as renderer:
        flight = along(scene, _LATITUDE_DEG, _LONGITUDE_DEG, frames, _FRAME_S)
        target = renderer.ctx.simple_framebuffer(_SIZE)
        renderer.render_to(target, flight.cameras[0])
        renderer.ctx.finish()
        first_s = time.perf_counter() - start
        used = descent.percentiles(descent.fly_timed(renderer, flight), _FRAME_S, cpu=True)
        own = own_bytes()
        renderer.gpu.leave(target)
        target.release()
    scene.release()
    return {
        "size": _SIZE, "first_frame_s": first_s, "p50_cpu_ms": used.p50_ms, "p99_of_cpu": used.p99_over_median,
        "worst_of_cpu": used.worst_over_median, "own_bytes": own,
    }  # fmt: skip


def main(folder: str, most_mb: str, frames: str) -> None:
    """Writes the JSON."""
    found: dict[str, object] = {}
    if int(frames):
        found = _flown(folder, float(most_mb), int(frames))
    else:
        real_ground(folder, int(1e6 * float(most_mb)), "bench", streams=True)
    sys.stdout.write(json.dumps({**found, "cpu_s": time.process_time(), "peak_bytes": resident_bytes(peak=True)}))


if __name__ == "__main__":
    main(*sys.argv[1:])
