"""Stress suite terrain: random planets and cameras, whose ground is checked pixel by pixel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Renderer
from ...engine.space import CameraState, pixel_rays
from ...systems.terrain.height import height_at_points
from ..measure.drawn import DrawnMesh, some
from ..measure.ground import NEAR_M, gpu_heights, on_screen_px
from ..session import Session
from .runner import Case, Found, Kind
from .scenes import build_camera, build_scene, draw_camera, draw_planet

OUTPUTS = ("color", "radiance", "distance", "position", "normal", "surface")
GROUND, SEA = 1, 2

Floats = NDArray[np.float64]


def _draw(rng: np.random.Generator) -> Case:
    scene = draw_planet(rng)
    size = [[160, 90], [97, 61], [64, 128]][int(rng.integers(3))]
    return {
        "scene": scene,
        "camera": draw_camera(rng, scene),
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
        _check_holes(found, renderer, state, out)
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


def _check_holes(found: Found, renderer: Renderer, state: CameraState, out: Mapping[str, NDArray[Any]]) -> None:
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
    """The drawn ground against the true one on screen, and the sea's level."""
    planet = renderer.scene.planet
    field = planet.height_field()
    assert field is not None
    rows, columns = np.nonzero(out["surface"] == GROUND)
    if len(rows):
        chosen = rng.choice(len(rows), min(len(rows), 2000), replace=False)
        seen = out["position"][rows[chosen], columns[chosen]].astype(np.float64)
        point = state.position_m + seen
        distance = np.linalg.norm(point, axis=1)
        zenith = point / distance[:, None]
        off = field.height(zenith) - (distance - planet.radius_m)
        moved = on_screen_px(state, seen, seen + zenith * off[:, None], renderer.size)
        found.note(f"drawn ground, p99, {renderer.quality}", float(np.quantile(moved, 0.99)), "px", 6.0)
    rows, columns = np.nonzero(out["surface"] == SEA)
    if len(rows):
        from ... import Ocean

        seen = out["position"][rows, columns].astype(np.float64)
        level = planet[Ocean].sea_level_m
        off = level - (np.linalg.norm(state.position_m + seen, axis=1) - planet.radius_m)
        zenith = state.position_m + seen
        zenith /= np.linalg.norm(zenith, axis=1, keepdims=True)
        moved = on_screen_px(state, seen, seen + zenith * off[:, None], renderer.size)
        found.note(f"sea level, p99, {renderer.quality}", float(np.quantile(moved, 0.99)), "px", 1.0)


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


KINDS: Mapping[str, Kind] = {"planet": Kind(_draw, _check)}
