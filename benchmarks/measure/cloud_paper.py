"""Ours against the printed method on the same clouds: the printed density texture, marched through by both."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import ASSETS, Atmosphere, Clouds, Planet, Renderer, Scene, View
from ...quality import resolve_quality
from ...systems.clouds.paper import LARGE_STEP, STEPS
from ...systems.clouds.paper_volume import PaperVolume

__all__ = ["autocorrelation", "processor_times", "renderer_of", "tile_pitch_px", "variants"]

Floats = NDArray[np.float64]

BASE_M, TOP_M, EXTINCTION_PER_M, COVERAGE = 1500.0, 4000.0, 0.02, 0.5
TILE_M = 6.4 * (TOP_M - BASE_M)
"""The width at which our own shape volume repeats over a layer of that thickness: its place is then the tile's."""
TEXELS = 256
_UNIT = 30
_TILED = """
layout(binding = %d) uniform sampler3D u_bench_tile;

float cloud_density_near(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims, out float near) {
    float tex = textureLod(u_bench_tile, cloud_view.broad.xyz + cloud_turned(place) * cloud_view.broad.w, 0.0).r;
    near = tex < 0.0 ? %r : -1.0;
    float s = 2.0 * share - 1.0;
    return max(tex, 0.0) * (1.0 - s * s);
}
"""


def _density() -> str:
    """clouds/density.glsl with the printed texture in place of the weather's noise: empty cells are a large step away."""
    text = (ASSETS / "shaders" / "clouds" / "density.glsl").read_text()
    head = "\nfloat cloud_density(int layer"
    if text.count(head) != 1 or text.count("\nfloat cloud_density_near(") != 1:
        raise RuntimeError("clouds/density.glsl has other functions than this bench knows")
    text = text.replace("\nfloat cloud_density_near(", "\nfloat cloud_density_woven(")
    large = LARGE_STEP / STEPS * (TOP_M - BASE_M)
    return text.replace(head, _TILED % (_UNIT, large / (0.1 * TILE_M)) + head)


def scene_of(method: str) -> Scene:
    """Earth's air and one layer of cloud, nothing else. Ours is covered all over: the texture alone has gaps."""
    clouds = Clouds(
        base_m=BASE_M, top_m=TOP_M, extinction_per_m=EXTINCTION_PER_M, tile_width_m=TILE_M, method=method,
        coverage=1.0 if method == "ours" else COVERAGE,
    )  # fmt: skip
    return Scene("tiled clouds", {"planet": Planet(), "atmosphere": Atmosphere(), "clouds": clouds})


@contextlib.contextmanager
def renderer_of(
    size: tuple[int, int], method: str | None, quality: str = "low", tiled: bool = True, **knobs: Any
) -> Iterator[Renderer]:
    """A renderer of `scene_of`; method None: without the clouds. quality: of the clouds, all else is as at `low`.
    tiled: ours on the printed texture, else with its own weather. knobs: of the clouds."""
    scene = scene_of(method or "ours")
    if method is None:
        scene.planet.remove(Clouds)
    elif not tiled:
        scene.planet[Clouds].coverage = 0.6
    of_clouds = {k: v for k, v in resolve_quality(quality).items() if k.startswith("clouds.") and k != "clouds.method"}
    of_clouds["clouds.shape_texels"] = TEXELS if method != "ours" else 128
    overrides = {**of_clouds, **{f"clouds.{key}": value for key, value in knobs.items()}}
    renderer = Renderer(scene, size, "low", overrides)
    try:
        if method == "ours" and tiled:
            renderer.gpu.shaders.add_virtual("clouds/density.glsl", _density())
            scope = renderer.gpu.scope("bench")
            large = LARGE_STEP / STEPS * (TOP_M - BASE_M)
            volume = PaperVolume(scope, TEXELS, COVERAGE, TILE_M, TOP_M - BASE_M, large)
            volume.step(1e9)
            volume.texture.use(_UNIT)
        yield renderer
    finally:
        renderer.release()


def variants() -> dict[str, tuple[str | None, str]]:
    """Name -> method and quality of the clouds."""
    return {"paper_2018": ("paper_2018", "paper"), "low": ("ours", "low"), "high": ("ours", "high"), "none": (None, "low")}


def processor_times(frames: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median processor time of each, in ms, all threads together; interleaved, so that a busy machine slows all alike."""
    found: dict[str, list[float]] = {name: [] for name in frames}
    for turn in range(-1, rounds):
        for name, run in frames.items():
            before = time.process_time()
            run()
            if turn >= 0:
                found[name].append(1e3 * (time.process_time() - before))
    return {name: float(np.median(times)) for name, times in found.items()}


def autocorrelation(picture: Floats, shift_px: float) -> float:
    """Largest correlation of a picture (rows, columns) with itself, shifted by a width in pixels in any of the four
    directions of its sides, up to half a pixel of it off. What is smooth over three times that width is taken off
    first: a disc is bright in its middle, which is no repeat."""
    wide = max(int(round(3.0 * shift_px)), 3)
    fine = picture - _blurred(picture, wide)
    found = []
    for k in {int(np.floor(shift_px)), int(np.ceil(shift_px))}:
        for a, b in ((fine[k:], fine[:-k]), (fine[:, k:], fine[:, :-k])):
            found.append(float(np.corrcoef(a.ravel(), b.ravel())[0, 1]))
    return max(found)


def _blurred(picture: Floats, width: int) -> Floats:
    kernel = np.ones(width) / width
    for axis in (0, 1):
        picture = np.apply_along_axis(lambda row: np.convolve(np.pad(row, width, "edge"), kernel, "same"), axis, picture)
        cut = [slice(None)] * 2
        cut[axis] = slice(width, -width)
        picture = picture[tuple(cut)]
    return picture


def tile_pitch_px(width_m: float, view: View, size: tuple[int, int], distance_m: float) -> float:
    """Pixels across a width, seen from so far away in the middle of a view."""
    return width_m / distance_m / (2.0 * np.tan(np.radians(0.5 * view.camera.fov_y_deg)) / size[1])
