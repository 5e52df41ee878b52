"""Small planets with clouds, and what the tests of the clouds ask of a renderer."""

from __future__ import annotations

from typing import Any

import numpy as np
from air_kit import TINY, bare
from numpy.typing import NDArray

import planetfall as pf
from planetfall.components import Atmosphere, Clouds

COARSE = {
    f"clouds.{name}": value
    for name, value in {
        "picture_px": 1, "stride": 1, "fine_steps": 32, "step_growth": 0.01, "sun_steps": 2, "shape_texels": 32,
        "fibre_texels": 128, "rim_texels": 16, "map_texels": 256, "shadow_texels": 64, "shadow_steps": 4,
    }.items()
}  # fmt: skip


def cloudy(clouds: Clouds | None = None, air: bool = True, radius_m: float = 6.36e6, **more: Any) -> pf.Scene:
    """A planet without ground. more: fields of the clouds."""
    scene = bare(Atmosphere(thickness_m=min(6e4, 0.1 * radius_m)), radius_m)
    if not air:
        scene.planet.remove(Atmosphere)
    scene.planet.add(clouds or Clouds(**more))
    return scene


def renderer_of(scene: pf.Scene, size: tuple[int, int] = (32, 18), **overrides: Any) -> pf.Renderer:
    """Quality low with the smallest tables, light at the wavelengths of the components' numbers; overrides: knobs of
    clouds."""
    given = {f"clouds.{key}": value for key, value in overrides.items()}
    return pf.Renderer(scene, size, "low", {**TINY, **COARSE, "light.wavelengths": "given", **given})


def texture(renderer: pf.Renderer, name: str) -> NDArray[np.float64]:
    """A float texture of the frame graph, (rows, columns, components); arrays: layers first."""
    held = renderer.graph.resource(name)
    kind = np.float16 if held.dtype == "f2" else np.float32
    shape = (*reversed(held.size), held.components)
    if len(held.size) == 2 and getattr(held, "layers", 1) > 1:
        shape = (held.layers, *shape)
    with renderer.current():
        return np.frombuffer(held.read(), kind).reshape(shape).astype(np.float64)


def opacity(renderer: pf.Renderer, camera: pf.Camera, **more: Any) -> NDArray[np.float64]:
    """What the clouds take of each pixel, (rows, columns), bottom row first."""
    renderer.render(camera, **more)
    return 1.0 - texture(renderer, "clouds.full")[..., 3]


def ran(renderer: pf.Renderer) -> set[str]:
    """Passes of the clouds that ran in the last frame."""
    return {p.name for p in renderer.passes() if p.ran and p.name.startswith("clouds.")}
