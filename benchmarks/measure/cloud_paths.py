"""Light of weather clouds as pictures draw it, against paths of light through the same clouds.

Windows cut from pictures of named views, no air on either side, clouds of water alone (ice is a sheet in pictures),
over a smooth planet whose albedo is the one that the drawn light takes for the ground. What is compared is the light
that droplets send to the camera, without what is seen through them. Truths are followed once and kept beside the
results.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import ASSETS, Camera, Clouds, Planet, Renderer, Scene, Sun, load_scene, view
from ...engine.gpu import Gpu
from ...engine.table_cache import TableCache
from ...quality import resolve_quality
from ...systems.clouds.layers import kind_of
from ...systems.clouds.model import CloudModel
from ...systems.clouds.path_probe import PATHS, PathProbe, PathSums, PathView
from ...systems.clouds.view_block import CloudKind
from ...systems.light.sun import resolve_sun
from ..store import results_root

__all__ = ["SHOTS", "Shot", "Truth", "drawn", "held_truth", "truth_of"]

Floats = NDArray[np.float64]
SIZE, WINDOW = (640, 360), (96, 54)
GROUND = 0.12
"""Albedo: CLOUD_GROUND of clouds/run_light.glsl."""
STANDARD_ERROR = 0.04
"""Of a pixel's light, or of _DARK of the window's median light where that is more."""
_DARK = 0.1
OPACITY = 0.05
"""Of pixels that are judged: of clouds that hide less there is next to no light."""
_FIRST = 8
"""Jobs of each pixel before it is known how many it needs."""
ALIKE: Mapping[str, Any] = {
    **{f"clouds.{name}": resolve_quality("high")[f"clouds.{name}"] for name in (
        "shape_texels", "rim_texels", "map_texels", "fibre_texels",
    )}, "composite.antialiasing": "none",
}  # fmt: skip
"""What the clouds are made of, at every quality as at high: their light is compared, not their texels."""
_ARRAYS = ("radiance", "error", "opacity", "paths")
_VERSION = 1
"""Of the way that paths are followed: to be raised when truths change by it."""
_DENSITY = ("density.glsl", "weather_map.glsl", "weather.comp", "volume.comp", "tiled_noise.glsl")


@dataclass(frozen=True)
class Shot:
    """A window of a named view of Earth. left, top: its first pixel in the picture of SIZE. sun: elevation and azimuth
    in degrees, over the view's place, instead of its own. time_s: of the weather, instead of the view's."""

    view: str
    left: int = 272
    top: int = 153
    sun: tuple[float, float] | None = None
    time_s: float | None = None


SHOTS: Mapping[str, Shot] = {
    "fair": Shot("fair", 300, 75, time_s=682560.0),
    "cloud_sea": Shot("cloud_sea", 225, 220),
    "clouds": Shot("clouds", 340, 200),
    "high": Shot("high", 270, 140),
    "overcast": Shot("overcast", 200, 50),
    "day_edge": Shot("day_edge", 190, 190),
    "orbit": Shot("orbit", 230, 250),
    "tower": Shot("cloud_sea", 450, 268, sun=(8.0, 140.0)),
}
"""Bases and rims from below; rims, tops and shade from beside and above; from space; a tower under a low sun."""


@dataclass(frozen=True)
class Truth:
    """Of a window's pixels (rows, columns), row 0 on top, per unit irradiance of the sun. seconds: it took."""

    radiance: Floats
    error: Floats
    opacity: Floats
    paths: Floats
    seconds: float

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Pixels with cloud enough."""
        return self.opacity >= OPACITY

    @property
    def wanted(self) -> Floats:
        """Standard error that each pixel should have."""
        return _wanted(self.radiance, self.judged)

    @property
    def reached(self) -> float:
        """Share of the judged pixels that have it."""
        return float((self.error <= 1.02 * self.wanted)[self.judged].mean()) if self.judged.any() else 1.0


def _wanted(radiance: Floats, judged: NDArray[np.bool_]) -> Floats:
    least = _DARK * float(np.median(radiance[judged])) if judged.any() else 1.0
    return STANDARD_ERROR * np.maximum(radiance, max(least, 1e-9))


@dataclass(frozen=True)
class Placed:
    """A shot in its scene: scene of a smooth planet with clouds of water, the camera, the sun, the time."""

    scene: Scene
    camera: Camera
    sun: Sun
    time_s: float


def placed(shot: Shot) -> Placed:
    """Where a shot is taken: over Earth's own ground, which is then left out."""
    earth = load_scene("earth")
    at = view(shot.view).in_scene(earth)
    clouds = earth.planet[Clouds]
    layers = [layer for layer in (clouds, *clouds.layers) if kind_of(layer) != CloudKind.CIRRUS]
    assert layers[0] is clouds, "the first layer is of water"
    clouds.layers = tuple(layers[1:])
    # Truths are of weather without either: what is judged is light, whatever the density.
    clouds.thickness_spread = clouds.aggregation = 0.0
    scene = Scene("clouds alone", {"planet": Planet(radius_m=earth.planet.radius_m), "clouds": clouds})
    pose, place = at.pose, at.place
    sun = at.sun or earth.sun
    if shot.sun is not None and place is not None:
        sun = Sun(elevation_deg=shot.sun[0], azimuth_deg=shot.sun[1], latitude_deg=place.latitude_deg,
                  longitude_deg=place.longitude_deg)  # fmt: skip
    x, y, z = (float(part) for part in resolve_sun(sun, None).direction)
    lit = Sun(direction=(x, y, z), irradiance=(1.0, 1.0, 1.0))
    scene.sun = lit
    camera = Camera(pose.position_m, pose.forward, pose.up, at.optics.fov_y_deg, ev100=at.optics.ev100)
    return Placed(scene, camera, lit, at.time_s or 0.0 if shot.time_s is None else shot.time_s)


