"""Stress suite atmosphere: random air, cameras and suns; nothing that is NaN, infinite or negative, and the float64
reference where air is physical."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import AtmosphereProbe, Camera
from ..measure.air_random import horizon_rays
from ..reference.air_medium import AirParameters, mie_phase
from ..reference.air_single import sky_single
from ..reference.air_transmittance import transmittance
from ..session import Session
from .draw import RADII_M, log_uniform, unit
from .runner import Case, Found, Kind
from .scenes import build_scene, draw_planet

Floats = NDArray[np.float64]

THICKNESS_SHARES = (1e-4, 1.0)
OPTICAL_DEPTHS = (1e-6, 50.0)
ASYMMETRIES = (-0.9, 0.95)
FARTHEST_M = 1e9
SMALL_TABLES = {
    f"atmosphere.{name}": value
    for name, value in {
        "columns": 12, "rows": 12, "slices": 6, "altitudes": 12, "sun_heights": 24, "directions": 4, "march": 5,
        "degree": 2, "orders": 4,
    }.items()
}  # fmt: skip
"""What is promised here holds for tables of any size."""
FEW_ORDERS = {"atmosphere.orders": 1, "atmosphere.directions": 4, "atmosphere.sun_heights": 8}
"""Nothing of these is in transmittance and single scattering."""
PHYSICAL = {"share": (1e-3, 0.1), "depth": (1e-4, 2.0), "scale": (0.03, 0.3), "asymmetry": (-0.5, 0.85)}
"""Of the cases that are compared: planets with air as one knows them, thin enough for a sky."""
TRANSMITTANCE_LIMIT = 1e-3
SINGLE_LIMIT = 0.02
"""At quality high, the 90th percentile of a case's rays, weighed by the brightness of its own rays: air is anything
here, and the promised errors are those of one air."""


def draw_air(rng: np.random.Generator, radius_m: float, physical: bool = False) -> Case:
    """The table of an Atmosphere. Optical depths are vertical ones, per wavelength."""
    share = PHYSICAL["share"] if physical else THICKNESS_SHARES
    depths = PHYSICAL["depth"] if physical else OPTICAL_DEPTHS
    scales = PHYSICAL["scale"] if physical else (1e-3, 10.0)
    asymmetries = PHYSICAL["asymmetry"] if physical else ASYMMETRIES
    thickness = radius_m * log_uniform(rng, *share)
    scale = [max(thickness * log_uniform(rng, *scales), 1e-3) for _ in "gh"]
    center, half = (
        thickness * float(rng.uniform(-0.2, 1.2)),
        thickness * log_uniform(rng, 0.1 if physical else 1e-2, 1.0),
    )
    columns = [h * -np.expm1(-thickness / h) for h in scale]
    below, above = max(center, 0.0), max(thickness - center, 0.0)
    tent = sum(side - 0.5 * side * side / half for side in (min(below, half), min(above, half)))

    def coefficients(column: float) -> list[float]:
        middle = log_uniform(rng, *depths) / max(column, 1e-9 * thickness)
        return [min(float(middle * f), 1e4) for f in rng.uniform(0.2, 1.0, 3)]

    extinction = coefficients(columns[1])
    albedo = float(rng.choice([0.0, 0.5, 0.9, 1.0]))
    return {
        "thickness_m": thickness,
        "rayleigh_scale_height_m": scale[0],
        "rayleigh_scattering_per_m": coefficients(columns[0]) if physical or rng.random() < 0.9 else [0.0] * 3,
        "mie_scale_height_m": scale[1],
        "mie_extinction_per_m": extinction,
        "mie_scattering_per_m": [albedo * k for k in extinction],
        "mie_asymmetry": float(rng.uniform(*asymmetries)) if rng.random() < 0.8 else float(rng.choice(asymmetries)),
        "absorption_per_m": coefficients(tent) if rng.random() < 0.7 else [0.0] * 3,
        "absorption_center_m": center,
        "absorption_half_width_m": half,
        "ground_albedo": [float(a) for a in rng.choice([0.0, 0.1, 0.5, 1.0], 3)],
    }


def _draw_scene(rng: np.random.Generator, physical: bool = False) -> Case:
    radius = log_uniform(rng, *RADII_M)
    sun = {"direction": unit(rng), "angular_radius_rad": float(rng.choice([1e-4, 0.004675, 0.05]))}
    return {"planet": {"radius_m": radius}, "atmosphere": draw_air(rng, radius, physical), "sun": sun}


def _draw_probe(rng: np.random.Generator) -> Case:
    return {"scene": _draw_scene(rng), "seed": int(rng.integers(2**31))}


def _draw_truth(rng: np.random.Generator) -> Case:
    return {"scene": _draw_scene(rng, physical=True), "seed": int(rng.integers(2**31))}


def _check_probe(case: Case, session: Session) -> Found:
    """Every call on questions of all kinds: finite, not negative, and not brighter than light can get."""
    found = Found()
    scene = build_scene({**case["scene"]})
    scene.sun.irradiance = (1.0, 1.0, 1.0)
    air = parameters(case["scene"])
    p, d, s, ups = questions(air, 400, np.random.default_rng(case["seed"]))
    # No order gathers more than all the light there is; straight ahead a phase function of its own peak.
    peak = float(mie_phase(1.0, air.mie_asymmetry).max() + mie_phase(-1.0, air.mie_asymmetry).max())
    brightest = 2.0 * (peak + 1.0)
    with AtmosphereProbe(scene, session.gpu.ctx, "low", SMALL_TABLES) as probe:
        far = np.random.default_rng(case["seed"]).choice([0.0, 1e-3, 1.0, 1e3, 1e7, 1e9], len(p))
        _in_range(found, "transmittance to space", probe.transmittance(p, d), 1.0)
        _in_range(found, "transmittance over a distance", probe.transmittance(p, d, far), 1.0)
        for orders in (1, 2, None):
            _in_range(found, f"radiance, orders {orders}", probe.sky_radiance(p, d, s, orders), brightest)
        for part in ("rayleigh", "mie"):
            _in_range(found, f"radiance, {part}", probe.sky_radiance(p, d, s, 1, part), 2.0)
        light, through = probe.in_scattering(p, p + d * far[:, None], s)
        _in_range(found, "in-scattering", light, brightest)
        _in_range(found, "in-scattering's transmittance", through, 1.0)
        direct, sky = probe.irradiance(p, ups, s)
        _in_range(found, "direct irradiance", direct, 1.0)
        _in_range(found, "sky irradiance", sky, 4.0)
    found.expect(session.gpu.ctx.error == "GL_NO_ERROR", "an OpenGL error was left behind")
    scene.release()
    return found


def _in_range(found: Found, what: str, values: Floats, most: float) -> None:
    finite = np.isfinite(values)
    found.expect(bool(finite.all()), f"{what}: {int((~finite).any(1).sum())} answers are not finite")
    lowest, highest = float(np.where(finite, values, 0.0).min()), float(np.where(finite, values, 0.0).max())
    found.expect(lowest >= 0.0, f"{what}: some answers are negative, down to {lowest:.3g}")
    found.expect(highest <= most * (1.0 + 1e-5), f"{what}: expected at most {most:g}, found {highest:.4g}")


def _check_truth(case: Case, session: Session) -> Found:
    """A few rays against the reference."""
    found = Found()
    scene = build_scene({**case["scene"]})
    scene.sun.irradiance = (1.0, 1.0, 1.0)
    air = parameters(case["scene"])
    p, d, s, _ = questions(air, 160, np.random.default_rng(case["seed"]))
    # Below the floor and beyond any picture, conventions are the renderer's own; there _check_probe is enough.
    height = np.linalg.norm(p, axis=1) - air.radius_m
    good = (height >= 0.0) & (height < 1e3 * air.radius_m)
    p, d, s = p[good], d[good], s[good]
    truth = sky_single(air, p, d, s, rtol=1e-6)
    with AtmosphereProbe(scene, session.gpu.ctx, "high", FEW_ORDERS) as probe:
        through = np.abs(probe.transmittance(p, d) - transmittance(air, p, d))
        light = np.abs(probe.sky_radiance(p, d, s, 1) - truth.radiance)
    grazing = horizon_rays(air, p, d)
    found.note("transmittance, from exact", through[~grazing].max(initial=0.0), "", TRANSMITTANCE_LIMIT)
    found.note("transmittance, within 0.01 degrees of the horizon", through[grazing].max(initial=0.0))
    bright = np.median(truth.radiance[truth.radiance > 0.0]) if (truth.radiance > 0.0).any() else 1e-9
    wrel = (light / (truth.radiance + 0.1 * bright)).max(axis=1)[~grazing]
    found.note("single scattering, weighed, p90", np.percentile(wrel, 90), "", SINGLE_LIMIT)
    found.note("single scattering, weighed, worst", wrel.max())
    scene.release()
    return found


def parameters(scene: Case) -> AirParameters:
    """The reference's view of a case."""
    air: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in scene["atmosphere"].items()}
    return AirParameters(
        radius_m=scene["planet"]["radius_m"], sun_angular_radius_rad=scene["sun"]["angular_radius_rad"], **air
    )


