"""PathProbe: paths of light through the clouds that pictures show, any number of orders, by Monte-Carlo on the GPU.

The truth that the drawn light is measured against: slow, for benches and tests alone. Delta tracking through the drawn
density without any footprint, in vacuum, over a Lambert ground; assets/shaders/clouds/probe/paths.comp has the method.
Layers of ice are sheets of no thickness in pictures and none here: scenes come without.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Annotated, Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...components import Clouds
from ...engine.blocks.bindings import PATH_RAY_BUFFER, PLANET_BLOCK, WEATHER_STEEP_UNIT
from ...engine.blocks.layout import UInt, Vec3
from ...engine.frame.block import FrameBlock, PlanetBlock
from ...engine.gpu import GpuScope, StructLayout
from .field import CloudField
from .layers import has_cirrus
from .model import CloudModel
from .view_block import cloud_view_uniforms

__all__ = ["LITTLE", "PATHS", "PathProbe", "PathSums", "PathView"]

Floats = NDArray[np.float64]
_LANES = 4096
_TURNS = 2000
"""Of a dispatch, each a look at the density: a second or two without a GPU. Software rasterisers end loops after 65536
turns in all, inner ones included."""
PATHS = 16
"""Of a job."""
_BRANCHES = 4
"""Ways on from the first place of scattering, as one path."""
LITTLE = 0.02
"""Light of a unit sun below which chance decides whether its way to the sun is followed to the end."""
_ABOVE_M = 100.0
"""Above all cloud, where rays from farther away start."""
_OCTAHEDRAL = 2.0
"""Texels of a map of weather on the mean against the narrowest: widest and narrowest differ by (3 sqrt 3)^(1/2)."""


@dataclass
class PathRay:
    """One ray, from the anchor."""

    start: Vec3
    skipped_m: Annotated[float, "empty space before it"]
    way: Vec3
    clear_m: Annotated[float, "from the start on, in which nothing is met; found by clouds/probe/path_clear.comp"]


@dataclass
class PathLane:
    """What a lane keeps of its path and of its job."""

    at: Vec3
    bound: Annotated[float, "1/m, of the flight that ended here on a place of chance; 0: at the end of its reach"]
    way: Vec3
    light: Annotated[float, "of the path so far, for a unit sun"]
    place: Annotated[Vec3, "of scattering"]
    carried: Annotated[float, "on the way to the sun: what is left"]
    came: Annotated[Vec3, "where the path went before; on ground the zenith"]
    asymmetry: float
    share: Annotated[float, "that is scattered there"]
    place_bound: float
    place_reach: float
    first: Annotated[Vec3, "place of scattering of the path: from there others go on"]
    first_share: float
    first_came: Vec3
    first_asymmetry: float
    first_bound: float
    first_reach: float
    branch: Annotated[int, "number of the one that is followed"]
    worst: Annotated[float, "largest extinction met over its bound: above 1 no result can be trusted"]
    mode: int
    kind: int
    orders: int
    done: Annotated[int, "paths of the job"]
    job: UInt
    draw: Annotated[UInt, "numbers drawn by the path"]
    sum: float
    square: float
    met_cloud: float


@dataclass(frozen=True)
class PathView:
    """N rays from one camera.

    position_m (3,): planet-centred; ways (N, 3): of any length; right, above (3,): a pixel's width and height in the
    measure of `ways` (zeros: rays of no width); sun (3,): unit, towards it; orders: of scattering by droplets, at most.
    """

    position_m: Floats
    ways: Floats
    right: Floats
    above: Floats
    sun: Floats
    sun_radius_rad: float = 0.0
    ground_albedo: float = 0.0
    orders: int = 1 << 30


@dataclass
class PathSums:
    """Of N rays: how many paths, sums of their light (per unit irradiance, 1/sr) and of its square, how many met cloud.
    Light of ground that a ray ends on is not in it."""

    count: Floats
    light: Floats
    square: Floats
    met: Floats

    @staticmethod
    def none(rays: int) -> PathSums:
        """Before the first path."""
        return PathSums(*(np.zeros(rays) for _ in range(4)))

    @property
    def mean(self) -> Floats:
        """(N,) radiance."""
        return self.light / np.maximum(self.count, 1.0)

    @property
    def error(self) -> Floats:
        """(N,) standard error of the mean; infinite for fewer than two paths."""
        variance = np.maximum(self.square / np.maximum(self.count, 1.0) - self.mean**2, 0.0)
        return np.where(self.count > 1.0, np.sqrt(variance / np.maximum(self.count - 1.0, 1.0)), np.inf)

    @property
    def opacity(self) -> Floats:
        """(N,) share of the light from behind that clouds take."""
        return self.met / np.maximum(self.count, 1.0)


class PathProbe:
    """One planet's clouds and the program that follows paths through them. gpu: owner of all GL objects.

    ValueError for layers of ice. plain: without bounds of the density, for a test of those.
    """

    def __init__(
        self, gpu: GpuScope, component: Clouds, model: CloudModel, settings: Mapping[str, Any], plain: bool = False
    ) -> None:
        self._gpu, self._model = gpu, model
        gpu.shaders.add_virtual("generated/frame.glsl", f"{StructLayout(FrameBlock).glsl}FrameBlock frame;\n")
        self._rays, self._lanes = StructLayout(PathRay, "std430"), StructLayout(PathLane, "std430")
        gpu.shaders.add_virtual("generated/paths.glsl", self._rays.glsl + self._lanes.glsl)
        self._planet = gpu.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")
        self._planet.write(PlanetBlock(model.radius_m, 0.0, 0.0, 0.0, 0.0, has_sea=False))
        self._block = cloud_view_uniforms(gpu)
        self.field = CloudField(gpu, settings)
        self.field.take(component)
        if has_cirrus(self.field.layers):
            raise ValueError("PathProbe: layers of ice are sheets of no thickness; take them out of the scene")
        self.field.light(model)
        defines = {"PATH_BRANCHES": _BRANCHES, **({"PATH_PLAIN": 1} if plain else {})}
        self._program = gpu.compute("clouds/probe/paths.comp", defines)
        self._clear = gpu.compute("clouds/probe/path_clear.comp", defines)
        self._steep: moderngl.Texture | None = None
        self.worst = 0.0
        """Largest extinction met over the bound that it was promised to stay below."""

    def place(self, view: PathView, time_s: float = 0.0) -> None:
        """The rays of the next `follow`, and the moment of their weather."""
        radius, top = self._model.radius_m, self._model.radius_m + self._model.highest_m + _ABOVE_M
        ways = view.ways / np.linalg.norm(view.ways, axis=1, keepdims=True)
        along = ways @ view.position_m
        miss = np.linalg.norm(np.cross(view.position_m, ways), axis=1)
        half_chord = np.sqrt(np.maximum((top - miss) * (top + miss), 0.0))
        enters = (np.linalg.norm(view.position_m) > top) & (along < 0.0) & (miss < top)
        skipped = np.where(enters, -along - half_chord, 0.0)
        starts = view.position_m + skipped[:, None] * ways
        # Places count from the ground below the middle of where rays enter.
        foot = starts[enters].mean(0) if enters.any() else view.position_m
        up = foot / np.linalg.norm(foot)
        anchor = up * radius
        records = np.zeros(len(ways), self._rays.dtype)
        records["start"], records["skipped_m"], records["way"] = starts - anchor, skipped, view.ways
        self.field.maps.charts.exact(time_s)
        self.field.place(anchor, radius, time_s)
        self._block.write(self.field.block)
        if self._steep is not None:
            self._gpu.free(self._steep)
        self._steep, steepest = self._weather_steep(), self._steepest()
        for program in (self._clear, self._program):
            program.set("u_steepest", steepest)
            program.set("u_layers", len(self.field.layers))
            program.set("u_up", tuple(map(float, up)))
            program.set("u_right", tuple(map(float, view.right)))
            program.set("u_above", tuple(map(float, view.above)))
        give = self._program.set
        give("u_sun", tuple(map(float, view.sun)))
        give("u_sun_radius_rad", view.sun_radius_rad)
        give("u_ground", view.ground_albedo)
        give("u_orders", view.orders)
        self._records = records
        self._find_clear(records)

    def _find_clear(self, records: NDArray[Any]) -> None:
        """What the rays have before them without any cloud."""
        rays = self._gpu.buffer(records.tobytes())
        try:
            self._bind()
            rays.bind_to_storage_buffer(PATH_RAY_BUFFER)
            self._clear.set("u_rays", len(records))
            self._clear.run_over(len(records))
            self._gpu.ctx.memory_barrier()
            records["clear_m"] = np.frombuffer(rays.read(), records.dtype)["clear_m"]
        finally:
            self._gpu.free(rays)

    def _bind(self) -> None:
        self._planet.bind()
        self._block.bind()
        self.field.bind()
        assert self._steep is not None
        self._steep.use(WEATHER_STEEP_UNIT)

    def _steepest(self) -> tuple[float, float]:
        """1/m: steepest gradients of the volume of shapes and of that of cells, as wide as the first layer has them."""
        block = self.field.block
        shape, cells = (_steepest_texel(volume.texture) for volume in (self.field.shape, self.field.cells))
        return shape * block.broad.per_m, cells * block.wide.per_m

    def _weather_steep(self) -> moderngl.Texture:
        """By texel of the maps of weather: 1/m of cover, and the most of towers and of depth, around it."""
        steps = []
        for held in self.field.maps.shown:
            raw = np.frombuffer(held.read(), np.uint8).reshape(*held.size[::-1], 4).astype(np.float32) / 255.0
            found = [np.abs(np.diff(raw, axis=axis, append=raw.take([-1], axis))) for axis in (0, 1)]
            steps.append(np.hypot(*(_most_around(step, 2) for step in found)))
        most = np.maximum(*steps) * (_OCTAHEDRAL / self.field.block.map_texel_m)
        both = np.stack([most[..., 0], np.maximum(most[..., 1], most[..., 3])], axis=2)
        size = (both.shape[1], both.shape[0])
        return self._gpu.texture(size, "rg32f", np.ascontiguousarray(both, np.float32), filter="nearest")

    def follow(self, sums: PathSums, jobs: NDArray[np.intp], seed: int = 1, until: float = np.inf) -> PathSums:
        """So many further jobs of PATHS paths for each ray, (N,), behind those in `sums`. until: monotonic time after
        which none is begun; those that were are finished, so that long paths are not missed."""
        which = np.repeat(np.arange(len(jobs)), jobs)
        # Rows of rays mixed: jobs beside one another are about as long, and what is left at the end is little.
        first = np.concatenate([np.arange(n) for n in jobs]) if len(which) else which
        listed = np.stack([which, PATHS * first + sums.count[which].astype(np.intp)], axis=1).astype(np.uint32)
        if not len(listed):
            return sums
        results = self._run(listed, seed, until)
        done = results[:, 3] > 0.0
        add = [np.bincount(which[done], results[done, k].astype(np.float64), len(jobs)) for k in range(3)]
        count = PATHS * np.bincount(which[done], minlength=len(jobs))
        return PathSums(sums.count + count, sums.light + add[0], sums.square + add[1], sums.met + add[2])

    def _run(self, jobs: NDArray[np.uint32], seed: int, until: float) -> NDArray[np.float32]:
        lanes = np.zeros(_LANES, self._lanes.dtype)
        lanes["mode"] = _IDLE
        made = [
            self._gpu.buffer(self._records.tobytes()), self._gpu.buffer(jobs.tobytes()),
            self._gpu.buffer(np.zeros((len(jobs), 4), np.float32).tobytes()), self._gpu.buffer(lanes.tobytes()),
            self._gpu.buffer(np.zeros(1, np.uint32).tobytes()),
        ]  # fmt: skip
        program, most = self._program, len(jobs)
        try:
            self._bind()
            for number, buffer in enumerate(made, PATH_RAY_BUFFER):
                buffer.bind_to_storage_buffer(number)
            for name, value in (("u_turns", _TURNS), ("u_paths", PATHS), ("u_little", LITTLE), ("u_seed", seed)):
                program.set(name, value)
            while True:
                program.set("u_jobs", most)
                program.run(_LANES // 64)
                self._gpu.ctx.memory_barrier()
                begun = int(np.frombuffer(made[4].read(), np.uint32)[0])
                if begun < most and monotonic() > until:
                    most = begun
                if begun >= most:
                    held = np.frombuffer(made[3].read(), self._lanes.dtype)
                    if (held["mode"] == _IDLE).all():
                        break
            self.worst = max(self.worst, float(held["worst"].max()))
            return np.frombuffer(made[2].read(), np.float32).reshape(-1, 4)
        finally:
            for buffer in made:
                self._gpu.free(buffer)


_IDLE = 2


def _most_around(values: NDArray[np.float32], reach: int) -> NDArray[np.float32]:
    """The largest of the values (rows, columns, N) up to so many rows and columns away."""
    for axis in (0, 1):
        width = [(reach, reach) if a == axis else (0, 0) for a in range(3)]
        padded, count = np.pad(values, width, mode="edge"), values.shape[axis]
        values = np.max([padded.take(range(k, k + count), axis) for k in range(2 * reach + 1)], axis=0)
    return values


def _steepest_texel(texture: moderngl.Texture) -> float:
    """Length of the steepest gradient of a volume of noise, per period."""
    size = texture.size[0]
    dtype = np.float32 if texture.dtype == "f4" else np.float16
    return size * _steepest_cell(np.frombuffer(texture.read(), dtype).astype(np.float32).reshape(size, size, size))


def _steepest_cell(volume: NDArray[np.float32]) -> float:
    """Length of the steepest gradient of a volume (n, n, n) that wraps, interpolated between texels, per texel."""
    square = np.zeros_like(volume)
    for axis in range(3):
        step = np.abs(np.roll(volume, -1, axis) - volume)
        for other in {0, 1, 2} - {axis}:  # the four edges of a cell along the axis
            step = np.maximum(step, np.roll(step, -1, other))
        square += step * step
    return float(np.sqrt(square.max()))