def drawn(shots: Mapping[str, Shot], quality: str, overrides: Mapping[str, Any] | None = None) -> dict[str, Floats]:
    """(rows, columns, 2) of each window: light of the clouds per unit irradiance, and opacity; settled pictures."""
    found = {}
    for name, shot in shots.items():
        at = placed(shot)
        with Renderer(at.scene, SIZE, quality, {**ALIKE, **(overrides or {})}) as renderer:
            renderer.settle(at.camera, at.time_s)
            picture = renderer.render(at.camera, at.time_s, outputs=("clouds.full",))["clouds.full"].astype(float)
        coarser = SIZE[0] // picture.shape[1]
        picture = picture.repeat(coarser, 0).repeat(coarser, 1)
        window = picture[shot.top : shot.top + WINDOW[1], shot.left : shot.left + WINDOW[0]]
        found[name] = np.stack([window[..., 0], 1.0 - window[..., 3]], axis=2)
    return found


# -- the truth --------------------------------------------------------------------------------------------------------


def truth_path(name: str) -> Path:
    """Where the truth of a shot is kept."""
    return results_root() / "cloud_paths" / f"{name}.npz"


def key_of(shot: Shot) -> str:
    """Of all that a truth hangs on: the density's text, the clouds, the camera."""
    at = placed(shot)
    texts = [(ASSETS / "shaders" / "clouds" / name).read_text() for name in _DENSITY]
    state = at.camera.resolve(at.scene)
    sun = at.sun.direction or ()
    numbers = [*state.position_m.round(3), *state.forward.round(9), *state.up.round(9), *sun, at.time_s]
    about = json.dumps([asdict(at.scene.planet[Clouds]), dict(ALIKE), [float(x) for x in numbers], asdict(shot)])
    return TableCache.key(str(_VERSION), *texts, about)


def held_truth(name: str, shot: Shot) -> Truth | None:
    """The stored truth, or None where there is none of just these clouds."""
    try:
        with np.load(truth_path(name), allow_pickle=False) as held:
            if str(held["key"]) != key_of(shot):
                return None
            radiance, error, opacity, paths = (np.asarray(held[part], float) for part in _ARRAYS)
            return Truth(radiance, error, opacity, paths, float(held["seconds"]))
    except FileNotFoundError:
        return None


