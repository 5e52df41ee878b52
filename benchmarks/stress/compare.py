"""Stress suite compare: numbers of the GPU against float64, ten thousand a case. docs/numerical-stability.md is made of
its results.

Each kind asks the shaders' own functions at random places of random planets, and float64 (clouds: long double) at the
very places that single precision was given: what is counted is the arithmetic, not the rounding of a question.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import AtmosphereProbe
from ...engine.blocks.layout import zeros
from ...engine.waves import displacement, waves_of
from ...systems.clouds.layers import frames_at, write_noise
from ...systems.clouds.view_block import CloudViewBlock, cloud_view_uniforms
from ...systems.ocean.wave_probe import WaveQuestions
from ...systems.terrain.height import height_at_points
from ..evaluate import Evaluator
from ..exact import Real
from ..measure.air import scene_of
from ..measure.air_random import horizon_rays, random_sky
from ..measure.drawn import DrawnMesh, some
from ..measure.ground import NEAR_M, gpu_heights
from ..measure.waves import around
from ..reference.air import EARTH_BRUNETON, SMALL_PLANET
from ..reference.air_transmittance import transmittance
from ..session import Session
from .atmosphere import FEW_ORDERS
from .deviations import Deviations
from .draw import RADII_M, log_uniform, unit
from .ocean import NEAREST_SHARE, SEEN_LENGTHS, draw_sea, ocean_of
from .runner import Case, Found, Kind
from .scenes import build_camera, build_scene, draw_camera, draw_planet

Floats = NDArray[np.float64]

COUNT = 120
"""Of up to 10 000 numbers each, fewer where a camera sees less: a million in all."""
NUMBERS = 10_000
LEAST_HEIGHT_M, HEIGHT_SHARE = 1e-3, 1e-6
"""Promised of heights within a kilometre: a millimetre, or this share of the relief where it is more."""
WAVE_M = 1e-3
AIR = 1e-3
"""Of 99 rays in 100. Bands of large change high in the air, seen from space, take a few more than that: their lowest
point lies between two rows of the table, and both halves of the way have the same error."""
CLOUD_ULP = 8.0
"""Three products and two sums turn a place, a product and a sum move it: seven roundings of half a unit, each of at
most sqrt(3) times the largest coordinate."""


def _draw_heights(rng: np.random.Generator) -> Case:
    return {"scene": draw_planet(rng), "camera": draw_camera(rng, tele=False), "seed": int(rng.integers(2**31))}


def _check_heights(case: Case, session: Session) -> Found:
    """The height function with all its layers at vertices of a drawn selection: half of them near the camera."""
    found, rng = Found(), np.random.default_rng(case["seed"])
    scene = build_scene(case["scene"])
    with session.renderer(scene, (160, 90), "medium") as renderer:
        camera = build_camera(scene, case["camera"])
        renderer.render(camera)
        mesh = DrawnMesh.of(renderer)
        field: Any = scene.planet.height_field()
        near = mesh.within(renderer.camera_state(camera).position_m, NEAR_M)
        relief = field.highest_m - field.lowest_m
        limit_m = max(LEAST_HEIGHT_M, HEIGHT_SHARE * relief)
        for name, where, most in (("heights within 1 km", near, limit_m), ("heights anywhere", ~near, None)):
            chosen = some(where, rng, NUMBERS // 2)
            if not chosen.any():
                continue
            heights, feet = gpu_heights(renderer, mesh, chosen)
            true_m = height_at_points(feet, field.model)
            found.deviations[name] = Deviations.of(heights, true_m, "m", _spacing(true_m - mesh.anchor_height_m, 1.0))
            found.note(name, float(np.abs(heights - true_m).max()), "m", most)
    scene.release()
    return found


def _draw_waves(rng: np.random.Generator) -> Case:
    radius = log_uniform(rng, 1e4, 7e7)
    time_s = float(rng.choice([0.0, 1.0, 1e5, 1e8]))
    return {"radius_m": radius, "time_s": time_s, "seed": int(rng.integers(2**31)), **draw_sea(rng, radius)}


def _check_waves(case: Case, session: Session) -> Found:
    """Displacements of the sea around a place, all three coordinates."""
    found = Found()
    waves = waves_of(ocean_of(case), case["radius_m"])
    scope = session.gpu.scope("compare waves")
    try:
        questions = WaveQuestions(scope, waves, case["radius_m"])
        anchor = np.array(case["place"])
        shortest = min(w["wavelength_m"] for w in case["waves"])
        reach = min(1000.0, NEAREST_SHARE * case["radius_m"], SEEN_LENGTHS * shortest)
        v = around(anchor, waves.radius_m, np.random.default_rng(case["seed"]), NUMBERS // 3, reach)
        got = questions.ask(anchor, v, case["time_s"]).displacement_m
    finally:
        scope.release()
    true_m = displacement(waves, v, case["time_s"])
    most = float(np.abs(true_m).max())
    found.deviations["waves"] = Deviations.of(got, true_m, "m", _spacing(true_m, most))
    found.note("waves", float(np.abs(got - true_m).max()), "m", WAVE_M)
    return found


def _draw_air(rng: np.random.Generator) -> Case:
    return {"planet": str(rng.choice(["earth", "small"])), "seed": int(rng.integers(2**31))}


def _check_air(case: Case, session: Session) -> Found:
    """Transmittance to space from tables, at random views inside and outside of the air. Rays within 1.7e-4 rad of the
    horizon are left out, as in the promise: whether they meet the ground is a matter of bits."""
    found = Found()
    air = EARTH_BRUNETON if case["planet"] == "earth" else SMALL_PLANET
    questions = random_sky(air, NUMBERS // 3, case["seed"])
    positions, ways = questions.positions_m, questions.directions
    true = transmittance(air, positions, ways)
    scene = scene_of(air)
    with AtmosphereProbe(scene, session.gpu.ctx, "high", FEW_ORDERS) as probe:
        got = probe.transmittance(positions, ways)
    scene.release()
    same = ~horizon_rays(air, positions, ways)
    found.deviations["transmittance of air"] = Deviations.of(got[same], true[same], "", _spacing(true[same], 1.0))
    off = np.abs(got - true)[same]
    found.note("transmittance of air, 99 %", float(np.quantile(off, 0.99)), "", AIR)
    found.note("transmittance of air", float(off.max()))
    return found


def _draw_clouds(rng: np.random.Generator) -> Case:
    return {
        "radius_m": log_uniform(rng, *RADII_M),
        "anchor": unit(rng),
        "height_m": float(rng.uniform(0.0, 2e4)),
        "thickness_m": log_uniform(rng, 100.0, 2e4),
        "wind_m_s": float(rng.uniform(0.0, 100.0)),
        "time_s": float(rng.choice([0.0, 1.0, 1e5, 1e8])),
        "seed": int(rng.integers(2**31)),
    }


_PLACES = """
vec3 turned = cloud_turned(place), tilted = cloud_tilted(place);
broad = cloud_view.broad.origin + turned * cloud_view.broad.per_m;
wide = cloud_view.wide.origin + tilted * cloud_view.wide.per_m;
"""
"""The statements of clouds/density.glsl."""


def _check_clouds(case: Case, session: Session) -> Found:
    """Where in the repeating volumes of noise a place lies, up to 300 km from the anchor."""
    found, rng = Found(), np.random.default_rng(case["seed"])
    turn, tilt = frames_at(case["wind_m_s"], case["radius_m"], case["time_s"])
    anchor_m = np.array(case["anchor"]) * (case["radius_m"] + case["height_m"])
    block = zeros(CloudViewBlock)
    write_noise(block, turn, tilt, anchor_m, case["radius_m"], case["thickness_m"], 64, 32, 32, 64)
    count = NUMBERS // 6
    ways = rng.normal(size=(count, 3))
    place = ways / np.linalg.norm(ways, axis=1)[:, None] * (10.0 ** rng.uniform(0.0, 5.5, count))[:, None]
    place = place.astype(np.float32)
    scope = session.gpu.scope("compare clouds")
    try:
        blocks = cloud_view_uniforms(scope)
        blocks.write(block)
        with Evaluator(session.gpu, _PLACES, {"place": "vec3"}, {"broad": "vec3", "wide": "vec3"},
                       '#include "clouds/density.glsl"') as evaluate:  # fmt: skip
            got = evaluate(blocks.bind, place=place)
    finally:
        scope.release()
    for name, frame, per_m in (("broad", turn, block.broad.per_m), ("wide", tilt, block.wide.per_m)):
        at = (anchor_m.astype(Real) + place.astype(Real)) @ frame.T.astype(Real) * Real(per_m)
        off = np.asarray(got[name], Real) - at
        periods = (off - np.round(off)).astype(np.float64)
        largest = np.abs(place).max(axis=1, keepdims=True) * per_m + 1.0
        ulp = np.spacing(largest.astype(np.float32)).astype(np.float64) * np.ones((1, 3))
        found.deviations[f"cloud coordinates, {name}"] = Deviations(
            np.abs(periods / ulp).ravel(), np.abs(periods / per_m).ravel(), "m"
        )
        found.note(f"cloud coordinates, {name}", float(np.abs(periods / ulp).max()), "ulp", CLOUD_ULP)
    return found


def _spacing(values: Floats, least: float) -> Floats:
    """The distance of neighbouring single-precision numbers at values, none smaller than at `least`."""
    return np.spacing(np.maximum(np.abs(values), least).astype(np.float32)).astype(np.float64)


KINDS: Mapping[str, Kind] = {
    "heights": Kind(_draw_heights, _check_heights),
    "waves": Kind(_draw_waves, _check_waves),
    "air": Kind(_draw_air, _check_air),
    "clouds": Kind(_draw_clouds, _check_clouds),
}
