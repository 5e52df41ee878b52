"""Stress suite clouds: random layers on random planets; light that is finite, transmittance as float64 has it, and
pictures that run on across every boundary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, CloudProbe, Renderer, Scene
from ...quality import resolve_quality
from ..reference.air_medium import mie_phase
from ..reference.cloud_shells import Layer, cloud_transmittance
from ..session import Session
from .atmosphere import SMALL_TABLES, directions_from, draw_air
from .draw import RADII_M, log_uniform, unit
from .runner import Case, Found, Kind
from .scenes import build_scene

Floats = NDArray[np.float64]

EXTINCTIONS_PER_M = (1e-7, 10.0)
THINNEST_M, THICKEST_SHARE = 1.0, 0.5
"""Thickness of a layer: from a metre to this share of its air."""
MOST_HEIGHT_SHARE = 0.5
"""Of a planet's radius, for clouds that float in no air."""
TIMES_S = (0.0, 1.0, 1e5, 1e8)
METHODS = ("ours", "paper_2018", "paper_2019")
TRANSMITTANCE_LIMIT, PARABOLA_LIMIT = 1e-4, 1e-3
"""Promised of even shells, any ray. A parabola's integral along a ray that grazes a metre of cloud on a planet of
70 000 km is a difference of large numbers: three digits are left of single precision's seven."""
CROSSING_STEPS = 9
STEP_SHARE, STEP_DEPTH, BITS = 0.05, 0.005, 16
"""Steps across a boundary: no longer than these shares of a layer's thickness and of its free path, no shorter than so
many bits of a height in single precision."""
LEAST_COSINE = 0.05
KINK = 2.5
"""How many times larger than the largest beside it the step across a boundary may be. A ray's way through a shell that
it grazes goes with the square root of its height below the side: of the steps to 1 m, 2 m, ... the first is
1 / (sqrt 2 - 1) = 2.41 times the second, and nothing that is continuous has a sharper kink there."""
SMALL_CLOUDS = {
    f"clouds.{name}": value
    for name, value in {
        "fine_steps": 24, "step_growth": 0.01, "sun_steps": 2, "shape_texels": 32, "fibre_texels": 128,
        "rim_texels": 16, "map_texels": 256, "shadow_texels": 64, "shadow_steps": 2,
    }.items()
}  # fmt: skip


def draw_clouds(rng: np.random.Generator, radius_m: float, air_m: float | None) -> Case:
    """The table of a Clouds with up to three layers in all, anywhere in the air; they may overlap."""
    highest = MOST_HEIGHT_SHARE * radius_m if air_m is None else air_m
    first, *others = [_draw_layer(rng, highest) for _ in range(int(rng.choice([1, 1, 2, 3])))]
    return {**first, "layers": others}


def _draw_layer(rng: np.random.Generator, highest_m: float) -> Case:
    thickness = log_uniform(rng, min(THINNEST_M, THICKEST_SHARE * highest_m), THICKEST_SHARE * highest_m)
    base = float(rng.choice([0.0, rng.uniform(), rng.uniform(), 1.0])) * (highest_m - thickness)
    return {
        "base_m": base,
        "top_m": min(base + thickness, highest_m),
        "extinction_per_m": 0.0 if rng.random() < 0.05 else log_uniform(rng, *EXTINCTIONS_PER_M),
        "albedo": float(rng.choice([0.0, 0.5, 0.999, 1.0])),
        "asymmetry": float(rng.choice([-0.99, -0.5, 0.0, 0.6, 0.85, 0.99])),
        "height_profile": str(rng.choice(["parabola", "none"])),
        "density_model": "uniform",
    }


def _draw_scene(rng: np.random.Generator) -> Case:
    radius = log_uniform(rng, *RADII_M)
    scene: Case = {
        "planet": {"radius_m": radius},
        "sun": {"direction": unit(rng), "angular_radius_rad": float(rng.choice([1e-4, 0.004675, 0.05]))},
    }
    if rng.random() < 0.5:
        scene["atmosphere"] = draw_air(rng, radius)
    air = scene.get("atmosphere", {}).get("thickness_m")
    return {**scene, "clouds": draw_clouds(rng, radius, air)}


def layers_of(scene: Case) -> list[Case]:
    """All layers of a case's clouds, the component's own first."""
    return [scene["clouds"], *scene["clouds"]["layers"]]


