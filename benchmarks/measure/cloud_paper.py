"""Ours against the printed method on the same clouds: the printed density texture, marched through by both."""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from ... import ASSETS, Atmosphere, Camera, Clouds, Planet, Renderer, Scene, Sun, View
from ...quality import resolve_quality
from ...systems.clouds.paper import LARGE_STEP, STEPS
from ...systems.clouds.paper_volume import PaperVolume
from .flip import flip

__all__ = ["TILE_M", "VARIANTS", "against_printed", "renderer_of", "repeats", "seen_from_space"]

Floats = NDArray[np.float64]

BASE_M, TOP_M, EXTINCTION_PER_M, COVERAGE = 1500.0, 4000.0, 0.02, 0.5
TILE_M = 6.4 * (TOP_M - BASE_M)
"""The width at which our own shape volume repeats over a layer of that thickness: its place is then the tile's."""
TEXELS = 256
_TILE_AT = 30  # a texture unit above all that the registry has
_TILED = """
layout(binding = %d) uniform sampler3D u_bench_tile;

float cloud_density(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims) {
    float tex = textureLod(u_bench_tile, cloud_view.broad.origin + cloud_turned(place) * cloud_view.broad.per_m, 0.0).r;
    float s = 2.0 * share - 1.0;
    return max(tex, 0.0) * (1.0 - s * s);
}
CloudNoise cloud_noise(int layer, vec3 place, float share, CloudWeather w, float footprint_m) {
    CloudNoise n;
    n.excess = cloud_density(layer, place, share, w, footprint_m, 0);
    return n;
}
float cloud_gap(int layer, CloudNoise n, float footprint_m) { return n.excess > 0.0 ? 0.0 : 1e-6; }
float cloud_rimmed(int layer, CloudNoise n, float share, float footprint_m, int rims) { return n.excess; }
float cloud_ceiling(int layer, CloudWeather a, CloudWeather b) { return 1.0; }
float cloud_own_column(int layer, CloudNoise n) {
    CloudViewLayer shell = cloud_view.layers[layer];
    return CLOUD_MEAN_FILL * shell.extinction_per_m * (shell.top_m - shell.base_m);
}
"""
_OURS = {"density": "float", "noise": "CloudNoise", "gap": "float", "rimmed": "float", "ceiling": "float",
         "own_column": "float"}  # fmt: skip


def _density() -> str:
    """clouds/density.glsl with the printed texture for noise."""
    text = (ASSETS / "shaders" / "clouds" / "density.glsl").read_text()
    for name, kind in _OURS.items():
        if text.count(f"\n{kind} cloud_{name}(int layer, ") != 1:
            raise RuntimeError("clouds/density.glsl has other functions than this bench knows")
        text = text.replace(f"cloud_{name}(", f"woven_{name}(")
    return text + _TILED % _TILE_AT


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
    if method != "ours":
        of_clouds["clouds.shape_texels"] = TEXELS
    overrides = {**of_clouds, **{f"clouds.{key}": value for key, value in knobs.items()}}
    renderer = Renderer(scene, size, "low", overrides)
    try:
        if method == "ours" and tiled:
            renderer.gpu.shaders.add_virtual("clouds/density.glsl", _density())
            scope = renderer.gpu.scope("bench")
            large = LARGE_STEP / STEPS * (TOP_M - BASE_M)
            volume = PaperVolume(scope, TEXELS, COVERAGE, TILE_M, TOP_M - BASE_M, large)
            volume.step(1e9)
            volume.texture.use(_TILE_AT)
        yield renderer
    finally:
        renderer.release()


VARIANTS: Mapping[str, tuple[str, str] | None] = {
    "paper_2018": ("paper_2018", "paper"),
    "paper_2019": ("paper_2019", "paper"),
    "low": ("ours", "low"),
    "high": ("ours", "high"),
    "none": None,
}
"""Method and quality of what is compared; None: no clouds."""


class CloudCost(NamedTuple):
    """error: mean FLIP to our reference, settled; at_once: of the first picture. ms: processor time of a frame in
    flight less that of the same frame without clouds; frame_ms: all of it."""

    error: float
    at_once: float
    ms: float
    frame_ms: float


