"""Tables of precomputed atmospheric scattering (Bruneton and Neyret 2008, as implemented by Bruneton 2017)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import (
    PAPER_BEFORE_UNIT,
    PAPER_DENSITY_UNIT,
    PAPER_FLOOR_UNIT,
    PAPER_IRRADIANCE_UNIT,
    PAPER_MIE_UNIT,
    PAPER_SCATTERING_UNIT,
    PAPER_TRANSMITTANCE_UNIT,
)
from ...engine.gpu import Compute, GpuScope

__all__ = ["PAPER_UNITS", "PaperSizes", "PaperTables"]

PAPER_UNITS = {
    "transmittance": PAPER_TRANSMITTANCE_UNIT,
    "scattering": PAPER_SCATTERING_UNIT,
    "mie": PAPER_MIE_UNIT,
    "irradiance": PAPER_IRRADIANCE_UNIT,
}
"""Texture units at which atmosphere/paper/functions.glsl expects the tables."""


_DTYPES = {"f2": np.float16, "f4": np.float32}
_SAMPLES = {"transmittance": 150, "single": 90, "direct": 1, "density": 512, "indirect": 2900, "multiple": 125}
"""What one texel of a stage costs, in directions of density.comp (5 ns on two cores): measured ratios. Points and
directions as printed are 501, 51, 1, 512, 1024 and 51."""


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

    starts_in_air: ClassVar[bool] = True  # the printed functions take cosines, too coarse in f32 from afar
    single_in_all: ClassVar[bool] = False  # all orders are one sum

    def quick(self) -> PaperSizes:
        """Of a first look."""
        return QUICK_PAPER

    def make(self, gpu: GpuScope, orders: int = 0) -> PaperTables:
        """Tables of these sizes. orders: of scattering; 0: as many as these sizes say."""
        return PaperTables(gpu, replace(self, orders=orders or self.orders))

    def probe(self, gpu: GpuScope) -> Compute:
        """The program that asks them."""
        return gpu.compute("atmosphere/paper/probe.comp")

    @property
    def scattering_texels(self) -> tuple[int, int, int]:
        """Width (nu and mu_s), height (mu) and depth (r) of the scattering tables."""
        r, mu, mu_s, nu = self.scattering
        return mu_s * nu, mu, r


QUICK_PAPER = PaperSizes((64, 32), (8, 24, 12, 4), (24, 8), 2, "rgba32f")
"""A first look at a new air."""


@dataclass(frozen=True)
class _Stage:
    """One table to fill: a compute program over a box of texels."""

    program: Any
    size: tuple[int, int, int]
    samples: int
    """that one texel costs"""
    bind: Callable[[], None]

    def box(self, done: int, samples: int) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
        """First texel and size of the slice after `done` texels: whole rows of one layer, or whole layers."""
        width, height, depth = self.size
        z, y = divmod(done // width, height)
        rows = max(1, samples // (self.samples * width))
        if y == 0 and rows >= height:
            return (0, 0, z), (width, height, min(rows // height, depth - z))
        return (0, y, z), (width, min(rows, height - y), 1)


class PaperTables:
    """The tables of one atmosphere, computed on the GPU a slice at a time.

    The air comes from the uniform block `air_model` (`generated/air_model.glsl`): it has to exist before
    this object and to be bound, unchanged, whenever step() is called; restart() after it changed. The tables are for a
    sun of irradiance 1. They hold what they should only once `done`; shaders read them through
    atmosphere/paper/functions.glsl.

    textures: transmittance, scattering, mie, irradiance -> texture.
    """

    def __init__(self, gpu: GpuScope, sizes: PaperSizes | None = None) -> None:
        self.sizes = sizes = sizes or PaperSizes()
        self._gpu = gpu
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

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of `arrays`."""
        return {name: (*reversed(texture.size), 4) for name, texture in self.textures.items()}

    def arrays(self) -> dict[str, NDArray[np.float32]]:
        """What the tables hold, read back as f32."""
        shapes = self.shapes()
        return {
            name: np.frombuffer(texture.read(), _DTYPES[texture.dtype]).astype(np.float32).reshape(shapes[name])
            for name, texture in self.textures.items()
        }

    def fill(self, arrays: Mapping[str, NDArray[np.float32]]) -> None:
        """Take over what `arrays` gave, instead of computing it."""
        for name, texture in self.textures.items():
            texture.write(np.ascontiguousarray(arrays[name], _DTYPES[texture.dtype]).tobytes())
        self._free_working()

    def bind(self) -> None:
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
        self._total = sum(stage.samples * math.prod(stage.size) for stage in self._stages)
        self._stage, self._texels, self._spent = 0, 0, 0

    @property
    def sources(self) -> str:
        """Names what computes the tables: equal for equal shaders, their includes and defines too."""
        return "|".join(program.linked.key for program in self._programs.values())

    @property
    def done(self) -> bool:
        """Whether all tables are final."""
        return self._stage == len(self._stages)

    @property
    def share(self) -> float:
        """How much of the work is done, 0..1."""
        return 1.0 if self.done else self._spent / self._total

    @property
    def spent(self) -> int:
        """Samples that have been computed."""
        return self._spent

    @property
    def stage(self) -> str:
        """Which table the next step is for."""
        program = self._stages[self._stage].program
        return next(name for name, made in self._programs.items() if made is program)

    def step(self, samples: int = 1_000_000) -> float:
        """Compute one slice: at least a row of a table, else about that many samples. Returns the share that is done.

        A million take 5 to 10 ms on two cores with Mesa's software renderer. It is one dispatch; its texture
        and image units hold other things afterwards.
        """
        if self.done:
            return 1.0
        stage = self._stages[self._stage]
        first, count = stage.box(self._texels, max(samples, 1))
        stage.bind()
        stage.program.set("u_first", first)
        stage.program.set("u_count", count)
        stage.program.run_over(*count)
        self._texels += math.prod(count)
        self._spent += stage.samples * math.prod(count)
        self._gpu.barrier()
        if self._texels == math.prod(stage.size):
            self._stage, self._texels = self._stage + 1, 0
            if self.done:
                self._free_working()
        return self.share

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
        units[PAPER_BEFORE_UNIT], units[PAPER_FLOOR_UNIT] = self._working["order"], self._working["floor"]
        if "density" in self._working:
            units[PAPER_DENSITY_UNIT] = self._working["density"]

        def bind() -> None:
            for unit, texture in units.items():
                texture.use(unit)
            for unit, texture in enumerate(images):
                texture.bind_to_image(unit, read=accumulates and unit == 1, write=True)

        return _Stage(self._programs[name], size, _SAMPLES[kind], bind)
