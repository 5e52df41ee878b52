"""Tables of precomputed atmospheric scattering (Bruneton and Neyret 2008, as implemented by Bruneton 2017)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...engine.gpu import GpuScope

__all__ = ["PAPER_UNITS", "PaperSizes", "PaperTables"]

PAPER_UNITS = {"transmittance": 8, "scattering": 9, "mie": 10, "irradiance": 11}
"""Texture units at which atmosphere/paper/functions.glsl expects the tables."""

_BEFORE_UNIT, _DENSITY_UNIT, _FLOOR_UNIT = 12, 13, 14  # of tables that only the computation needs

# Sizes of one slice, in texels, and the work of a texel as a share of all: both from times on two cores with llvmpipe,
# where such a slice takes at most about 10 ms.
_SLICE = {"transmittance": 1024, "single": 8192, "direct": 4096, "density": 2048, "indirect": 256, "multiple": 4096}
_WORK = {"transmittance": 6.0, "single": 1.0, "direct": 0.1, "density": 4.0, "indirect": 30.0, "multiple": 2.0}


@dataclass(frozen=True)
class PaperSizes:
    """How fine the tables are, in texels, and how they are kept. ValueError for what cannot be computed.

    transmittance: (mu, r). scattering: (r, mu, mu_s, nu). irradiance: (mu_s, r). orders: of scattering, 1 or more (1:
    no sky irradiance, as in the source, which counts one order less there). storage: rgba16f or rgba32f for the two
    scattering tables and what they are made of; the others are always rgba32f. max_sun_zenith_deg: where the sun's
    axis ends, 90 to 180. The source's demo has 102 with half floats and 120 without; 102 is better after sunset, 120
    glows less on the night side.
    """

    transmittance: tuple[int, int] = (256, 64)
    scattering: tuple[int, int, int, int] = (32, 128, 32, 8)
    irradiance: tuple[int, int] = (64, 16)
    orders: int = 4
    storage: str = "rgba16f"
    max_sun_zenith_deg: float = 102.0

    def __post_init__(self) -> None:
        for name, count in (("transmittance", 2), ("scattering", 4), ("irradiance", 2)):
            size = getattr(self, name)
            if len(size) != count or min(size) < 2:
                raise ValueError(f"PaperSizes.{name} is {count} sizes of at least 2, found {size}")
        if self.scattering[1] % 2 or self.scattering[1] < 4:
            raise ValueError(
                f"PaperSizes.scattering: mu has two halves of at least 2, found {self.scattering[1]} texels in all"
            )
        if self.orders < 1:
            raise ValueError(f"PaperSizes.orders is at least 1, found {self.orders}")
        if self.storage not in ("rgba16f", "rgba32f"):
            raise ValueError(f"PaperSizes.storage is rgba16f or rgba32f, found {self.storage!r}")
        if not 90.0 <= self.max_sun_zenith_deg <= 180.0:
            raise ValueError(f"PaperSizes.max_sun_zenith_deg is 90 to 180, found {self.max_sun_zenith_deg}")

    @property
    def scattering_texels(self) -> tuple[int, int, int]:
        """Width (nu and mu_s), height (mu) and depth (r) of the scattering tables."""
        r, mu, mu_s, nu = self.scattering
        return mu_s * nu, mu, r


@dataclass(frozen=True)
class _Stage:
    """One table to fill: a compute program over a box of texels, cut into slices of whole rows."""

    program: Any
    size: tuple[int, int, int]
    slice_texels: int
    work: float
    bind: Callable[[], None]

    def box(self, done: int) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
        """First texel and size of the slice after `done` texels: rows of one layer, or whole layers."""
        width, height, depth = self.size
        z, y = divmod(done // width, height)
        rows = max(1, self.slice_texels // width)
        if y == 0 and rows >= height:
            return (0, 0, z), (width, height, min(rows // height, depth - z))
        return (0, y, z), (width, min(rows, height - y), 1)


class PaperTables:
    """The tables of one atmosphere, computed on the GPU a slice at a time.

    The air comes from the uniform block `air_model` (binding 5, `generated/air_model.glsl`): it has to exist before
    this object and to be bound, unchanged, whenever step() is called; restart() after it changed. The tables are for a
    sun of irradiance 1. They hold what they should only once `done`; shaders read them through
    atmosphere/paper/functions.glsl.

    slices: how much larger than on a slow machine a slice is; 10 to 100 may suit a GPU.
    """

    def __init__(self, gpu: GpuScope, sizes: PaperSizes | None = None, slices: float = 1.0) -> None:
        self.sizes = sizes = sizes or PaperSizes()
        self._gpu, self._slices = gpu, slices
        kind = sizes.storage
        defines: dict[str, Any] = {"PAPER_FORMAT": kind, "PAPER_NU": sizes.scattering[3]}
        if kind == "rgba16f":
            defines["PAPER_HALF"] = 1
        first = {**defines, "FIRST_ORDER": 1}
        self._programs: dict[str, Any] = {
            "transmittance": gpu.compute("atmosphere/paper/transmittance.comp"),
            "single": gpu.compute("atmosphere/paper/single.comp", defines),
            "direct": gpu.compute("atmosphere/paper/irradiance_direct.comp"),
        }
        if sizes.orders > 1:
            files = {
                "density": "atmosphere/paper/density.comp",
                "indirect": "atmosphere/paper/irradiance_indirect.comp",
            }
            for name, file in files.items():
                self._programs[f"{name} first"] = gpu.compute(file, first)
                if sizes.orders > 2:
                    self._programs[name] = gpu.compute(file, defines)
            self._programs["multiple"] = gpu.compute("atmosphere/paper/multiple.comp", defines)
        mu_s_min = math.cos(math.radians(sizes.max_sun_zenith_deg))
        self._programs["transmittance"].set("u_layout", (float(sizes.scattering[3]), mu_s_min))
        texels = sizes.scattering_texels
        self.textures: dict[str, Any] = {
            "transmittance": gpu.texture(sizes.transmittance, "rgba32f", filter="linear"),
            "scattering": gpu.texture(texels, kind, filter="linear"),
            "mie": gpu.texture(texels, kind, filter="linear"),
            "irradiance": gpu.texture(sizes.irradiance, "rgba32f", filter="linear"),
        }
        self._working: dict[str, Any] = {}
        self._stages: list[_Stage] = []
        self.restart()

    def use(self) -> None:
        """Bind the tables to the units that functions.glsl reads."""
        for name, unit in PAPER_UNITS.items():
            self.textures[name].use(unit)

    def restart(self) -> None:
        """Compute all tables anew with the next steps."""
        if not self._working:
            texels, kind = self.sizes.scattering_texels, self.sizes.storage
            self._working["order"] = self._gpu.texture(texels, kind, filter="linear")
            self._working["floor"] = self._gpu.texture(self.sizes.irradiance, "rgba32f", filter="linear")
            if self.sizes.orders > 1:
                self._working["density"] = self._gpu.texture(texels, kind, filter="linear")
            self._stages = self._plan()
        self._all_work = sum(stage.work * math.prod(stage.size) for stage in self._stages)
        self._stage, self._texels, self._work_done = 0, 0, 0.0

    @property
    def done(self) -> bool:
        """Whether all tables are final."""
        return self._stage == len(self._stages)

    def step(self) -> float:
        """Compute one slice; the share of all work that is done, 1.0 at the end. Binds textures and images as needed.

        Afterwards every texture unit from 8 to 14 may hold something else.
        """
        if self.done:
            return 1.0
        stage = self._stages[self._stage]
        first, count = stage.box(self._texels)
        stage.bind()
        stage.program.set("u_first", first)
        stage.program.set("u_count", count)
        stage.program.run_over(*count)
        self._texels += math.prod(count)
        self._work_done += stage.work * math.prod(count)
        if self._texels == math.prod(stage.size):
            self._gpu.gpu.barrier()
            self._stage, self._texels = self._stage + 1, 0
            if self.done:
                self._free_working()
                return 1.0
        return min(self._work_done / self._all_work, 0.999)

    def release(self) -> None:
        """Free all textures and programs."""
        self._free_working()
        for owned in (*self.textures.values(), *self._programs.values()):
            self._gpu.free(owned)
        self.textures.clear()
        self._programs.clear()

    # -- the plan ----------------------------------------------------------------------------------------------------

    def _free_working(self) -> None:
        for texture in self._working.values():
            self._gpu.free(texture)
        self._working.clear()
        self._stages = self._stages[:0]
        self._stage = 0

    def _plan(self) -> list[_Stage]:
        """Stages in order: order n needs order n - 1 and, for the floor, its irradiance by order n - 2."""
        sizes, tables, working = self.sizes, self.textures, self._working
        flat = (*sizes.irradiance, 1)
        order, floor = working["order"], working["floor"]
        stages = [
            self._stage_of("transmittance", (*sizes.transmittance, 1), (tables["transmittance"],)),
            self._stage_of("single", sizes.scattering_texels, (order, tables["mie"], tables["scattering"])),
            self._stage_of("direct", flat, (floor, tables["irradiance"])),
        ]
        for n in range(2, sizes.orders + 1):
            first = " first" if n == 2 else ""
            stages += [
                self._stage_of(f"density{first}", sizes.scattering_texels, (working["density"],)),
                self._stage_of(f"indirect{first}", flat, (floor, tables["irradiance"])),
                self._stage_of("multiple", sizes.scattering_texels, (order, tables["scattering"])),
            ]
        return stages

    def _stage_of(self, name: str, size: tuple[int, int, int], images: tuple[Any, ...]) -> _Stage:
        kind = name.split(maxsplit=1)[0]
        accumulates = kind in ("indirect", "multiple")
        units = {PAPER_UNITS["transmittance"]: self.textures["transmittance"], PAPER_UNITS["mie"]: self.textures["mie"]}
        units[_BEFORE_UNIT], units[_FLOOR_UNIT] = self._working["order"], self._working["floor"]
        if "density" in self._working:
            units[_DENSITY_UNIT] = self._working["density"]

        def bind() -> None:
            for unit, texture in units.items():
                texture.use(unit)
            for unit, texture in enumerate(images):
                texture.bind_to_image(unit, read=accumulates and unit == 1, write=True)

        return _Stage(self._programs[name], size, max(1, int(_SLICE[kind] * self._slices)), _WORK[kind], bind)