def against_printed(
    views: Mapping[str, View], size: tuple[int, int], samples: int, rounds: int
) -> dict[tuple[str, str], CloudCost]:
    """By variant and view. samples: of the reference's pixels; rounds: timed frames."""
    truth = {}
    with renderer_of(size, "ours", "reference", stride=1, samples=samples) as renderer:
        for place, at in views.items():
            renderer.settle(at)
            truth[place] = renderer.render(at)["color"]
    found: dict[tuple[str, str], CloudCost] = {}
    with contextlib.ExitStack() as stack:
        renderers = {
            name: stack.enter_context(renderer_of(size, *(chosen or (None, "low"))))
            for name, chosen in VARIANTS.items()
        }
        for place, at in views.items():
            errors: dict[str, tuple[float, float]] = {}
            for name, renderer in renderers.items():
                first = float(flip(truth[place], renderer.render(at)["color"]).mean())
                renderer.settle(at)
                errors[name] = float(flip(truth[place], renderer.render(at)["color"]).mean()), first
            times = processor_times({name: flight(renderer, at) for name, renderer in renderers.items()}, rounds)
            for name, ms in times.items():
                error, first = errors[name]
                found[name, place] = CloudCost(error, first, max(ms - times["none"], 1e-3), ms)
    return found


def processor_times(frames: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median processor time of each, in ms, all threads together; interleaved, so that a busy machine slows all."""
    found: dict[str, list[float]] = {name: [] for name in frames}
    for turn in range(-1, rounds):
        for name, run in frames.items():
            before = time.process_time()
            run()
            if turn >= 0:
                found[name].append(1e3 * (time.process_time() - before))
    return {name: float(np.median(times)) for name, times in found.items()}


def flight(renderer: Renderer, view: View) -> Callable[[], object]:
    """Frames of a flight that begins at a view, at 300 m/s or a thousandth of its height a frame: one a call."""
    placed = view.in_scene(renderer.scene)
    start = placed.pose.position_m
    height = float(np.linalg.norm(start)) - renderer.scene.planet.radius_m
    number = itertools.count()

    def frame() -> object:
        position = start + next(number) * max(5.0, 1e-3 * height) * view.forward
        camera = Camera(position, view.forward, view.up, fov_y_deg=view.fov_y_deg)
        return renderer.render(camera, sun=placed.sun, dt_s=1.0 / 60.0)

    return frame


def seen_from_space(renderer: Renderer, pixel_m: float, axes: Floats) -> Floats:
    """Brightness (rows, columns) 0..1 of the planet's middle from 36 000 km, with pixels so wide on the clouds' tops.
    axes (3, 3): rows are the axes along which noise repeats; the picture's are the second and the third."""
    away, _, up = axes
    radius = renderer.scene.planet.radius_m + TOP_M
    fov = 2.0 * np.degrees(np.arctan(0.5 * renderer.size[1] * pixel_m / 3.6e7))
    camera = Camera((radius + 3.6e7) * away, -away, up, fov_y_deg=float(fov))
    sun = Sun(direction=tuple(axes.T @ np.array([0.9, 0.3, 0.3])))
    renderer.settle(camera, sun=sun)
    return renderer.render(camera, sun=sun)["color"].mean(axis=-1) / 255.0


def repeats(picture: Floats, shift_px: int) -> tuple[float, float]:
    """(repeat, plain) of a picture (rows, columns). repeat: how much more it is like itself, shifted by a width along
    its rows or its columns, than shifted by a third less or more: a correlation, 0 without repeats, up to 1. Clouds
    have their sizes, and are like themselves at every small shift, which is in `plain`, their correlation at that width
    as it stands; only a repeat stands out at its own. Means over three widths are taken off first, since a disc is
    bright in its middle."""
    fine = picture - uniform_filter(picture, 3 * shift_px, mode="nearest")
    beside = max(shift_px // 3, 1)

    def alike(shift: int, axis: int) -> float:
        a, b = (fine.take(range(*span), axis) for span in ((shift, len(fine)), (0, len(fine) - shift)))
        return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])

    return max(
        (alike(shift_px, axis) - 0.5 * (alike(shift_px - beside, axis) + alike(shift_px + beside, axis)),
         alike(shift_px, axis))
        for axis in (0, 1)
    )  # fmt: skip
