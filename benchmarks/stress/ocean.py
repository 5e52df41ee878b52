"""Stress suite ocean: random seas on random planets; shaders as float64 has them, pictures without holes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ... import Ocean, Renderer, Wave
from ...engine.waves import displacement, waves_of
from ...systems.ocean.wave_probe import WaveQuestions
from ..measure.waves import around, degrees_between, true_normals
from ..session import Session
from .draw import log_uniform, unit
from .runner import Case, Found, Kind
from .scenes import build_scene

RADII_M = (1e4, 7e7)
NEAREST_SHARE = 1e-3
"""What is asked lies within a kilometre, and within this share of the radius on small planets."""
SEEN_LENGTHS = 1000.0
"""Farther away a wave is shorter than two pixels of 0.5 mrad, those of 1080 rows and 30 degrees."""
WAVES = (1, 3, 20, 200)
LENGTHS_M = (0.5, 500.0)


def draw_sea(rng: np.random.Generator, radius_m: float) -> Case:
    """Explicit waves: origins anywhere, now and then at the place itself; steep, but not beyond the limit."""
    count = int(rng.choice(WAVES))
    longest = min(LENGTHS_M[1], 0.01 * radius_m)
    lengths = [log_uniform(rng, min(LENGTHS_M[0], 0.1 * longest), longest) for _ in range(count)]
    slopes = rng.uniform(0.0, 1.0, count)
    slopes *= float(rng.choice([0.05, 0.5, 0.99])) / max(float(slopes.sum()), 1e-9)
    place = unit(rng)
    origins = [_origin(rng, np.array(place)) for _ in range(count)]
    return {
        "place": place,
        "waves": [
            {
                "origin": list(origin),
                "amplitude_m": float(slope * length / (2.0 * np.pi)),
                "wavelength_m": float(length),
                "steepness": float(rng.choice([0.0, 0.7, 1.0])),
                "speed_rad_s": float(rng.choice([-1.0, 1.0]) * np.sqrt(9.81 * 2.0 * np.pi / length)),
            }
            for origin, slope, length in zip(origins, slopes, lengths, strict=True)
        ],
    }


def _origin(rng: np.random.Generator, place: Any) -> tuple[float, float]:
    kind = rng.choice(["anywhere", "near", "antipode", "pole"], p=[0.7, 0.1, 0.1, 0.1])
    if kind == "pole":
        return (float(rng.choice([-90.0, 90.0])), 0.0)
    o = {"anywhere": np.array(unit(rng)), "near": place, "antipode": -place}[kind] + 1e-5 * rng.normal(size=3)
    o /= np.linalg.norm(o)
    return (float(np.degrees(np.arcsin(o[2]))), float(np.degrees(np.arctan2(o[1], o[0]))))


def ocean_of(case: Case) -> Ocean:
    """The sea of a case."""
    return Ocean(waves=tuple(Wave(**{**w, "origin": tuple(w["origin"])}) for w in case["waves"]))


def _draw_probe(rng: np.random.Generator) -> Case:
    radius = log_uniform(rng, *RADII_M)
    time_s = float(rng.choice([0.0, 1.0, 1e5, 1e8]))
    return {"radius_m": radius, "time_s": time_s, "seed": int(rng.integers(2**31)), **draw_sea(rng, radius)}


def _check_probe(case: Case, session: Session) -> Found:
    """Displacement and normals around a place."""
    found = Found()
    waves = waves_of(ocean_of(case), case["radius_m"])
    scope = session.gpu.scope("stress waves")
    try:
        questions = WaveQuestions(scope, waves, case["radius_m"])
        anchor = np.array(case["place"])
        shortest = min(w["wavelength_m"] for w in case["waves"])
        reach = min(1000.0, NEAREST_SHARE * case["radius_m"], SEEN_LENGTHS * shortest)
        v = around(anchor, waves.radius_m, np.random.default_rng(case["seed"]), 200, reach)
        got = questions.ask(anchor, v, case["time_s"])
        found.expect(bool(np.isfinite(got.displacement_m).all() and np.isfinite(got.normal).all()), "not finite")
        off = np.linalg.norm(got.displacement_m - displacement(waves, v, case["time_s"]), axis=1).max()
        found.note("displacement", 1e3 * off, "mm", at_most=1.0)
        # Shorter steps than the shortest wave is curved in.
        true = true_normals(waves, v, case["time_s"], min(1e-3 * shortest, 0.02))
        # At a crest that is about to fold the normal turns over within millimetres: in proportion to the room left.
        tilt = (degrees_between(got.normal, true) * np.clip(got.jacobian, 0.0, 1.0)).max()
        found.note("normal", tilt, "deg", at_most=0.05)
    finally:
        scope.release()
    return found


def _draw_picture(rng: np.random.Generator) -> Case:
    radius = log_uniform(rng, 1e5, 7e7)
    return {
        "radius_m": radius,
        "altitude_m": log_uniform(rng, 1.0, 1e5),
        "time_s": float(rng.uniform(0.0, 1e6)),
        "turn": [float(rng.uniform(-80.0, 0.0)), float(rng.uniform(0.0, 360.0))],
        "method": str(rng.choice(["ours", "ours", "paper_2018"])),
        **draw_sea(rng, radius),
    }


def _check_picture(case: Case, session: Session) -> Found:
    """A planet that is all sea: what looks down sees water, finite, everywhere."""
    from ... import Camera
    from ...engine.space.axes import heading_pitch_axes

    found = Found()
    session.release()
    scene = build_scene({"planet": {"radius_m": case["radius_m"]}, "sun": {"direction": case["place"]}})
    sea = ocean_of(case)
    sea.method = case["method"]
    scene.planet.add(sea)
    zenith = np.array(case["place"])
    highest = sum(w["amplitude_m"] for w in case["waves"])
    position = zenith * (case["radius_m"] + highest + case["altitude_m"])
    pitch, heading = case["turn"]
    forward, up = heading_pitch_axes(zenith, heading, pitch)[:2]
    camera = Camera(position, forward, up)
    with Renderer(scene, (96, 54), "low") as renderer:
        out = renderer.render(camera, time_s=case["time_s"], outputs=("surface", "normal", "radiance"))
        state = renderer.camera_state(camera)
        x = np.linspace(state.tan_left, state.tan_right, 97)
        y = np.linspace(state.tan_top, state.tan_bottom, 55)
        rays = (
            state.forward
            + 0.5 * (x[1:] + x[:-1])[None, :, None] * np.cross(state.forward, state.up)
            + 0.5 * (y[1:] + y[:-1])[:, None, None] * state.up
        )
        rays /= np.linalg.norm(rays, axis=2, keepdims=True)
        lowest = case["radius_m"] - highest
        dip = np.arccos(min(lowest / float(np.linalg.norm(position)), 1.0)) + (y[0] - y[1])
        holes = int(np.count_nonzero((rays @ zenith < -np.sin(dip)) & (out["surface"] == 0)))
        found.note("holes", holes, "px", at_most=0)
        for name in ("normal", "radiance"):
            found.expect(bool(np.isfinite(out[name]).all()), f"{name} is not finite")
        found.expect(renderer.gpu.ctx.error == "GL_NO_ERROR", "an OpenGL error was left behind")
    scene.release()
    return found


KINDS: Mapping[str, Kind] = {
    "probe": Kind(_draw_probe, _check_probe, 3.0),
    "picture": Kind(_draw_picture, _check_picture, 1.0),
}