def boundaries(scene: Case) -> list[float]:
    """Heights of all spheres at which something begins or ends."""
    edges = {0.0, *(layer[side] for layer in layers_of(scene) for side in ("base_m", "top_m"))}
    if "atmosphere" in scene:
        edges.add(scene["atmosphere"]["thickness_m"])
    return sorted(edges)


def questions(scene: Case, count: int, rng: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Positions, directions and suns (count, 3): on every boundary to a millimetre and to the last bit, between them,
    under the ground and far out; rays anywhere, up, down, level, and tangent to each sphere."""
    radius, edges = scene["planet"]["radius_m"], np.array(boundaries(scene))
    top = float(edges[-1])
    up = np.array([unit(rng) for _ in range(count)])
    near = rng.choice([0.0, 1e-3, -1e-3, 1e-4, -1e-4, np.spacing(radius), -np.spacing(radius)], count)
    on = rng.choice(edges, count) + near
    between = top * rng.uniform(0.0, 1.2, count)
    far = 10.0 ** rng.uniform(np.log10(top), np.log10(100.0 * (radius + top)), count)
    below = -radius * 10.0 ** rng.uniform(-6.0, -0.3, count)
    height = np.choose(rng.choice(4, count, p=(0.5, 0.25, 0.2, 0.05)), [on, between, far, below])
    positions = up * (radius + height)[:, None]
    directions = directions_from(rng, up, radius, height)
    tangent = rng.random(count) < 0.4
    sphere = rng.choice(edges, count) + rng.choice([0.0, 1e-3, -1e-3, 1.0, -1.0], count)
    tangent &= sphere <= height
    cosine = np.minimum((radius + sphere) / (radius + np.maximum(height, sphere)), 1.0)
    side = np.cross(up, directions)
    flat = np.linalg.norm(side, axis=1) < 1e-9
    side[flat] = np.cross(up[flat], up[flat][:, [1, 2, 0]] + np.array([0.3, 0.1, 0.2]))
    side /= np.linalg.norm(side, axis=1)[:, None]
    grazing = side * cosine[:, None] - up * np.sqrt((1.0 - cosine) * (1.0 + cosine))[:, None]
    directions = np.where(tangent[:, None], grazing, directions)
    return positions, directions, directions_from(rng, up, radius, height)


# -- the probe's march -------------------------------------------------------------------------------------------------


def _draw_probe(rng: np.random.Generator) -> Case:
    return {
        "scene": _draw_scene(rng),
        "seed": int(rng.integers(2**31)),
        "quality": str(rng.choice(["low", "high"])),
        "method": str(rng.choice(METHODS, p=[0.7, 0.15, 0.15])),
    }


def _scene_of(case: Case) -> Scene:
    scene = build_scene(case["scene"])
    scene.sun.irradiance = (1.0, 1.0, 1.0)
    return scene


def _brightest(scene: Case) -> float:
    """No droplet and no haze sends more than its phase function's peak towards the camera, whatever it was lit by; all
    orders together gather no more than all the light there is."""
    g = [layer["asymmetry"] for layer in layers_of(scene)]
    g += [scene["atmosphere"]["mie_asymmetry"]] if "atmosphere" in scene else []
    return 2.0 * (max(float(mie_phase(np.sign(a) or 1.0, a).max()) for a in g) * 2.0 + 1.0)


def _check_probe(case: Case, session: Session) -> Found:
    """Answers of all kinds are light; of homogeneous shells the transmittance is exact."""
    found = Found()
    scene, tables = _scene_of(case), case["scene"]
    p, d, s = questions(tables, 400, np.random.default_rng(case["seed"]))
    overrides = {**SMALL_TABLES, "clouds.method": case["method"]}
    with CloudProbe(scene, session.gpu.ctx, case["quality"], overrides) as probe:
        for orders, air in ((1, True), (None, True), (None, False)):
            light, through = probe.march(p, d, s, orders=orders, air=air)
            _in_range(found, f"radiance, orders {orders}, air {air}", light, _brightest(tables))
            _in_range(found, f"transmittance, orders {orders}, air {air}", through, 1.0)
        if case["method"] == "ours":
            # The march ends where no more than this comes through.
            left = np.exp(-resolve_quality(case["quality"])["clouds.deepest"])
            off = _from_exact(
                tables["planet"]["radius_m"], [_reference(one) for one in layers_of(tables)], p, d, through
            )
            curved = any(layer["height_profile"] == "parabola" for layer in layers_of(tables))
            name, limit = ("parabolas", PARABOLA_LIMIT) if curved else ("even layers", TRANSMITTANCE_LIMIT)
            found.note(f"transmittance of {name}, from exact", max(off - left, 0.0), "", limit)
        near = np.random.default_rng(case["seed"]).choice([0.0, 1e-3, 1.0, 1e3, 1e7], len(p))
        _in_range(found, "radiance over a distance", probe.march(p, d, s, near)[0], _brightest(tables))
    found.expect(session.gpu.ctx.error == "GL_NO_ERROR", "an OpenGL error was left behind")
    scene.release()
    return found


def _from_exact(radius_m: float, layers: list[Layer], p: Floats, d: Floats, got: Floats) -> float:
    """By how much transmittance is off. Heights and distances are in single precision, two of each for a way through a
    layer: within four bits of the highest of all, a ray may lie higher or lower and a layer be thicker or thinner. One
    that grazes dense cloud has any value then, and one that lies on the ground hits it or doesn't."""
    distance = np.linalg.norm(p, axis=1)
    up = p / distance[:, None]
    bit = 4.0 * float(np.spacing(np.float32(max(layer.top_m for layer in layers)))) + 2.0 * float(np.spacing(radius_m))
    good = (distance >= radius_m) & ((distance > radius_m + bit) | (np.abs((up * d).sum(axis=1)) > 1e-6))
    p, d, up, got = p[good], d[good], up[good], got[good]
    near = []
    for k in (-1.0, 0.0, 1.0):
        others = [replace(one, base_m=one.base_m - k * bit, top_m=one.top_m + k * bit) for one in layers]
        # A layer that is thinner than that keeps a sliver.
        others = [one if one.top_m > one.base_m else replace(one, top_m=one.base_m + 1e-9 * bit) for one in others]
        near += [cloud_transmittance(radius_m, others, p + j * bit * up, d) for j in (-1.0, 0.0, 1.0)]
    most, least = np.max(near, axis=0), np.min(near, axis=0)
    return float(np.maximum(got - most, least - got).max(initial=0.0))


def _reference(layer: Case) -> Layer:
    return Layer(
        layer["base_m"], layer["top_m"], layer["extinction_per_m"], layer["albedo"], layer["asymmetry"],
        layer["height_profile"] == "parabola",
    )  # fmt: skip


def _in_range(found: Found, what: str, values: Floats, most: float) -> None:
    finite = np.isfinite(values)
    found.expect(bool(finite.all()), f"{what}: {int((~finite).any(-1).sum())} answers are not finite")
    lowest, highest = float(np.where(finite, values, 0.0).min()), float(np.where(finite, values, 0.0).max())
    found.expect(lowest >= 0.0, f"{what}: some answers are negative, down to {lowest:.3g}")
    found.expect(highest <= most * (1.0 + 1e-5), f"{what}: expected at most {most:g}, found {highest:.4g}")


def _draw_crossing(rng: np.random.Generator) -> Case:
    case = _draw_probe(rng)
    return {**case, "scene": _told_apart(case["scene"]), "method": "ours", "boundary": float(rng.uniform())}


def _told_apart(scene: Case) -> Case:
    """The same scene; what single precision has no steps for is no question: a metre of dense cloud 8000 km up, where
    heights are half a metre apart. Layers get thicker and thinner in substance until it has."""
    bit = float(np.spacing(np.float32(boundaries(scene)[-1])))
    for layer in layers_of(scene):
        middle, half = 0.5 * (layer["base_m"] + layer["top_m"]), 0.5 * (layer["top_m"] - layer["base_m"])
        half = min(max(half, 0.5 * bit * BITS / STEP_SHARE), middle)
        layer["base_m"], layer["top_m"] = max(middle - half, 0.0), min(middle + half, boundaries(scene)[-1])
        layer["extinction_per_m"] = min(layer["extinction_per_m"], STEP_DEPTH / (BITS * bit))
    return scene


def crossing_heights(scene: Case, edge_m: float) -> Floats:
    """Heights across a boundary, the middle one on it. Steps of a metre, or of what is small against all that happens
    there: a share of the thinnest layer and of its free path."""
    thinnest = min(layer["top_m"] - layer["base_m"] for layer in layers_of(scene))
    densest = max(layer["extinction_per_m"] for layer in layers_of(scene))
    step = min(1.0, STEP_SHARE * thinnest, STEP_DEPTH / max(densest, 1e-9))
    return edge_m + step * np.arange(-(CROSSING_STEPS // 2), CROSSING_STEPS // 2 + 1, dtype=np.float64)


def _away_from_tangents(ups: Floats, ways: Floats, radius_m: float, height_m: float) -> NDArray[np.bool_]:
    """(N,) whether a ray neither lies level at its start, where a metre of height is a kilometre of cloud, nor touches
    the ground, which it hits or misses."""
    cosine = (ups * ways).sum(axis=1)
    perigee = (radius_m + height_m) * np.sqrt(1.0 - np.minimum(cosine * cosine, 1.0)) - radius_m
    return (np.abs(cosine) > LEAST_COSINE) & ((cosine > 0.0) | (np.abs(perigee) > 1e-3 * radius_m))


def _check_crossing(case: Case, session: Session) -> Found:
    """Light along fixed directions while their start goes up through a boundary, in steps of a metre at most."""
    found = Found()
    scene, tables = _scene_of(case), case["scene"]
    rng = np.random.default_rng(case["seed"])
    edges = boundaries(tables)[1:]
    edge = edges[int(case["boundary"] * len(edges))]
    up, count = np.array(unit(rng)), 60
    radius = tables["planet"]["radius_m"]
    level, ups = np.full(count, edge), np.repeat(up[None], count, axis=0)
    ways, suns = directions_from(rng, ups, radius, level), directions_from(rng, ups, radius, level)
    good = _away_from_tangents(ups, ways, radius, edge) & (np.abs((ups * suns).sum(axis=1)) > LEAST_COSINE)
    ups, ways, suns = ups[good], ways[good], suns[good]
    with CloudProbe(scene, session.gpu.ctx, case["quality"], SMALL_TABLES) as probe:
        seen = []
        for height in crossing_heights(tables, edge):
            light, through = probe.march(ups * (radius + height), ways, suns)
            seen.append(np.concatenate([light, through], axis=1))
    if len(ups):
        _expect_no_jump(found, np.array(seen), "light")
    scene.release()
    return found


def _expect_no_jump(found: Found, seen: Floats, what: str) -> None:
    """seen (heights, ...): the steps to and from the boundary are bounded by those beside them."""
    scale = max(float(np.abs(seen).max()), 1e-12)
    steps = np.abs(np.diff(seen, axis=0)).reshape(len(seen) - 1, -1).max(axis=1)
    middle = len(steps) // 2
    across, beside = float(steps[middle - 1 : middle + 1].max()), float(np.delete(steps, [middle - 1, middle]).max())
    # Below a thousandth of what there is to see, steps are rounding.
    excess = across / (KINK * beside + 1e-3 * scale)
    found.note(f"{what}: step across a boundary, of what is allowed", excess, "", 1.0)


# -- pictures ----------------------------------------------------------------------------------------------------------


def _weather(rng: np.random.Generator, scene: Case) -> Case:
    """The same scene, with weather in some of its layers."""
    for layer in layers_of(scene):
        layer["density_model"] = str(rng.choice(["weather", "weather", "uniform"]))
        layer["kind"] = str(rng.choice(["auto", "cumulus", "cirrus"]))
        layer["coverage"] = float(rng.choice([0.1, 0.6, 1.0]))
        layer["wind_speed_m_s"] = float(rng.choice([0.0, 12.0, 500.0]))
    return scene


def _draw_picture(rng: np.random.Generator) -> Case:
    return {
        "scene": _weather(rng, _draw_scene(rng)),
        "seed": int(rng.integers(2**31)),
        "settle": bool(rng.random() < 0.3),
        "method": str(rng.choice(METHODS, p=[0.7, 0.15, 0.15])),
    }


def _check_picture(case: Case, session: Session) -> Found:
    """A renderer from place to place and from time to time: every pixel is light, no OpenGL error."""
    found = Found()
    scene = build_scene(case["scene"])
    rng = np.random.default_rng(case["seed"])
    positions, directions, ups = questions(case["scene"], 10, rng)
    with _renderer(session, scene, case["method"]) as renderer:
        for number, (p, d, up) in enumerate(zip(positions, directions, ups, strict=True)):
            camera = Camera(p, d, up, fov_y_deg=float(rng.choice([1.0, 30.0, 60.0, 120.0])))
            time_s = float(rng.choice(TIMES_S))
            if number == 0 and case["settle"]:
                renderer.settle(camera, time_s=time_s)
            light = renderer.render(camera, time_s=time_s, outputs=("radiance",))["radiance"]
            height = float(np.linalg.norm(p) - case["scene"]["planet"]["radius_m"])
            bad = int((~np.isfinite(light)).any(axis=-1).sum())
            found.expect(bad == 0, f"camera {number} at {height:g} m: {bad} pixels are not finite")
            dark = int((light < 0.0).any(axis=-1).sum())
            found.expect(dark == 0, f"camera {number} at {height:g} m: {dark} pixels are negative")
            error = renderer.ctx.error
            found.expect(error == "GL_NO_ERROR", f"camera {number}: OpenGL error {error}")
    scene.release()
    return found


def _renderer(session: Session, scene: Scene, method: str = "ours") -> Any:
    return session.renderer(scene, (32, 18), "low", {**SMALL_TABLES, **SMALL_CLOUDS, "clouds.method": method})


def _draw_flight(rng: np.random.Generator) -> Case:
    scene = _weather(rng, _told_apart(_draw_scene(rng)))
    return {"scene": scene, "seed": int(rng.integers(2**31)), "boundary": float(rng.uniform())}


def _check_flight(case: Case, session: Session) -> Found:
    """Pictures from a camera that goes up through a boundary in steps of a metre at most."""
    found = Found()
    scene, tables = build_scene(case["scene"]), case["scene"]
    rng = np.random.default_rng(case["seed"])
    edges = boundaries(tables)[1:]
    edge = edges[int(case["boundary"] * len(edges))]
    radius = tables["planet"]["radius_m"]
    zenith = np.array(unit(rng))
    forward = directions_from(rng, zenith[None], radius, np.array([edge]))[0]
    with _renderer(session, scene) as renderer:
        seen = [
            _picture(renderer, Camera(zenith * (radius + height), forward, unit(rng), fov_y_deg=60.0))
            for height in crossing_heights(tables, edge)
        ]
    # Pixels at the rims of clouds flicker from sample to sample: the mean of the picture, and its rows.
    rows = np.array([np.concatenate([light.mean(axis=(0, 1))[None], light.mean(axis=1)]) for light in seen])
    _expect_no_jump(found, rows, "picture")
    scene.release()
    return found


def _picture(renderer: Renderer, camera: Camera) -> Floats:
    return renderer.render(camera, outputs=("radiance",))["radiance"].astype(np.float64)


def _draw_rays(rng: np.random.Generator) -> Case:
    return {"scene": _weather(rng, _draw_scene(rng)), "seed": int(rng.integers(2**31)), "method": "ours"}


def _check_rays(case: Case, session: Session) -> Found:
    """Answers of the probe that marches as pictures do, through weather and even layers: light, whatever is asked."""
    found = Found()
    scene, tables = _scene_of(case), case["scene"]
    rng = np.random.default_rng(case["seed"])
    p, d, s = questions(tables, 200, rng)
    overrides = {**SMALL_TABLES, **SMALL_CLOUDS}
    with CloudProbe(scene, session.gpu.ctx, "low", overrides, as_pictures=True) as probe:
        for orders, air in ((1, False), (None, True)):
            time_s, wide = float(rng.choice(TIMES_S)), float(rng.choice([0.0, 1e-6, 1e-3, 1.0]))
            light, through = probe.march(p, d, s, orders=orders, air=air, time_s=time_s, pixel_rad=wide)
            _in_range(found, f"radiance, orders {orders}, air {air}", light, _brightest(tables))
            _in_range(found, f"transmittance, orders {orders}, air {air}", through, 1.0)
    found.expect(session.gpu.ctx.error == "GL_NO_ERROR", "an OpenGL error was left behind")
    scene.release()
    return found


KINDS: Mapping[str, Kind] = {
    "probe": Kind(_draw_probe, _check_probe, 3.0),
    "crossing": Kind(_draw_crossing, _check_crossing, 2.0),
    "picture": Kind(_draw_picture, _check_picture, 2.0),
    "flight": Kind(_draw_flight, _check_flight, 1.0),
    "rays": Kind(_draw_rays, _check_rays, 1.0),
}
