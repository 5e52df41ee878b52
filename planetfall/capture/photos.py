"""Photos: pictures of any size, rendered in tiles and with several samples a pixel."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..camera.arguments import check_scene
from ..camera.camera import Camera, PosedCamera
from ..camera.place import Optics, Pose
from ..engine.srgb import SRGB_STEPS, srgb_encode
from ..errors import SizeError

if TYPE_CHECKING:
    from ..components import Sun
    from ..render.renderer import Renderer
    from ..scene.scene import Scene

__all__ = ["PhotoPlan", "photo", "photo_tiles"]

Pixels = NDArray[np.uint8]
Arrays = dict[str, NDArray[Any]]

LARGEST_PX = 65_536
_MARGIN_PX = 32
"""Around each tile, thrown away: glare and smoothing of edges look at their neighbours."""
_METER_PX = 640
"""Longest side of the small picture that the exposure is measured in."""


@dataclass(frozen=True)
class PhotoPlan:
    """How a photo is taken. size: (width, height) of the result. supersample: rendered with so many times the pixels
    along each side, then averaged in linear light. tile_px: the longest side that is rendered at once, samples and
    margins included. ev100: the exposure; None measures it once, for all tiles."""

    size: tuple[int, int] = (3840, 2160)
    supersample: int = 1
    tile_px: int = 2048
    ev100: float | None = None

    def __post_init__(self) -> None:
        if not all(1 <= int(n) <= LARGEST_PX for n in self.size):
            raise SizeError(f"photo: size: expected 1 to {LARGEST_PX} pixels a side, found {self.size!r}")
        if not 1 <= self.supersample <= 8 or int(self.supersample) != self.supersample:
            raise SizeError(f"photo: supersample: expected a whole number from 1 to 8, found {self.supersample!r}")
        if not 256 <= self.tile_px <= 16384:
            raise SizeError(f"photo: tile_px: expected 256 to 16384, found {self.tile_px!r}")

    def tiles(self) -> list[tuple[int, int, int, int]]:
        """(left, top, right, bottom) in pixels of the result, row by row."""
        inner = self.tile_px // self.supersample
        width, height = self.size
        if max(width, height) > inner:
            inner = max(inner - 2 * -(-_MARGIN_PX // self.supersample), 8)
        columns, rows = math.ceil(width / inner), math.ceil(height / inner)
        xs = [round(width * i / columns) for i in range(columns + 1)]
        ys = [round(height * i / rows) for i in range(rows + 1)]
        return [(x0, y0, x1, y1) for y0, y1 in pairwise(ys) for x0, x1 in pairwise(xs)]


def photo(
    scene: Scene,
    camera: Camera,
    size: tuple[int, int] = (3840, 2160),
    *,
    supersample: int = 1,
    tile_px: int = 2048,
    ev100: float | None = None,
    time_s: float | None = None,
    sun: Sun | None = None,
    quality: str = "high",
    overrides: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Pixels:
    """A settled picture (H, W, 3) of any size, in tiles where it is larger than `tile_px`; see PhotoPlan.

    camera, time_s, sun: as for Renderer.render; a camera with intrinsics has a size of its own. progress(done, count)
    follows the tiles. Raises SizeError for a size, SettingError and CameraError as the renderer.
    """
    check_scene(scene, "photo")
    size = size if camera.intrinsics is None else camera.intrinsics.size
    plan = PhotoPlan((int(size[0]), int(size[1])), supersample, tile_px, ev100)
    from ..render.renderer import Renderer

    with Renderer(scene, (64, 64), quality, overrides) as renderer:
        arrays: Arrays = {}
        for done, count, found in photo_tiles(renderer, camera, plan, time_s, sun):
            arrays = found
            if progress is not None:
                progress(done, count)
        return arrays["color"]


def photo_tiles(
    renderer: Renderer,
    camera: Camera,
    plan: PhotoPlan,
    time_s: float | None = None,
    sun: Sun | None = None,
    outputs: Sequence[str] = ("color",),
) -> Iterator[tuple[int, int, Arrays]]:
    """Take a photo a tile at a time: (tiles done, tiles in all, arrays so far); first with 0 tiles done and none.

    outputs: as for Renderer.render. Of several samples a pixel, colour and radiance are means of light; all else is
    that of the sample next to the pixel's centre, because a mean of two places is neither.
    A lens that bends straight lines has no tiles. The renderer's size changes meanwhile, and is put back when the last
    tile is done or the iterator is closed.
    """
    before, scale = renderer.size, renderer.render_scale
    width, height = plan.size
    tiles = plan.tiles() if camera.optics.lens is None else [(0, 0, *plan.size)]
    arrays: Arrays = {}
    placed = camera.in_scene(renderer.scene)
    time_s = placed.time_s if time_s is None else time_s
    sun = placed.sun if sun is None else sun
    try:
        renderer.render_scale = 1.0  # whatever automatic quality has made of it
        ev100 = plan.ev100 if plan.ev100 is not None else placed.optics.ev100
        if ev100 is None and len(tiles) > 1:
            ev100 = _measured(renderer, camera, plan.size, time_s, sun)
        yield 0, len(tiles), arrays
        for done, tile in enumerate(tiles, 1):
            part, place = _take(renderer, camera, plan, tile, (time_s, sun, ev100), outputs)
            for name, values in part.items():
                if name not in arrays:
                    arrays[name] = np.zeros((height, width, *values.shape[2:]), values.dtype)
                arrays[name][place] = values
            yield done, len(tiles), arrays
    finally:
        if not renderer.released:
            renderer.render_scale = scale
            renderer.resize(before)


def _measured(
    renderer: Renderer, camera: Camera, size: tuple[int, int], time_s: float | None, sun: Sun | None
) -> float | None:
    """The exposure of the whole picture, from a small one."""
    share = min(_METER_PX / max(size), 1.0)
    renderer.resize((max(round(size[0] * share), 1), max(round(size[1] * share), 1)))
    renderer.settle(_part(renderer, camera, size, (0, 0, *size), None), time_s, sun=sun)
    return renderer.exposure


def _take(
    renderer: Renderer,
    camera: Camera,
    plan: PhotoPlan,
    tile: tuple[int, int, int, int],
    moment: tuple[float | None, Any, float | None],
    outputs: Sequence[str],
) -> tuple[Arrays, tuple[slice, slice]]:
    """A tile's arrays without its margins, and where in the picture they belong."""
    time_s, sun, ev100 = moment
    left, top, right, bottom = tile
    width, height = plan.size
    samples = plan.supersample
    margin = -(-_MARGIN_PX // samples)
    outer = (max(left - margin, 0), max(top - margin, 0), min(right + margin, width), min(bottom + margin, height))
    if camera.optics.lens is None:
        renderer.resize(((outer[2] - outer[0]) * samples, (outer[3] - outer[1]) * samples))
        part = _part(renderer, camera, plan.size, outer, ev100)
    else:
        part = camera.with_intrinsics(camera.optics.lens.scaled(samples))
        part = part if ev100 is None else part.exposed(ev100)
    renderer.settle(part, time_s, sun=sun)
    found = renderer.render(part, time_s, sun=sun, outputs=tuple(outputs))
    inner = slice(top - outer[1], bottom - outer[1]), slice(left - outer[0], right - outer[0])
    return {name: _reduced(name, found[name], samples)[inner] for name in outputs}, (
        slice(top, bottom),
        slice(left, right),
    )


def _reduced(name: str, values: NDArray[Any], samples: int) -> NDArray[Any]:
    """A value for each pixel from those of its samples."""
    if samples == 1:
        return values
    if name == "color":
        return averaged(values, samples)
    if name == "radiance":
        height, width = values.shape[0] // samples, values.shape[1] // samples
        light = values.reshape(height, samples, width, samples, -1)
        return light.mean(axis=(1, 3), dtype=np.float64).astype(values.dtype)
    return values[samples // 2 :: samples, samples // 2 :: samples]


def _part(
    renderer: Renderer, camera: Camera, size: tuple[int, int], tile: tuple[int, int, int, int], ev100: float | None
) -> Camera:
    """The camera for a part of a picture: the same place, and a frustum of its own beside the axis."""
    width, height = size
    if tile == (0, 0, *size) and camera.intrinsics is None:
        return camera if ev100 is None else camera.exposed(ev100)
    state = camera.resolve(renderer.scene, width / height)
    place = renderer.camera_state(camera).position_m  # on the drawn ground, and out of it
    x = [state.tan_left + (state.tan_right - state.tan_left) * tile[i] / width for i in (0, 2)]
    y = [state.tan_top + (state.tan_bottom - state.tan_top) * tile[i] / height for i in (3, 1)]
    angles = [math.degrees(math.atan(t)) for t in (*x, *y)]
    # The axes are orthonormal already, and shall stay so to the last bit from tile to tile.
    return PosedCamera(Pose(place, state.forward, state.up), Optics.checked(60.0, angles, ev100), camera.planet)


def averaged(color: Pixels, samples: int) -> Pixels:
    """u8 sRGB (H n, W n, 3) to (H, W, 3): means of n x n pixels in linear light."""
    if samples == 1:
        return color
    height, width = color.shape[0] // samples, color.shape[1] // samples
    result = np.empty((height, width, 3), np.uint8)
    rows = max(1, 4_000_000 // (color.shape[1] * samples * 3))  # so that float copies stay small
    for start in range(0, height, rows):
        part = color[start * samples : (start + rows) * samples]
        light = SRGB_STEPS[part].reshape(-1, samples, width, samples, 3).mean(axis=(1, 3))
        result[start : start + rows] = np.rint(srgb_encode(light) * 255.0)
    return result
