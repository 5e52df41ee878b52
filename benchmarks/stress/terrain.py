"""Stress suite terrain: random planets and cameras, whose ground is checked pixel by pixel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Ocean, Renderer
from ...engine.space import CameraState, pixel_rays
from ...engine.waves import waves_of
from ...systems.terrain.height import height_at_points
from .. import exact
from ..measure.drawn import DrawnMesh, some
from ..measure.ground import NEAR_M, gpu_heights
from ..session import Session
from .runner import Case, Found, Kind
from .scenes import build_camera, build_scene, draw_camera, draw_planet
from .terrain_cells import CELL_KINDS

LIMITS_PX = {"low": 4.0, "medium": 2.0, "high": 1.0}
"""Drawn ground, 99th percentile; what is promised at high, and the same for edges twice and three times as long."""

NEAREST_M = 2.0
"""Nearer ground is coarser than a pixel by intention: vertices are never closer than terrain.min_spacing_m."""

OUTPUTS = ("color", "radiance", "distance", "position", "normal", "surface")
GROUND, SEA = 1, 2

Floats = NDArray[np.float64]


def _draw(rng: np.random.Generator) -> Case:
    scene = draw_planet(rng)
    size = [[160, 90], [97, 61], [64, 128]][int(rng.integers(3))]
    return {
        "scene": scene,
        "camera": draw_camera(rng, tele=False),
        "size": size,
        "quality": str(rng.choice(["low", "medium", "high"])),
        "seed": int(rng.integers(2**31)),
    }


def _check(case: Case, session: Session) -> Found:
    """No NaN, no hole in the disc, drawn heights as the f64 twin has them, bit-equal pictures again."""
    found = Found()
    rng = np.random.default_rng(case["seed"])
    scene = build_scene(case["scene"])
    with session.renderer(scene, tuple(case["size"]), case["quality"]) as renderer:
        view = build_camera(scene, case["camera"])
        out = renderer.render(view, outputs=OUTPUTS)
        state = renderer.camera_state(view)
        check_outputs(found, out)
        found.expect(renderer.ctx.error == "GL_NO_ERROR", "an OpenGL error was left behind")
        check_holes(found, renderer, state, out)
        _check_picture(found, renderer, state, out, rng)
        _check_vertices(found, renderer, state, rng)
    scene.release()
    return found


def check_outputs(found: Found, out: Mapping[str, NDArray[Any]]) -> None:
    """What all outputs promise: finite where something was hit, the documented values where nothing was."""
    surface = out["surface"]
    hit = surface > 0
    found.expect(bool(np.isin(surface, (0, 1, 2, 3)).all()), "surface holds a number that means nothing")
    for name in ("radiance", "normal"):
        bad = int((~np.isfinite(out[name])).any(axis=-1).sum())
        found.expect(bad == 0, f"{name}: {bad} pixels are not finite")
    found.expect(bool((out["radiance"] >= 0.0).all()), "radiance: some pixels are negative")
    for name, right in (
        ("position", np.isfinite(out["position"]).all(axis=-1) == hit),
        ("distance", np.isfinite(out["distance"]) == hit),
        ("normal", (out["normal"] != 0.0).any(axis=-1) == hit),
    ):
        found.expect(bool(right.all()), f"{name}: {int((~right).sum())} pixels do not agree with surface")
    length = np.linalg.norm(out["normal"][hit].astype(np.float64), axis=-1)
    found.expect(bool((np.abs(length - 1.0) < 1e-3).all()), "normal: some are not of unit length")
    away = np.linalg.norm(out["position"][hit].astype(np.float64), axis=-1)
    found.expect(bool((np.abs(away - out["distance"][hit]) <= 1e-5 * away + 1e-6).all()),
                 "distance and position do not agree")  # fmt: skip


def check_holes(found: Found, renderer: Renderer, state: CameraState, out: Mapping[str, NDArray[Any]]) -> None:
    """A ray that meets the sphere below all ground has to hit something, however grazing: by two pixels or more."""
    planet = renderer.scene.planet
    field = planet.height_field()
    assert field is not None
    rays = pixel_rays(state, renderer.size)
    radius = planet.radius_m + field.lowest_m
    position = state.position_m
    ahead = -(rays @ position)
    nearest = np.sqrt(np.maximum((position @ position) - ahead * ahead, 0.0))
    pixel = max(
        (state.tan_top - state.tan_bottom) / renderer.size[1], (state.tan_right - state.tan_left) / renderer.size[0]
    )
    deep = (ahead > 0.0) & (nearest < radius - 2.0 * pixel * ahead - 1e-9 * ahead)
    if float(np.linalg.norm(position)) <= radius:
        return
    holes = deep & (out["surface"] == 0)
    found.note("holes in the disc", int(holes.sum()), "pixels")
    if holes.any():
        row, column = np.argwhere(holes)[0]
        found.expect(False, f"{int(holes.sum())} holes in the disc, the first at pixel ({column}, {row})")


def _check_picture(
    found: Found, renderer: Renderer, state: CameraState, out: Mapping[str, NDArray[Any]], rng: np.random.Generator
) -> None:
    """The drawn ground and sea against the true ones."""
    planet = renderer.scene.planet
    field = planet.height_field()
    assert field is not None
    levels: dict[int, Any] = {GROUND: field.height}
    slack_m = {GROUND: 0.0, SEA: 0.0}
    if planet.has(Ocean):
        slack_m[SEA] = waves_of(planet[Ocean], planet.radius_m).highest_m  # `stress ocean` looks at the waves
        levels[SEA] = lambda directions: np.full(len(directions), planet[Ocean].sea_level_m)
    for surface, name, limit_px in ((GROUND, "drawn ground", LIMITS_PX[renderer.quality]), (SEA, "sea level", 1.0)):
        shown = (out["surface"] == surface) & (out["distance"] > NEAREST_M)
        rows, columns = np.nonzero(shown)
        if not len(rows):
            continue
        chosen = rng.choice(len(rows), min(len(rows), 2000), replace=False)
        seen = out["position"][rows[chosen], columns[chosen]].astype(np.float64)
        point = state.position_m + seen
        distance = np.linalg.norm(point, axis=1)
        zenith = point / distance[:, None]
        off = levels[surface](zenith) - (distance - planet.radius_m)
        off = np.sign(off) * np.maximum(np.abs(off) - slack_m[surface], 0.0)
        # In pixels of the picture's middle: towards the sides of a wide picture a pixel is a smaller angle.
        angle = exact.angle_between(seen, seen + zenith * off[:, None]).astype(float)
        off_px = angle / state.pixel_rad(renderer.size[1])
        found.note(f"{name}, p99, {renderer.quality}", float(np.quantile(off_px, 0.99)), "px", limit_px)


def _check_vertices(found: Found, renderer: Renderer, state: CameraState, rng: np.random.Generator) -> None:
    """Vertices within 1 km against the f64 twin; none is NaN."""
    try:
        mesh = DrawnMesh.of(renderer)
    except RuntimeError:
        return  # nothing selected: covered by the holes
    finite = np.isfinite(mesh.offsets_m).all(axis=-1)
    found.expect(bool(finite.all()), f"{int((~finite).sum())} vertices are not finite")
    near = some(mesh.within(state.position_m, NEAR_M) & finite, rng, 4000)
    if near.any():
        field: Any = renderer.scene.planet.height_field()
        amplitude = field.highest_m - field.lowest_m
        heights, feet = gpu_heights(renderer, mesh, near)
        worst = float(np.abs(heights - height_at_points(feet, field.model)).max())
        found.note("heights within 1 km", worst * 1e3, "mm", max(1.0, 1e-6 * amplitude * 1e3))


KINDS: Mapping[str, Kind] = {"planet": Kind(_draw, _check), **CELL_KINDS}
