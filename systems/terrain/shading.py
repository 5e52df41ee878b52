"""Light of the ground's pixels: its tiles in lists by what changes them, and a shader for each list."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...components import Cover, Ocean
from ...engine.blocks.bindings import LAND_WATER_UNIT, RADIANCE_IMAGE, SORTED_TILES_BUFFER, TILE_BUFFER
from ...engine.frame import View, ViewInfo
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.gbuffer import GBUFFER, GBUFFER_UNITS, tiles_of
from ...engine.gpu import Compute
from ...engine.gpu.upsample_shaded import UpsampleShaded
from ...engine.graph import BufferSpec, GraphBuilder, PassIO
from ...engine.settings import Settings, with_overrides
from ...engine.surface.crowns import CROWNS_FROM, crown_share, mean_crown_m
from ...engine.system import Setup
from .backends import Backend
from .land_water import LAND_WATER, NARROW_TILES

__all__ = ["GroundShading", "ShadedGround"]

_TILES = ("gbuffer.tiles_terrain", "gbuffer.tiles_near")
_SORTED = "terrain.tiles_sorted"
_WET, _NEAR, _CROWNS = 1, 2, 4
"""What a list's number among the eight says of its tiles; as assets/shaders/terrain/wet_lists.glsl has it."""
_WET_READS = ("gbuffer.tile_depths", "gbuffer.tile_flags")
_NARROW_RIVERS = "terrain/narrow_rivers.comp"
_GIVEN_BLADES = 9
"""In a cell of grass, for which assets/shaders/terrain/grass.glsl has their width."""


@dataclass(frozen=True)
class ShadedGround:
    """What is asked of the ground that is shaded, as it is now. watered: whether it knows rivers and lakes; bind: what
    its heights and colours are read from."""

    backend: Callable[[], Backend]
    watered: Callable[[], bool]
    clutter: Callable[[], float]
    bind: Callable[[View], None]