def store_truth(name: str, shot: Shot, truth: Truth) -> None:
    """Keep it for the next run."""
    path = truth_path(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = {part: getattr(truth, part).astype(np.float32) for part in _ARRAYS}
    np.savez_compressed(path, key=np.array(key_of(shot)), seconds=np.array(truth.seconds), **arrays)


def window_rays(at: Placed, shot: Shot) -> PathView:
    """Rays of the window's pixels, row 0 on top."""
    state = at.camera.resolve(at.scene, SIZE[0] / SIZE[1])
    wide, high = ((b - a) / n for a, b, n in (
        (state.tan_left, state.tan_right, SIZE[0]), (state.tan_bottom, state.tan_top, SIZE[1]),
    ))  # fmt: skip
    x = state.tan_left + (shot.left + np.arange(WINDOW[0]) + 0.5) * wide
    y = state.tan_top - (shot.top + np.arange(WINDOW[1]) + 0.5) * high
    ways = state.forward + y[:, None, None] * state.up + x[None, :, None] * state.right
    sun = resolve_sun(at.sun, None)
    return PathView(
        state.position_m, ways.reshape(-1, 3), wide * state.right, high * state.up, np.asarray(sun.direction),
        float(at.sun.angular_radius_rad), GROUND,
    )  # fmt: skip


def truth_of(
    gpu: Gpu, shot: Shot, most_s: float, progress: Callable[[PathSums, float], None] | None = None,
    before: Truth | None = None,
) -> Truth:  # fmt: skip
    """Followed until each pixel has its standard error or the time is over, on from the paths of `before`. As many
    paths are followed as the errors around a pixel so far ask for, at most four times as many as before in one go."""
    at, started = placed(shot), monotonic()
    clouds, scope = at.scene.planet[Clouds], gpu.scope("paths")
    try:
        settings = {**resolve_quality("high"), **ALIKE}
        probe = PathProbe(scope, clouds, CloudModel.from_components(at.scene.planet[Planet], clouds, None), settings)
        probe.place(window_rays(at, shot), at.time_s)
        count, until = WINDOW[0] * WINDOW[1], started + most_s
        sums = PathSums.none(count) if before is None else _sums_of(before)
        jobs = np.full(count, _FIRST) if before is None else _further_jobs(sums)
        while jobs.any() and monotonic() < until:
            sums = probe.follow(sums, jobs, until=until)
            if progress is not None:
                progress(sums, monotonic() - started)
            jobs = _further_jobs(sums)
        if probe.worst > 1.0 + 1e-4:
            raise RuntimeError(f"paths met {probe.worst:g} times the density that was promised as the most")
    finally:
        scope.release()
    light, error, opacity, paths = (x.reshape(WINDOW[::-1]) for x in (sums.mean, sums.error, sums.opacity, sums.count))
    seconds = monotonic() - started + (0.0 if before is None else before.seconds)
    return Truth(light, error, opacity, paths, seconds)


def _sums_of(truth: Truth) -> PathSums:
    count, mean, error = (x.ravel() for x in (truth.paths, truth.radiance, truth.error))
    square = (error**2 * (count - 1.0) + mean**2) * count
    return PathSums(count, mean * count, square, np.round(truth.opacity.ravel() * count))


def _further_jobs(sums: PathSums) -> NDArray[np.intp]:
    shape = WINDOW[::-1]
    # A pixel's own few paths know its variance badly: that of the nine around it is taken where it is more.
    variance = (sums.error**2 * sums.count).reshape(shape)
    padded = np.pad(variance, 1, mode="edge")
    around = np.mean([padded[i : i + shape[0], j : j + shape[1]] for i in range(3) for j in range(3)], axis=0)
    variance = np.maximum(variance, around).ravel()
    judged = sums.opacity >= OPACITY
    needed = variance / _wanted(sums.mean, judged) ** 2
    further = np.clip(needed - sums.count, 0.0, 3.0 * sums.count)
    return np.where(judged & (further > 0.0), np.ceil(further / PATHS), 0.0).astype(np.intp)