def questions(air: AirParameters, count: int, rng: np.random.Generator) -> tuple[Floats, Floats, Floats, Floats]:
    """Positions, directions, suns and normals (count, 3): on boundaries and beside them by a step of float32 or
    float64, under the floor, in the air, far out; straight up, down, level, at the horizon; suns anywhere."""
    up = np.array([unit(rng) for _ in range(count)])
    top, radius = air.thickness_m, air.radius_m
    steps = np.array([0.0, np.spacing(radius), -np.spacing(radius), 1e-7 * radius, -1e-7 * radius])
    edges = np.array([0.0, top])[rng.integers(2, size=count)] + rng.choice(steps, count)
    inside = top * 10.0 ** rng.uniform(-6.0, 0.0, count)
    outside = (radius + top) * 10.0 ** rng.uniform(-6.0, 0.0, count) + top
    far = 10.0 ** rng.uniform(np.log10(top), np.log10(max(FARTHEST_M, 10.0 * top)), count)
    below = -radius * 10.0 ** rng.uniform(-6.0, -0.3, count)
    height = np.choose(rng.choice(5, count, p=(0.3, 0.35, 0.15, 0.1, 0.1)), [edges, inside, outside, far, below])
    return (
        up * (radius + height)[:, None],
        directions_from(rng, up, radius, height),
        directions_from(rng, up, radius, height),
        directions_from(rng, up, radius, height),
    )