class GroundShading:
    """Of one planet. name: of the system whose passes these are."""

    def __init__(self, setup: Setup, name: str, ground: ShadedGround) -> None:
        self._gpu, self._world, self._settings = setup.gpu, setup.world, setup.settings
        self._name, self._ground = name, ground
        self._between: UpsampleShaded | None = None
        self._shaders: dict[tuple[str, ...], Compute] = {}

    def declare(self, builder: GraphBuilder, view: ViewInfo, seen: Callable[[], bool]) -> None:
        """The passes that sort tiles and shade them."""
        of = view.view
        tiles = _TILES
        if self.sorts_wet():
            tiles = (_SORTED,)
            across, down = tiles_of(view.size)
            builder.add_pass(
                "terrain.wet",
                kind="compute",
                system=self._name,
                bind=lambda io: self._bind_wet(io, of, across, down),
                reads=("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface", *_WET_READS),
                creates=(
                    BufferSpec(_SORTED, 8 * self._stride(across * down), help="dispatches and tiles, in eight lists"),
                ),
                only_while=seen,
                help="tiles of the ground by whether water changes any of it",
            )
        builder.add_pass(
            "terrain.shade",
            system=self._name,
            bind=lambda io: self._bind_shade(io, of, tiles),
            kind="compute",
            reads=(
                *("gbuffer.depth", *GBUFFER, *dict.fromkeys((*_TILES, *tiles)), *contract_reads(self._world)),
                *((LAND_WATER, NARROW_TILES) if self.shows_rivers() else ()),
            ),
            writes=("scene.radiance",),
            stage="opaque",
            only_while=seen,
            help="materials and light of terrain pixels",
        )

    def sorts_wet(self) -> bool:
        """Whether there is water that the backend's shading knows of."""
        return bool(self._world.query(Ocean)) and self._ground.backend().shades_all

    def shows_rivers(self) -> bool:
        """Whether rivers and lakes are drawn: with the sea's passes, on ground that knows water."""
        return self._ground.watered() and self.sorts_wet()

    def _crowns_m(self, settings: Settings, pixel_rad: float) -> tuple[float, float]:
        """Distances between which crowns of a forest may show: those narrower than a pixel don't."""
        found = [with_overrides(cover, "cover", settings) for _, (cover,) in self._world.query(Cover)]
        if not found or not int(self._settings["cover.crowns"]):
            return 0.0, 0.0
        widest_m = max(mean_crown_m(crown_share(c.density, c.height_m, c.spacing_m), c.spacing_m) for c in found)
        across_rad = pixel_rad * (2.0 if self.shade_every() == 4 else 1.0)
        return CROWNS_FROM * float(self._settings["cover.reach_m"]), widest_m / across_rad

    def _stride(self, tiles: int) -> int:
        """Bytes of a list of tiles: each may be bound by itself."""
        align = max(self._gpu.caps.storage_offset_bytes, 4)
        return -(-(16 + 4 * tiles) // align) * align

    def _bind_wet(self, io: PassIO, view: View, across: int, down: int) -> Callable[[], None]:
        begin, sort = self.shader("terrain/begin_wet.comp"), self.shader("terrain/list_wet.comp")
        buffers = [(SORTED_TILES_BUFFER, io.buffer(_SORTED)), *zip((7, 4), map(io.buffer, _WET_READS), strict=True)]
        words = self._stride(across * down) // 4
        textures = [(unit, io.texture(name)) for name, unit in GBUFFER_UNITS.items() if name != "gbuffer.normal"]
        barrier = self._gpu.barrier

        def run() -> None:
            for binding, buffer in buffers:
                buffer.bind_to_storage_buffer(binding)
            for unit, texture in textures:
                texture.use(unit)
            begin.set("u_stride", words)
            begin.run()
            barrier()
            sort.set("u_stride", words)
            sort.set("u_tiles", (across, down))
            sort.set("u_crowns_m", self._crowns_m(view.frame.settings, view.frame.pixel_rad))
            sort.run(-(-across * down // 64))

        return run

    def shader(self, file: str, *flags: str) -> Compute:
        """A compute shader, made when a backend first asks for it: its contracts are there by then. flags: names that
        are defined; each shader tells what it knows."""
        if (file, *flags) not in self._shaders:
            # The power of how much longer than wide a pixel's place on the ground is.
            blur = 0.5 * (1.0 - float(self._settings["terrain.sharpness"]))
            step = int(self._settings["terrain.coast_px"])
            every = self.shade_every()
            defines: dict[str, Any] = {"GROUND_BLUR": f"{blur:.4f}", "COAST_STEP": step, "SHADE_EVERY": every}
            values: dict[str, Any] = {
                "GROUND_COVER": f"{float(self._settings['cover.reach_m']):.1f}",
                "COVER_CROWNS": int(self._settings["cover.crowns"]),
                "RADIANCE_READ": str(self._settings.get("sky.radiance_format", "rgba32f")),
            }
            defines |= {flag: values.get(flag, 1) for flag in flags}
            if "GROUND_COVER" in flags and int(self._settings["cover.crowns"]) > 0:
                defines["COVER_SHRINKS"] = 1
            if {"GROUND_COVER", "GROUND_CLUTTER"} <= set(flags):
                # As much of the ground is covered by fewer and wider ones.
                blades = int(self._settings["cover.blades"])
                defines |= {"GRASS_BLADES": blades, "GRASS_WIDER": f"{_GIVEN_BLADES / blades:.3f}"}
            self._shaders[file, *flags] = self._gpu.compute(file, defines=defines)
        return self._shaders[file, *flags]

    def shade_every(self) -> int:
        """One of so many pixels is shaded."""
        return int(self._settings["terrain.shade_every"]) if self._ground.backend().shades_all else 1

    def _bind_shade(self, io: PassIO, view: View, lists: tuple[str, ...]) -> Callable[[], None]:
        radiance = io.texture("scene.radiance")
        textures = [(unit, io.texture(name)) for name, unit in GBUFFER_UNITS.items()]
        bind_air = bind_contracts(self._world, io)
        backend = self._ground.backend()
        sorts = lists == (_SORTED,)
        # Without a sea all ground is shaded as dry ground beside one: no further programs for it.
        no_water = backend.shades_all and not self._world.query(Ocean)
        rivers = io.texture(LAND_WATER) if self.shows_rivers() else None
        every, between = self.shade_every(), None
        # Where most pixels take their light from others, narrow rivers are added to each once they have it.
        added = self.shader(_NARROW_RIVERS, "RADIANCE_READ") if rivers is not None and every > 2 else None
        narrow = None if added is None else io.buffer(NARROW_TILES)
        cover = ("GROUND_COVER",) if backend.shades_all and self._world.query(Cover) else ()
        crowns = ("COVER_CROWNS",) if cover and int(self._settings["cover.crowns"]) > 0 else ()
        # Per list of tiles: where it lies, the shader, and the one for ground so near that things stand on it.
        parts = []
        numbers = range(8 if crowns else 4) if sorts else (_CROWNS, _CROWNS | _NEAR)
        stride = self._stride(math.prod(tiles_of(io.size))) if sorts else 0
        for list_number, number in enumerate(numbers):
            dry = ("GROUND_DRY",) if no_water or (sorts and not number & _WET) else ()
            flags = ("GROUND_RIVERS",) if rivers is not None and not dry else dry
            near = ("GROUND_CLUTTER",) if backend.shades_all and number & _NEAR else ()
            flags = (*flags, *cover, *(crowns if number & _CROWNS else ()))
            plain, full = self.shader(backend.shade_file, *flags), self.shader(backend.shade_file, *flags, *near)
            parts.append((io.buffer(lists[0 if sorts else list_number]), number * stride, plain, full))

        all_tiles = [io.buffer(name) for name in _TILES]
        if every > 1:  # kept: graphs are compiled again and again
            between = self._between or UpsampleShaded(self._gpu, "SURFACE_TERRAIN", every, self._settings)
            self._between = between

        def run() -> None:
            bind_air()
            radiance.bind_to_image(RADIANCE_IMAGE, read=False, write=True)
            for unit, texture in textures:
                texture.use(unit)
            if rivers is not None:
                rivers.use(LAND_WATER_UNIT)
            self._ground.bind(view)
            backend.bind_shading()
            cluttered = self._ground.clutter() > 0.0
            for tiles, offset, plain, full in parts:
                tiles.bind_to_storage_buffer(TILE_BUFFER, offset=offset)
                (full if cluttered else plain).run_indirect(tiles, offset)
            if between is not None and between.leaves_out(view.frame.checkerboard):
                between.run(radiance, all_tiles)
            if added is not None and narrow is not None:
                self._gpu.barrier()
                radiance.bind_to_image(RADIANCE_IMAGE, read=True, write=True)
                with self._gpu.apart():  # each pixel reads and changes itself alone
                    narrow.bind_to_storage_buffer(TILE_BUFFER)
                    added.run_indirect(narrow)

        return run
