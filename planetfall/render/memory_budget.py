"""A budget for GPU memory: what a renderer will take, and which knobs give way so that it takes no more.

The sizes come from the knobs, before anything is made; tests hold them against what is then there.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..components import Atmosphere, Clouds, Composite, Cover, Ocean, Planet, Stars, Terrain
from ..engine.settings import with_overrides
from ..errors import SettingError

if TYPE_CHECKING:
    from ..scene.scene import Scene

__all__ = ["TRADES", "MemoryPlan", "estimate_bytes", "plan_memory"]

log = logging.getLogger(__name__)

KEY = "memory.budget_mib"
MIB = 2**20

_VERTEX, _STARTS = 24, 16
_CELLS_AROUND, _CELLS_ON_SCREEN = 380.0, 0.5
"""Cells of the grid: those that any picture needs, all around and down to the foot, and those for each (rows /
edge_px)^2. Measured from 90 to 720 rows."""
_CELL_STEP = 512
"""Buffers of cells grow by so many."""
_SHADOW_LAYERS, _SHADOW_TEXEL, _SHADOW_SCRATCH = 16, 45, 16
_RIVER_COLUMN, _RIVER_REST, _RIVER_CELL = 64.0, 1.2e6, 10.5
"""Bytes of a planet's table of rivers: for (radius / width of the lattice's cells)^2; and, measured on the preset earth
with 0.2 and 3.5 million cells of drainage, for any and for each of those cells. More land adds little: it is drier."""
_CLOUD_MAPS, _CLOUD_SLICES = 6, 9
_GALAXY_BYTES = 8 * MIB
_REST_BYTES = MIB
"""Index lists, stars, cells without their vertices."""
_FEWEST_ROWS = 0.25
"""Of a picture's rows, that the budget may ask for."""


@dataclass(frozen=True)
class _Trade:
    """A knob that gives way: next(value) is its next lower quality, None at the end."""

    key: str
    loses: str
    next: Callable[[Any], Any]


def _halved(least: int) -> Callable[[Any], Any]:
    return lambda value: int(value) // 2 if int(value) // 2 >= least else None


TRADES: tuple[_Trade, ...] = (
    _Trade("terrain.slots", "tiles that are kept: more are made again when the camera comes back", _halved(1024)),
    _Trade("clouds.map_texels", "the finest outlines of the weather, seen from space", _halved(256)),
    _Trade("clouds.shadow_texels", "sharpness of the clouds' shadows and light", _halved(64)),
    _Trade("cover.shadow_texels", "sharpness of the trees' shadows", _halved(512)),
    _Trade("shadows.size", "sharpness of shadows on the ground", _halved(64)),
    _Trade("clouds.fibre_texels", "the finest fibres of cirrus", _halved(512)),
    _Trade("clouds.shape_texels", "variety of clouds near the camera", _halved(64)),
    _Trade("proxy.ahead_frames", "grids that are prepared over some frames: those of snaps take longer",
           lambda value: 0 if value else None),
    _Trade("terrain.fade_s", "ground that moves smoothly when the grid snaps", lambda value: 0.0 if value else None),
    _Trade("sky.radiance_format", "half the bits of radiance, seen in bands of dark skies",
           lambda value: "rgba16f" if value == "rgba32f" else None),
    _Trade("clouds.stride", "sharpness of clouds while the camera moves",
           lambda value: 2 * int(value) if int(value) <= 2 else None),
    _Trade("terrain.edge_px", "fine triangles", lambda value: 1.25 * value if 1.25 * value <= 32.0 else None),
)  # fmt: skip
"""In the order in which they give way, each by a step; then again from the first."""