def directions_from(rng: np.random.Generator, up: Floats, radius: float, height: Floats) -> Floats:
    """Directions: a third anywhere, the others at angles to the zenith that count."""
    count = len(up)
    anywhere = np.array([unit(rng) for _ in range(count)])
    side = np.cross(up, anywhere)
    flat = np.linalg.norm(side, axis=1) < 1e-6
    side[flat] = np.cross(up[flat], up[flat][:, [1, 2, 0]] + np.array([0.3, 0.1, 0.2]))
    side /= np.linalg.norm(side, axis=1)[:, None]
    h = np.maximum(height, 0.0)
    dip = np.arctan2(np.sqrt(h * (2.0 * radius + h)), radius)
    offset = rng.choice([0.0, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3, 0.05, -0.05], count)
    zero, level = np.zeros(count), np.full(count, 0.5 * np.pi)
    special = np.choose(rng.integers(5, size=count), [zero, zero + np.pi, level, level + dip, level + dip + offset])
    exact = up * np.cos(special)[:, None] + side * np.sin(special)[:, None]
    # Cosines of exactly -1, 0 and 1, not what pi rounds to.
    exact = np.where((special == 0.0)[:, None], up, np.where((special == np.pi)[:, None], -up, exact))
    return np.where((rng.random(count) < 0.35)[:, None], anywhere, exact)


# -- pictures ----------------------------------------------------------------------------------------------------------


def _draw_picture(rng: np.random.Generator) -> Case:
    scene = _draw_scene(rng)
    if rng.random() < 0.3:
        land = draw_planet(rng, (scene["planet"]["radius_m"], scene["planet"]["radius_m"] * (1.0 + 1e-9)))
        scene = {**scene, **{key: value for key, value in land.items() if key != "planet"}}
    return {"scene": scene, "seed": int(rng.integers(2**31)), "settle": bool(rng.random() < 0.3)}


def _check_picture(case: Case, session: Session) -> Found:
    """A renderer from place to place: every pixel finite and not negative, no OpenGL error."""
    found = Found()
    scene = build_scene(case["scene"])
    air = parameters(case["scene"])
    rng = np.random.default_rng(case["seed"])
    positions, directions, ups, _ = questions(air, 12, rng)
    if "terrain" in case["scene"]:
        # Cameras in the ground are lifted out of it, which is another suite's business.
        outward = positions / np.linalg.norm(positions, axis=1)[:, None]
        lowest = air.radius_m + case["scene"]["terrain"]["highest_m"] * 1.2
        positions = outward * np.maximum(np.linalg.norm(positions, axis=1), lowest)[:, None]
    with session.renderer(scene, (32, 18), "low", SMALL_TABLES) as renderer:
        for number, (p, d, up) in enumerate(zip(positions, directions, ups, strict=True)):
            fov = float(rng.choice([1.0, 30.0, 60.0, 120.0]))
            camera = Camera(p, d, up, fov_y_deg=fov)
            if number == 0 and case["settle"]:
                renderer.settle(camera)
            radiance = renderer.render(camera, outputs=("radiance",))["radiance"]
            height = float(np.linalg.norm(p) - air.radius_m)
            bad = int((~np.isfinite(radiance)).any(axis=-1).sum())
            found.expect(bad == 0, f"camera {number} at {height:g} m: {bad} pixels are not finite")
            dark = int((radiance < 0.0).any(axis=-1).sum())
            found.expect(dark == 0, f"camera {number} at {height:g} m: {dark} pixels are negative")
            error = renderer.ctx.error
            found.expect(error == "GL_NO_ERROR", f"camera {number}: OpenGL error {error}")
    scene.release()
    return found


KINDS: Mapping[str, Kind] = {
    "probe": Kind(_draw_probe, _check_probe, 3.0),
    "truth": Kind(_draw_truth, _check_truth, 1.0),
    "picture": Kind(_draw_picture, _check_picture, 2.0),
}
