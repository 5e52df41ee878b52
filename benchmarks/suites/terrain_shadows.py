"""Suite terrain: shadows of the ground and its shelter from the sky."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ... import Camera, Renderer, Sun, Terrain, latitude_longitude, view
from ...engine.space import CameraState
from ..measure import shadows
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_most
from ..timing import time_variants

_SIZE = (640, 360)
_SEED = 20240602
_CASES = (("earth", "near", 8.0), ("earth", "valley", 14.0), ("earth", "high", 10.0), ("earth", "sunset", 3.0),
          ("earth", "terminator", 6.0), ("moon", "near", 5.0), ("moon", "terminator", 3.0))  # fmt: skip
"""Planet, view, the sun's elevation there in degrees."""


def _sun(state: CameraState, elevation_deg: float, azimuth_deg: float) -> Sun:
    latitude, longitude = latitude_longitude(state.position_m / np.linalg.norm(state.position_m))
    return Sun(
        elevation_deg=elevation_deg,
        azimuth_deg=azimuth_deg,
        latitude_deg=float(latitude),
        longitude_deg=float(longitude),
    )


def _shadows(session: Session) -> None:
    """Places of the ground against rays to the sun's disc in float64: how many are off by more than half."""
    for planet, name, elevation in _CASES[:4] if session.small else _CASES:
        shown = view(name, planet)
        with session.renderer(planet, _SIZE) as renderer:
            sun = _sun(renderer.camera_state(shown), elevation, shown.sun.azimuth_deg if shown.sun else 0.0)
            count = session.runs(1000, 250)
            found = shadows.shadow_error(renderer, shown, np.random.default_rng(_SEED), count, sun)
            session.row(
                f"{planet}, sun {elevation:g} degrees: off by more than half", name, error=found.wrong,
                target=at_most(0.03), mean=found.mean, truly_hidden=found.shadowed, places=found.places,
            )  # fmt: skip


def _shelter(session: Session) -> None:
    """Light of an even sky at places of the ground against rays in float64."""
    for name, roughness in (("high", None), ("valley", 2.5)):
        scene = preset_scene("earth")
        if roughness is not None:
            scene.planet[Terrain].roughness = roughness
        with session.renderer(scene, _SIZE) as renderer:
            shown = view(name)
            renderer.settle(shown)
            places = shadows.spots(renderer, shown, np.random.default_rng(_SEED), session.runs(100, 25))
            true = shadows.open_share(renderer, places)
            with shadows.LightProbe(renderer) as probe:
                ours = probe(places.seen_m)[:, 1]
            session.row(
                "mean difference" if roughness is None else f"roughness {roughness:g}: mean difference", name,
                error=float(np.abs(ours - true).mean()), target=at_most(0.015),
                without=float(np.abs(1.0 - true).mean()), places=len(true),
            )  # fmt: skip


_FLIGHTS = (("near", 12.0, 10.0), ("valley", 14.0, 10.0), ("high", 10.0, 100.0), ("orbit", 6.0, 8000.0))
"""View, the sun's elevation in degrees, metres a frame."""


def _along(state: CameraState, step_m: float, count: int) -> list[Camera]:
    ahead = state.forward - state.direction * float(state.forward @ state.direction)
    way = ahead / np.linalg.norm(ahead) + 0.1 * state.direction
    return [Camera(state.position_m + way * (step_m * k), state.forward, state.up) for k in range(count)]


def _steady(session: Session) -> None:
    """The sun's share at fixed places from frame to frame of a flight."""
    for name, elevation, step in _FLIGHTS:
        with session.renderer("earth", _SIZE) as renderer:
            shown = view(name)
            state = renderer.camera_state(shown)
            sun = _sun(state, elevation, shown.sun.azimuth_deg if shown.sun else 0.0)
            cameras = _along(state, step, session.runs(40, 12))
            found = shadows.steadiness(renderer, cameras, np.random.default_rng(_SEED), session.runs(4000, 1000), sun)
            session.row(
                f"{step:g} m a frame: change of the sun's share, p99.9", name, error=found.p999, target=at_most(0.2),
                p99=found.p99, worst=found.worst, mean=found.mean, frames=found.frames,
            )  # fmt: skip


def _cost(session: Session) -> None:
    """Whole frames with and without, by turns: a camera that turns, and one that flies."""
    for name, _, step in _FLIGHTS:
        shown = view(name)
        made: dict[str, Renderer] = {}
        try:
            for variant, on in (("without", False), ("with", True)):
                scene = preset_scene("earth")
                scene.planet[Terrain].shadows = scene.planet[Terrain].occlusion = on
                made[variant] = Renderer(scene, _SIZE, "medium")
            state = made["with"].camera_state(shown)
            turned = [Camera(state.position_m, state.forward + state.right * (1e-4 * k), state.up) for k in range(64)]
            for what, cameras in (("turning", turned), (f"{step:g} m a frame", _along(state, step, 64))):
                at = dict.fromkeys(made, 0)

                def frame(
                    variant: str,
                    renderer: Renderer,
                    path: list[Camera] = cameras,
                    at: dict[str, int] = at,
                    sun: Any = shown.sun,
                ) -> None:
                    at[variant] += 1
                    renderer.render(path[at[variant] % len(path)], sun=sun)
                    renderer.ctx.finish()

                for renderer in made.values():
                    renderer.settle(cameras[0], sun=shown.sun)
                runs: dict[str, Any] = {variant: lambda v=variant, r=made[variant]: frame(v, r) for variant in made}
                times = time_variants(runs, session.runs(24, 8), 2)
                session.row(
                    what, name, _SIZE, timing=times["with"], without_ms=times["without"].ms,
                    more_ms=times["with"].ms - times["without"].ms,
                )  # fmt: skip
        finally:
            for renderer in made.values():
                renderer.release()


SHADOW_BENCHES: Mapping[str, Bench] = {
    "shadows": _shadows,
    "shelter": _shelter,
    "shadows in flight": _steady,
    "shadows cost": _cost,
}