def estimate_bytes(settings: Mapping[str, Any], scene: Scene, size: tuple[int, int]) -> int:
    """GPU memory of a renderer with one view of this size, in bytes: textures and buffers, not programs. About 10 %
    right for the planets that come along; meshes and maps of a scene's own come on top."""
    planet, width, height = scene.planet, int(size[0]), int(size[1])
    total = _REST_BYTES + width * height * _bytes_per_pixel(settings, scene)
    clouds, terrain = planet.get(Clouds), planet.get(Terrain)
    if scene.environment.has(Stars):
        total += _GALAXY_BYTES
    if clouds is not None:
        # Here, not above: a scene's checks need no GPU package, and a planet without clouds none of theirs.
        from ..systems.clouds.layers import has_cirrus, layers_of

        texels, side = int(settings["clouds.shadow_texels"]), int(settings["clouds.map_texels"]) + 32
        total += texels**2 * (_CLOUD_MAPS + 1) * (8 + 4 * _CLOUD_SLICES)  # one is being made
        total += side**2 * 4 * 3 * 4 / 3  # three maps with their levels
        # Volumes in r16f, as GPUs have them: shape, cells of half its side, rims.
        sides = int(settings["clouds.shape_texels"]), int(settings["clouds.rim_texels"])
        total += sum(side**3 for side in (sides[0], sides[0] // 2, sides[1])) * 2 * 8 / 7
        if has_cirrus(layers_of(clouds)):
            total += int(settings["clouds.fibre_texels"]) ** 2 * 4 * 4 / 3
    if planet.has(Cover):
        total += int(settings["cover.shadow_texels"]) ** 2 * 8
    if planet.has(Atmosphere):
        columns, rows, slices = (int(settings[f"atmosphere.{n}"]) for n in ("columns", "rows", "slices"))
        total += columns * 2 * rows * (slices + 1) * 32
        total += 2e-3 * MIB * int(settings["atmosphere.altitudes"]) * int(settings["atmosphere.sun_heights"])
    if terrain is not None:
        chosen = with_overrides(terrain, "terrain", settings)
        total += _ground_bytes(settings, chosen.backend, height, sea=planet.has(Ocean))
        if _has_rivers(scene):
            total += _river_bytes(planet[Planet].radius_m, chosen.drainage_cells)
        if chosen.shadows or chosen.occlusion:
            wide = max(min(round(0.71 * height), int(settings["shadows.size"])), 64)
            side = 1 << (wide - 1).bit_length()
            total += side**2 * _SHADOW_LAYERS * _SHADOW_TEXEL + wide**2 * _SHADOW_SCRATCH
    return round(total)


def _has_rivers(scene: Scene) -> bool:
    """Without a sea nothing rains."""
    terrain = scene.planet.get(Terrain)
    return terrain is not None and terrain.rivers > 0.0 and scene.planet.has(Ocean)


def _river_bytes(radius_m: float, cells: int) -> float:
    """The texture that holds all rivers and lakes of a planet."""
    across = 256.0 * radius_m / 2.0 ** math.floor(math.log2(radius_m))
    return _RIVER_COLUMN * across**2 + _RIVER_REST + _RIVER_CELL * cells


def _bytes_per_pixel(settings: Mapping[str, Any], scene: Scene) -> float:
    planet = scene.planet
    composite = scene.environment.get(Composite) or Composite()
    smoothing = with_overrides(composite, "composite", settings).antialiasing
    each = 13.0 + 4.0 + 3.5  # the G-buffer; the picture; glare, metering and lists of tiles
    each += 8.0 if settings["sky.radiance_format"] == "rgba16f" else 16.0
    each += {"temporal": 32.0, "edge": 16.0}.get(smoothing, 0.0)
    if planet.has(Ocean):
        each += 15.0 + (12.0 if planet.has(Terrain) else 0.0)  # waves; coasts
    if _has_rivers(scene):
        each += 16.0 + 2.1  # what water a pixel shows; 31 lines for each tile
    if planet.has(Clouds):
        each += 40.0 + (36.0 if int(settings["clouds.march_every"]) > 1 else 20.0) / int(settings["clouds.stride"]) ** 2
    return each


def _ground_bytes(settings: Mapping[str, Any], backend: str, rows: int, sea: bool) -> float:
    """Vertices of the ground and the sea."""
    cells = _CELLS_AROUND + _CELLS_ON_SCREEN * (rows / float(settings["terrain.edge_px"])) ** 2
    # Larger cells are fewer.
    quads = int(settings["terrain.quads"])
    cells = max(cells * (16.0 / quads) ** 2, _CELL_STEP)
    cells = -(-cells // _CELL_STEP) * _CELL_STEP
    vertices = cells * (quads + 1) ** 2
    ahead = int(settings["proxy.ahead_frames"]) > 0
    total = (2.0 + ahead) * vertices * _VERTEX if sea else 0.0
    if backend == "grid":
        total += ahead * vertices * _VERTEX
        fades = float(settings["terrain.fade_s"]) > 0.0
        return total + vertices * (_VERTEX + (0.5 * (_VERTEX + _STARTS) if fades else 0.0))
    slots, segments = int(settings["terrain.slots"]), int(settings["terrain.tile_quads"])
    return total + slots * ((segments + 1) ** 2 * 36.0 + 150.0)


@dataclass
class MemoryPlan:
    """What was agreed on. budget_mib: 0 without one. expected_bytes: by estimate. lowered: {knob: (chosen, taken)}."""

    budget_mib: int
    expected_bytes: int
    lowered: Mapping[str, tuple[Any, Any]]
    _settings: Mapping[str, Any]
    _scene: Scene

    def __post_init__(self) -> None:
        self._scales: dict[tuple[int, int], float] = {}

    def scale(self, size: tuple[int, int]) -> float:
        """Rows that may be drawn for each row of a picture of this size, 0.25 to 1: a window that grows beyond the
        budget gets fewer pixels."""
        if not self.budget_mib:
            return 1.0
        if size not in self._scales:
            self._scales = {size: self._fitting(size)}
        return self._scales[size]

    def _fitting(self, size: tuple[int, int]) -> float:
        def fits(scale: float) -> bool:
            part = (max(round(scale * size[0]), 1), max(round(scale * size[1]), 1))
            return estimate_bytes(self._settings, self._scene, part) <= self.budget_mib * MIB

        if fits(1.0):
            return 1.0
        low, high = _FEWEST_ROWS, 1.0
        for _ in range(10):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if fits(middle) else (low, middle)
        log.info("%d x %d pixels are more than %d MiB allow: drawn with %.2f of the rows", *size, self.budget_mib, low)
        return low


def plan_memory(settings: dict[str, Any], scene: Scene, size: tuple[int, int]) -> MemoryPlan:
    """Lower knobs in `settings` until the renderer fits into "memory.budget_mib". SettingError, with the least that
    would do, where even the lowest does not."""
    budget = int(settings[KEY])
    found = estimate_bytes(settings, scene, size)
    if not budget or found <= budget * MIB:
        return MemoryPlan(budget, found, {}, settings, scene)
    chosen, going = dict(settings), True
    while going and found > budget * MIB:
        going = False
        for trade in TRADES:
            lower = trade.next(settings[trade.key])
            if lower is None:
                continue
            less = estimate_bytes({**settings, trade.key: lower}, scene, size)
            if less < found:
                settings[trade.key], found, going = lower, less, True
            if found <= budget * MIB:
                break
    if found > budget * MIB:
        rivers = ", give its Terrain no rivers" if _has_rivers(scene) else ""
        raise SettingError(
            f"{KEY}: expected at least {-(-found // MIB)} MiB for {size[0]} x {size[1]} pixels of this scene with every"
            f" knob as low as it may be, found {budget}. Lower the size, take off components (Clouds){rivers}, or raise"
            " it"
        )
    lowered = {key: (chosen[key], value) for key, value in settings.items() if chosen[key] != value}
    log.info("%d MiB of GPU memory: %s", budget, ", ".join(f"{key} {a} to {b}" for key, (a, b) in lowered.items()))
    return MemoryPlan(budget, found, lowered, settings, scene)
